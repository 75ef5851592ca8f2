#include <cstdio>
#include <utility>

#include "tests/benchmarks/live/live_benchmarks.h"
#include "tests/benchmarks/live/live_scenes.h"
#include "tests/benchmarks/live/yardstick.h"
#include "tests/benchmarks/server/server_benchmarks.h"

namespace cwm::benchmarks {
namespace {

constexpr int kFrames = 20;

std::optional<double> MeasureYardstick_ms(Report& report) {
  const perception::SequenceRenderer renderer(TableScript({.thing_count = 20}));
  std::vector<RecordedFrame> frames;
  for (TrueFrame& frame : RenderFrames(renderer, 0, 0, kFrames)) {
    frames.push_back(std::move(frame.frame));
  }
  const auto times_ms = InsertIntoOctoMap_ms(frames);
  if (!times_ms) {
    report.Detail("no yardstick: liboctomap-dev was not installed when the benchmarks were built");
    return std::nullopt;
  }
  const double median_ms = Median(*times_ms);
  report.Add({.key = "live_yardstick_ms",
              .value = median_ms,
              .unit = "ms",
              .how = "median processor time of insertPointCloud, discretized, of a static frame "
                     "into an OctoMap "
                     "at 2.5 cm, one thread, 20 frames"});
  return median_ms;
}

}  // namespace

std::optional<double> Yardstick_ms(Report& report) {
  static const std::optional<double> yardstick_ms = MeasureYardstick_ms(report);
  return yardstick_ms;
}

void MeasureLiveYardstick(Report& report) { Yardstick_ms(report); }

Figure BesideYardstick(Figure figure, double limit, std::optional<double> asked_ratio,
                       Report& report) {
  if (const auto yardstick_ms = Yardstick_ms(report)) {
    char text[100];
    std::snprintf(text, sizeof(text), "; %.2f x the yardstick of this run",
                  figure.value / *yardstick_ms);
    figure.how += text;
    if (asked_ratio) {
      std::snprintf(text, sizeof(text), ", at most %.2f x asked", *asked_ratio);
      figure.how += text;
    }
  }
  return WithLimit(std::move(figure), limit);
}

}  // namespace cwm::benchmarks
