#include "tests/benchmarks/live/live_benchmarks.h"

namespace cwm::benchmarks {

std::vector<std::pair<std::string, std::function<void(Report&)>>> LiveParts(
    const LiveBenchmarkOptions& options) {
  const double soak_minutes = options.soak_minutes;
  return {{"yardstick", MeasureLiveYardstick},
          {"change", MeasureLiveChange},
          {"static", MeasureLiveStatic},
          {"cpu", MeasureLiveCpu},
          {"load", MeasureLiveLoad},
          {"truth", MeasureLiveTruth},
          {"hand", MeasureLiveHand},
          {"arm", MeasureLiveArm},
          {"real", MeasureLiveReal},
          {"fusion", MeasureLiveFusion},
          {"order", MeasureLiveOrder},
          {"soak", [soak_minutes](Report& report) { MeasureLiveSoak(soak_minutes, report); }}};
}

void MeasureLive(Report& report) {
  for (const auto& [name, measure] : LiveParts()) measure(report);
}

}  // namespace cwm::benchmarks
