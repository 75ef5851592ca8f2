#include "tests/benchmarks/live/live_benchmarks.h"

namespace cwm::benchmarks {

const std::vector<std::pair<std::string, std::function<void(Report&)>>>& LiveParts() {
  static const std::vector<std::pair<std::string, std::function<void(Report&)>>> parts = {
      {"yardstick", MeasureLiveYardstick},
      {"change", MeasureLiveChange},
      {"static", MeasureLiveStatic},
      {"cpu", MeasureLiveCpu},
      {"load", MeasureLiveLoad},
      {"truth", MeasureLiveTruth},
      {"hand", MeasureLiveHand},
      {"arm", MeasureLiveArm},
      {"real", MeasureLiveReal}};
  return parts;
}

void MeasureLive(Report& report) {
  for (const auto& [name, measure] : LiveParts()) measure(report);
}

}  // namespace cwm::benchmarks
