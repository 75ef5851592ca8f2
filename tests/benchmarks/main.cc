// ./dev bench: figures with their rivals by group, or micro-benchmarks by name.
//   cwm-bench [main|perception|collision|people] [--json FILE]
//   cwm-bench REGEX                  micro-benchmarks whose names match
#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstring>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/benchmarks/benchmarks.h"

namespace {

using cwm::benchmarks::Report;

const std::map<std::string, std::vector<std::function<void(Report&)>>>& Groups() {
  using namespace cwm::benchmarks;
  static const std::map<std::string, std::vector<std::function<void(Report&)>>> groups = {
      {"main", {MeasureInterpreter, MeasureEngines, MeasureService}},
      {"perception", {MeasureInterpreter}},
      {"collision", {MeasurePairs, MeasureEngines, MeasureWorlds}},
      {"people", {}},
  };
  return groups;
}

int RunMatching(char* program, const std::string& regex) {
  std::string filter = "--benchmark_filter=" + regex;
  std::vector<char*> arguments = {program, filter.data()};
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  return benchmark::RunSpecifiedBenchmarks() > 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  std::string selection = "main", json;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--json") == 0 && i + 1 < argc) {
      json = argv[++i];
    } else {
      selection = argv[i];
    }
  }
  const auto group = Groups().find(selection);
  if (group == Groups().end()) return RunMatching(argv[0], selection);
  Report report;
  if (group->second.empty()) {
    std::printf("no benchmark of the group %s exists yet\n", selection.c_str());
  }
  for (const auto& measure : group->second) measure(report);
  report.Print();
  if (!json.empty()) report.WriteJson(json);
  return report.failed() ? 1 : 0;
}
