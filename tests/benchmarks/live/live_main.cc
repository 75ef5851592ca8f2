// The figures of live sensors alone: quick to build while working on them. Prints the same figures
// as ./dev bench live.
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
    "cwm-bench-live [all|yardstick|change|static|cpu|load|truth|hand|arm|real]\n"
    "               [--server PROGRAM] [--json FILE]\n"
    "--server measures another cwm-server than the one beside this program.\n";

}  // namespace

int main(int argc, char** argv) {
  using namespace cwm::benchmarks;
  if (PrintsUsage(argc, argv, kUsage)) return 0;
  std::string json, server;
  const std::map<std::string, std::string*> words = {{"--json", &json}, {"--server", &server}};
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
  Report report;
  bool is_known = false;
  for (const auto& [name, measure] : LiveParts()) {
    if (part != "all" && part != name) continue;
    is_known = true;
    measure(report);
  }
  if (!is_known) report.Fail("unknown word " + part + "\n" + kUsage);
  report.Print();
  if (!json.empty()) report.WriteJson(json);
  return report.failed() ? 1 : 0;
}
