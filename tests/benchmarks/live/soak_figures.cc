// Memory and latency while a thing is pushed to and fro, for half an hour.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "tests/benchmarks/live/live_benchmarks.h"
#include "tests/benchmarks/live/live_scenes.h"
#include "tests/benchmarks/live/live_world.h"
#include "tests/benchmarks/server/server_benchmarks.h"

namespace cwm::benchmarks {
namespace {

// A period of PushedThing, to and fro.
constexpr double kPeriod_s = 4;
constexpr double kSettle_s = 2;
constexpr int kPeriodsOfARound = 5;
constexpr double kWarmUpShare = 1.0 / 3;

// What a round of frames cost.
struct Round {
  double end_s = 0;  // since the first round
  std::int64_t bytes = 0;
  double p95_ms = 0;  // of the answers
  double cpu_ms = 0;  // of the server, by processed frame
  int processed = 0, moved = 0;
};

Round RoundOf(const std::vector<FrameAnswer>& answers, std::size_t first) {
  Round round;
  std::vector<double> times_ms;
  for (std::size_t i = first; i < answers.size(); ++i) {
    if (!answers[i].is_processed()) continue;
    times_ms.push_back(answers[i].Answer_ms());
    round.moved += answers[i].response.changes().moved_size() > 0;
  }
  round.processed = static_cast<int>(times_ms.size());
  if (!times_ms.empty()) round.p95_ms = Quantile(times_ms, 0.95);
  return round;
}

// The slope of the line of least squares, MiB a minute.
double GrowthPerMinute_MiB(const std::vector<Round>& rounds) {
  double t = 0, m = 0, tt = 0, tm = 0;
  for (const Round& round : rounds) {
    const double minutes = round.end_s / 60;
    const double mebi = static_cast<double>(round.bytes) / kMebi;
    t += minutes;
    m += mebi;
    tt += minutes * minutes;
    tm += minutes * mebi;
  }
  const auto n = static_cast<double>(rounds.size());
  const double spread = n * tt - t * t;
  return spread > 0 ? (n * tm - t * m) / spread : 0;
}

}  // namespace

void MeasureLiveSoak(double minutes, Report& report) {
  const double round_s = kPeriodsOfARound * kPeriod_s;
  const perception::SequenceRenderer renderer(
      PushedThing(kSettle_s, {.duration_s = kSettle_s + round_s}));
  auto still = RenderFrames(renderer, 0, 0, static_cast<int>(kSettle_s * 30));
  auto loop =
      RenderFrames(renderer, 0, static_cast<int>(kSettle_s * 30), static_cast<int>(round_s * 30));
  LiveWorld world;
  if (!world.up()) return report.Fail("the server does not come up");
  LiveSensor& sensor = world.AddSensor("camera_1", still.front().frame);
  if (const std::string error = Settle(world, sensor, still); !error.empty()) {
    return report.Fail(error);
  }
  const auto start = SteadyClock::now();
  std::vector<Round> rounds, kept;  // all; those after the warm-up
  double minute = 0;
  while (SecondsSince(start) < 60 * minutes) {
    const std::size_t first = sensor.sent_count();
    const double before_s = world.server().Cpu_s();
    MoveToPresent(loop);
    if (!Play(sensor, loop)) return report.Fail("the stream ended: " + sensor.Finish());
    Round round = RoundOf(sensor.answers(), first);
    round.end_s = SecondsSince(start);
    round.bytes = world.server().ResidentBytes();
    round.cpu_ms = 1e3 * (world.server().Cpu_s() - before_s) / std::max(round.processed, 1);
    if (round.moved < round.processed / 2) {
      return report.Fail("the world followed the pushed thing in " + std::to_string(round.moved) +
                         " of " + std::to_string(round.processed) + " frames");
    }
    rounds.push_back(round);
    if (round.end_s >= 60 * minutes * kWarmUpShare) kept.push_back(round);
    if (round.end_s < minute) continue;
    minute += 60;
    char text[160];
    std::snprintf(text, sizeof(text),
                  "  %5.1f min: %.1f MiB, answers p95 %.1f ms, %.1f ms of CPU a frame, %d of %zu "
                  "frames processed",
                  round.end_s / 60, static_cast<double>(round.bytes) / kMebi, round.p95_ms,
                  round.cpu_ms, round.processed, loop.size());
    report.Detail(text);
  }
  if (kept.size() < 3) return report.Fail("the soak is too short: it takes two minutes at least");
  char how[240];
  std::snprintf(how, sizeof(how),
                "growth of the server's memory in the last %.1f of %.1f minutes of one pushed "
                "thing at 30 Hz; %.3f MiB a minute (least squares)",
                (kept.back().end_s - kept.front().end_s) / 60, minutes, GrowthPerMinute_MiB(kept));
  report.Add(
      WithLimit({.key = "live_soak",
                 .value = static_cast<double>(kept.back().bytes - kept.front().bytes) / kMebi,
                 .unit = "MiB",
                 .how = how},
                20));
  // Medians of the first and the last quarter: single rounds are disturbed on shared machines.
  const std::size_t quarter = std::max<std::size_t>(kept.size() / 4, 1);
  std::vector<double> early_ms, late_ms, early_cpu_ms, late_cpu_ms;
  for (std::size_t i = 0; i < quarter; ++i) {
    early_ms.push_back(kept[i].p95_ms);
    early_cpu_ms.push_back(kept[i].cpu_ms);
    late_ms.push_back(kept[kept.size() - 1 - i].p95_ms);
    late_cpu_ms.push_back(kept[kept.size() - 1 - i].cpu_ms);
  }
  std::snprintf(how, sizeof(how),
                "p95 of the answers in 20 s, median over the last quarter, %.1f ms, to that over "
                "the first quarter after the warm-up, %.1f ms; CPU a frame %.2f x",
                Median(late_ms), Median(early_ms), Median(late_cpu_ms) / Median(early_cpu_ms));
  report.Add(WithLimit({.key = "live_soak_p95_ratio",
                        .value = Median(late_ms) / Median(early_ms),
                        .unit = "x",
                        .how = how},
                       1.1));
}

}  // namespace cwm::benchmarks
