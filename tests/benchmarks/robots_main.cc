// Robots in planning problems without the rest: quick to build where collision is worked on. The same
// figures as ./dev bench collision-robots, collision-motions and collision-spheres print.
//   cwm-bench-robots [meshes|differences|motions|spheres] [--json FILE]
#include <string>
#include <vector>

#include "tests/benchmarks/benchmarks.h"

int main(int argc, char** argv) {
  std::string part = "spheres", json;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--json" && i + 1 < argc) {
      json = argv[++i];
    } else {
      part = word;
    }
  }
  cwm::benchmarks::Report report;
  if (part == "meshes") {
    cwm::benchmarks::MeasureRobots(report);
  } else if (part == "differences") {
    cwm::benchmarks::MeasureUnexplained(report);
  } else if (part == "spheres") {
    cwm::benchmarks::MeasureSpheres(report);
  } else if (part == "motions") {
    cwm::benchmarks::MeasureMotions(report);
  } else {
    report.Fail("takes meshes, differences, motions or spheres");
  }
  report.Print();
  if (!json.empty()) report.WriteJson(json);
  return report.failed() ? 1 : 0;
}
