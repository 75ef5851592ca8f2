// The figures of live sensors alone: quick to build while working on them. Prints the same figures
// as ./dev bench live.
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/benchmarks/live/live_benchmarks.h"
#include "tests/benchmarks/server/measured_server.h"
#include "tests/benchmarks/usage.h"

namespace {

constexpr char kUsage[] =
    "cwm-bench-live [PART] [--server PROGRAM] [--minutes N] [--json FILE]\n"
    "PART is all, yardstick, change, static, cpu, load, truth, hand, arm, real, fusion, order or\n"
    "soak. --server measures another cwm-server than the one beside this program; the soak takes\n"
    "N minutes (30).\n";

}  // namespace

int main(int argc, char** argv) {
  using namespace cwm::benchmarks;
  if (PrintsUsage(argc, argv, kUsage)) return 0;
  std::string json, server, minutes = "30";
  const std::map<std::string, std::string*> words = {
      {"--json", &json}, {"--server", &server}, {"--minutes", &minutes}};
  std::string part = "all";
  for (int i = 1; i < argc; ++i) {
    const auto option = words.find(argv[i]);
    if (option != words.end() && i + 1 < argc) {
      *option->second = argv[++i];
    } else {
      part = argv[i];
    }
  }
  if (!server.empty()) UseServerProgram(server);
  LiveBenchmarkOptions options;
  options.soak_minutes = std::strtod(minutes.c_str(), nullptr);
  if (!(options.soak_minutes > 0)) {
    std::fprintf(stderr, "--minutes is %s, must be a positive number\n", minutes.c_str());
    return 1;
  }
  Report report;
  bool is_known = false;
  for (const auto& [name, measure] : LiveParts(options)) {
    if (part != "all" && part != name) continue;
    is_known = true;
    measure(report);
  }
  if (!is_known) report.Fail("unknown word " + part + "\n" + kUsage);
  report.Print();
  if (!json.empty()) report.WriteJson(json);
  return report.failed() ? 1 : 0;
}
