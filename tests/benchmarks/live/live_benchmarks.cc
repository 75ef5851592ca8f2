#include "tests/benchmarks/live/live_benchmarks.h"

namespace cwm::benchmarks {

std::vector<std::pair<std::string, std::function<void(Report&)>>> LiveParts(
    const LiveBenchmarkOptions& options) {
  using Part = std::function<void(Report&)>;
  const auto repeated = [&](double minutes, void (*measure)(const SceneOptions&, Report&)) -> Part {
    return [scenes = SceneOptions{.minutes = options.minutes.value_or(minutes),
                                  .samples = options.samples},
            measure](Report& report) { measure(scenes, report); };
  };
  const double soak_minutes = options.minutes.value_or(30);
  return {{"yardstick", MeasureLiveYardstick},
          {"change", MeasureLiveChange},
          {"static", MeasureLiveStatic},
          {"revisions", MeasureLiveRevisions},
          {"cpu", MeasureLiveCpu},
          {"load", MeasureLiveLoad},
          {"truth", repeated(3, MeasureLiveTruth)},
          {"hand", MeasureLiveHand},
          {"arm", repeated(3, MeasureLiveArm)},
          {"real", MeasureLiveReal},
          {"fusion", repeated(4, MeasureLiveFusion)},
          {"order", repeated(4, MeasureLiveOrder)},
          {"trace", repeated(4, MeasureLiveTrace)},
          {"soak", [soak_minutes](Report& report) { MeasureLiveSoak(soak_minutes, report); }}};
}

void MeasureLive(Report& report) {
  for (const auto& [name, measure] : LiveParts()) measure(report);
}

}  // namespace cwm::benchmarks
