// The figures of stores alone: quick to build while working on them. Prints the same figures as
// ./dev bench store.
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/benchmarks/server/measured_server.h"
#include "tests/benchmarks/store/store_benchmarks.h"
#include "tests/benchmarks/usage.h"

namespace {

constexpr char kUsage[] =
    "cwm-bench-store [all|writers|overhead|cost|replay|faults] [--server PROGRAM] [--other "
    "PROGRAM]\n"
    "                [--dir DIRECTORY] [--json FILE]\n"
    "--server measures another cwm-server than the one beside this program; --other is the one\n"
    "that the cost without a store is measured beside. Stores are made in DIRECTORY, which must "
    "lie\non a disk.\n";

}  // namespace

int main(int argc, char** argv) {
  using namespace cwm::benchmarks;
  if (PrintsUsage(argc, argv, kUsage)) return 0;
  StoreBenchmarkOptions options = DefaultStoreBenchmarkOptions();
  std::string json, server;
  const std::map<std::string, std::string*> words = {{"--json", &json},
                                                     {"--server", &server},
                                                     {"--other", &options.other_program},
                                                     {"--dir", &options.directory}};
  std::string part = "all";
  for (int i = 1; i < argc; ++i) {
    const auto option = words.find(argv[i]);
    if (option != words.end() && i + 1 < argc) {
      *option->second = argv[++i];
    } else {
      part = argv[i];
    }
  }
  using Measure = std::function<void(const StoreBenchmarkOptions&, Report&)>;
  const std::vector<std::pair<std::string, Measure>> parts = {{"writers", MeasureDurableWriters},
                                                              {"overhead", MeasureDurableOverhead},
                                                              {"cost", MeasureStoreCost},
                                                              {"replay", MeasureReplay},
                                                              {"faults", ReportFaults}};
  if (!server.empty()) UseServerProgram(server);
  Report report;
  bool is_known = false;
  for (const auto& [name, measure] : parts) {
    if (part != "all" && part != name) continue;
    is_known = true;
    measure(options, report);
  }
  if (!is_known) report.Fail("unknown word " + part + "\n" + kUsage);
  report.Print();
  if (!json.empty()) report.WriteJson(json);
  return report.failed() ? 1 : 0;
}
