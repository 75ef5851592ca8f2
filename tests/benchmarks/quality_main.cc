// The quality of perception without a server: quick to build where perception is worked on. The same
// figures as ./dev bench perception prints.
//   cwm-bench-quality [quick|shapes|tof|handles|claims|scene FAMILY SEED] [--json FILE]
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/benchmarks/benchmarks.h"

int main(int argc, char** argv) {
  using namespace cwm::benchmarks;
  const std::map<std::string, std::function<void(Report&)>> parts = {
      {"quick", MeasureShapesQuickly}, {"shapes", MeasureShapes}, {"handles", MeasureHandles},
      {"tof", MeasureTimeOfFlight},    {"claims", MeasureClaims},
  };
  std::vector<std::string> words;
  std::string json;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--json") == 0 && i + 1 < argc) {
      json = argv[++i];
    } else {
      words.emplace_back(argv[i]);
    }
  }
  if (words.empty()) words.emplace_back("quick");
  Report report;
  const auto part = parts.find(words[0]);
  if (part != parts.end()) {
    part->second(report);
  } else if (words[0] == "scene" && words.size() == 3) {
    ReplayScene(words[1], std::strtoull(words[2].c_str(), nullptr, 10), report);
  } else {
    report.Fail("takes quick, shapes, tof, handles, claims, or scene FAMILY SEED");
  }
  report.Print();
  if (!json.empty()) report.WriteJson(json);
  return report.failed() ? 1 : 0;
}
