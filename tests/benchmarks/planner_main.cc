#include <cstdlib>
#include <cstring>
#include <string>
#include "tests/benchmarks/planner_benchmarks.h"
int main(int argc, char** argv) {
  cwm::benchmarks::PlannerMeasure m; cwm::benchmarks::Report report;
  for (int i = 1; i + 1 < argc; i += 2) {
    std::string a = argv[i]; const double v = atof(argv[i + 1]);
    if (a == "--step") m.step = (size_t)v;
    if (a == "--first") m.first = (size_t)v;
    if (a == "--fcl") m.beside_fcl = v > 0;
    if (a == "--range") m.options.connect.range = v;
    if (a == "--samples") m.options.connect.samples = (int)v;
    if (a == "--seed") m.options.seed = (unsigned)v;
    if (a == "--rounds") m.options.shortening.rounds = (int)v;
    if (a == "--cuts") m.options.shortening.cuts = (int)v;
    if (a == "--time") m.options.time_limit_s = v;
  }
  cwm::benchmarks::MeasurePlanner(m, report);
  report.Print();
  return report.failed();
}
