// The figures of the server under attack, against a real server: quick to build while working on
// the server. Prints the same figures as ./dev bench server.
#include <cstring>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/benchmarks/server/measured_server.h"
#include "tests/benchmarks/server/server_benchmarks.h"
#include "tests/benchmarks/usage.h"

namespace {

constexpr char kUsage[] =
    "cwm-bench-server [all|amplification [REGEX]|stops|overload|listener|memory|costs]\n"
    "                 [--server PROGRAM] [--other PROGRAM] [--json FILE]\n"
    "--server measures another cwm-server than the one beside this program; --other is the one "
    "that\n"
    "the costs are measured beside.\n";

}  // namespace

int main(int argc, char** argv) {
  using namespace cwm::benchmarks;
  if (PrintsUsage(argc, argv, kUsage)) return 0;
  std::string json, server, other;
  const std::map<std::string, std::string*> options = {
      {"--json", &json}, {"--server", &server}, {"--other", &other}};
  std::vector<std::string> words;
  for (int i = 1; i < argc; ++i) {
    const auto option = options.find(argv[i]);
    if (option != options.end() && i + 1 < argc) {
      *option->second = argv[++i];
    } else {
      words.emplace_back(argv[i]);
    }
  }
  if (words.empty()) words.emplace_back("all");
  const std::map<std::string, std::function<void(Report&)>> parts = {
      {"stops", MeasureStops},
      {"overload", MeasureOverload},
      {"listener", MeasureListener},
      {"memory", MeasureMemoryReturned}};
  if (!server.empty()) UseServerProgram(server);
  Report report;
  if (words[0] == "all" && words.size() == 1) {
    MeasureServer(report);
    if (!other.empty()) MeasureCostsBeside(other, report);
  } else if (words[0] == "amplification" && words.size() <= 2) {
    MeasureAmplificationOf(words.size() == 2 ? words[1] : "", report);
  } else if (words[0] == "costs" && words.size() == 1 && !other.empty()) {
    MeasureCostsBeside(other, report);
  } else if (parts.count(words[0]) > 0 && words.size() == 1) {
    parts.at(words[0])(report);
  } else {
    report.Fail(
        "takes all, amplification [REGEX], stops, overload, listener, memory, or costs --other "
        "PROGRAM; with --server PROGRAM and --json FILE");
  }
  report.Print();
  if (!json.empty()) report.WriteJson(json);
  return report.failed() ? 1 : 0;
}
