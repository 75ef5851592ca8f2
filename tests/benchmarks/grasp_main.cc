// The figures of grasps alone: quick to build while working on the planner.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/usage.h"

int main(int argc, char** argv) {
  constexpr char kUsage[] = "cwm-bench-grasp [--first-seed N] [--seeds N] [--json FILE]\n";
  if (cwm::benchmarks::PrintsUsage(argc, argv, kUsage)) return 0;
  cwm::benchmarks::Seeds seeds = cwm::benchmarks::kSeedsOfGrasps;
  std::string json;
  for (int i = 1; i < argc; ++i) {
    const bool known = i + 1 < argc;
    if (known && std::strcmp(argv[i], "--first-seed") == 0) {
      seeds.first = std::strtoull(argv[++i], nullptr, 10);
    } else if (known && std::strcmp(argv[i], "--seeds") == 0) {
      seeds.count = std::atoi(argv[++i]);
    } else if (known && std::strcmp(argv[i], "--json") == 0) {
      json = argv[++i];
    } else {
      std::fprintf(stderr, "unknown option %s\n%s", argv[i], kUsage);
      return 1;
    }
  }
  cwm::benchmarks::Report report;
  MeasureGraspsOn(seeds, report);
  report.Print();
  if (!json.empty()) report.WriteJson(json);
  return report.failed() ? 1 : 0;
}
