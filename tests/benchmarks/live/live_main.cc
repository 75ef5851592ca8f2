// The figures of live sensors alone, all or by parts. Prints the same figures as ./dev bench live.
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
    "cwm-bench-live [PART...] [--minutes N] [--samples FILE] [--server PROGRAM] [--json FILE]\n"
    "PART is all (without the soak), yardstick, change, static, revisions, cpu, load, truth, "
    "hand,\n"
    "arm, real, fusion, order, trace or soak. truth, arm, fusion, order and trace repeat scenes:\n"
    "they begin none after N minutes (3, 3, 4, 4, 4), and with FILE they go on after the scenes\n"
    "that it has, and add theirs, so that the figures are those of all calls. The soak takes N\n"
    "minutes (30). --server measures another cwm-server than the one beside this program.\n";

}  // namespace

int main(int argc, char** argv) {
  using namespace cwm::benchmarks;
  if (PrintsUsage(argc, argv, kUsage)) return 0;
  std::string json, server, minutes;
  LiveBenchmarkOptions options;
  const std::map<std::string, std::string*> words = {{"--json", &json},
                                                     {"--server", &server},
                                                     {"--minutes", &minutes},
                                                     {"--samples", &options.samples}};
  std::vector<std::string> asked;
  for (int i = 1; i < argc; ++i) {
    const auto option = words.find(argv[i]);
    if (option != words.end() && i + 1 < argc) {
      *option->second = argv[++i];
    } else {
      asked.emplace_back(argv[i]);
    }
  }
  if (!server.empty()) UseServerProgram(server);
  if (!minutes.empty()) {
    options.minutes = std::strtod(minutes.c_str(), nullptr);
    if (!(*options.minutes > 0)) {
      std::fprintf(stderr, "--minutes is %s, must be a positive number\n", minutes.c_str());
      return 1;
    }
  }
  const auto parts = LiveParts(options);
  if (asked.empty()) asked = {"all"};
  Report report;
  for (const std::string& word : asked) {
    bool is_known = false;
    for (const auto& [name, measure] : parts) {
      if (word != name && (word != "all" || name == "soak")) continue;
      is_known = true;
      measure(report);
    }
    if (!is_known) report.Fail("unknown word " + word + "\n" + kUsage);
  }
  report.Print();
  if (!json.empty()) report.WriteJson(json);
  return report.failed() ? 1 : 0;
}
