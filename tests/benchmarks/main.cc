// ./dev bench: figures with their rivals, or micro-benchmarks by name.
//   cwm-bench main [--json FILE]     the table of the main job
//   cwm-bench REGEX                  micro-benchmarks whose names match
#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "tests/benchmarks/benchmarks.h"

int main(int argc, char** argv) {
  std::string selection = "main", json;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--json") == 0 && i + 1 < argc) {
      json = argv[++i];
    } else {
      selection = argv[i];
    }
  }
  if (selection != "main") {
    std::string filter = "--benchmark_filter=" + selection;
    std::vector<char*> arguments = {argv[0], filter.data()};
    int count = static_cast<int>(arguments.size());
    benchmark::Initialize(&count, arguments.data());
    return benchmark::RunSpecifiedBenchmarks() > 0 ? 0 : 1;
  }
  cwm::benchmarks::Report report;
  cwm::benchmarks::MeasureInterpreter(report);
  cwm::benchmarks::MeasureEngines(report);
  cwm::benchmarks::MeasureService(report);
  report.Print();
  if (!json.empty()) report.WriteJson(json);
  return 0;
}
