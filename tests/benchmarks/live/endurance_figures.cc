// The same motion for half an hour; and the same frames in disorder.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "tests/benchmarks/live/live_benchmarks.h"
#include "tests/benchmarks/live/live_scenes.h"
#include "tests/benchmarks/live/live_world.h"
#include "tests/benchmarks/live/revision_probe.h"
#include "tests/benchmarks/server/server_benchmarks.h"

namespace cwm::benchmarks {
namespace {

// A period of PushedThing, to and fro.
constexpr double kPeriod_s = 4;
constexpr double kSettle_s = 2;

double P95Answer_ms(const std::vector<FrameAnswer>& answers, std::size_t first) {
  std::vector<double> times_ms;
  for (std::size_t i = first; i < answers.size(); ++i) {
    if (answers[i].is_processed()) times_ms.push_back(answers[i].Answer_ms());
  }
  return times_ms.empty() ? 0 : Quantile(times_ms, 0.95);
}

// The objects of the world without what differs from one world to the next.
std::string WorldBytes(const LiveWorld& world) {
  v1::ListObjectsRequest request;
  request.set_world(kLiveWorld);
  const client::Connection& connection = world.server().connection();
  const auto list =
      connection.Call(&v1::WorldService::Stub::ListObjects, connection.worlds(), request);
  if (!list.ok()) return {};
  std::string bytes;
  for (v1::Object object : list->objects()) {
    object.clear_last_observed();
    bytes += object.SerializeAsString();
  }
  return bytes;
}

// Sends the frames one by one, each when the one before is answered; empty if the stream ends.
std::string WorldAfter(const std::vector<const RecordedFrame*>& frames, int* refused) {
  LiveWorld world;
  if (!world.up()) return {};
  LiveSensor& sensor = world.AddSensor("camera_1", *frames.front());
  for (const RecordedFrame* frame : frames) {
    auto answer = sensor.SendAndWait(*frame);
    if (!answer) return {};
    *refused += answer->response.fate() == v1::FRAME_FATE_REFUSED;
  }
  return WorldBytes(world);
}

}  // namespace

void MeasureLiveSoak(double minutes, Report& report) {
  constexpr double kWarmUpShare = 1.0 / 3;
  const perception::SequenceRenderer renderer(PushedThing(kSettle_s, kSettle_s + 5 * kPeriod_s));
  auto settle = RenderFrames(renderer, 0, 0, static_cast<int>(kSettle_s * 30));
  auto loop = RenderFrames(renderer, 0, static_cast<int>(kSettle_s * 30),
                           static_cast<int>(5 * kPeriod_s * 30));
  LiveWorld world;
  if (!world.up()) return report.Fail("the server does not come up");
  MoveToPresent(settle);
  LiveSensor& sensor = world.AddSensor("camera_1", settle.front().frame);
  if (!Play(sensor, settle)) return report.Fail("the stream ended: " + sensor.Finish());
  const auto start = SteadyClock::now();
  std::int64_t early_bytes = 0;
  double early_p95_ms = 0, late_p95_ms = 0;
  while (SecondsSince(start) < 60 * minutes) {
    const std::size_t first = sensor.sent_count();
    MoveToPresent(loop);
    if (!Play(sensor, loop)) return report.Fail("the stream ended: " + sensor.Finish());
    late_p95_ms = P95Answer_ms(sensor.answers(), first);
    if (early_bytes == 0 && SecondsSince(start) >= 60 * minutes * kWarmUpShare) {
      early_bytes = world.server().ResidentBytes();
      early_p95_ms = late_p95_ms;
    }
  }
  char how[200];
  std::snprintf(how, sizeof(how),
                "growth of the server's memory in the last %.1f of %.1f minutes of one pushed "
                "thing at 30 Hz",
                minutes * (1 - kWarmUpShare), minutes);
  report.Add(
      WithLimit({.key = "live_soak_mib",
                 .value = static_cast<double>(world.server().ResidentBytes() - early_bytes) / kMebi,
                 .unit = "MiB",
                 .how = how},
                20));
  std::snprintf(how, sizeof(how),
                "p95 of the answers in the last 20 s, %.1f ms, to that after a third of the time, "
                "%.1f ms",
                late_p95_ms, early_p95_ms);
  report.Add(WithLimit(
      {.key = "live_soak_p95_ratio", .value = late_p95_ms / early_p95_ms, .unit = "x", .how = how},
      1.1));
}

void MeasureLiveOrder(Report& report) {
  constexpr int kRuns = 10, kFrames = 150;
  const perception::SequenceRenderer renderer(PushedThing(1, kFrames / 30.0 + 0.1));
  auto frames = RenderFrames(renderer, 0, 0, kFrames);
  MoveToPresent(frames);
  std::vector<const RecordedFrame*> in_order;
  for (const TrueFrame& frame : frames) in_order.push_back(&frame.frame);
  int different = 0, refused = 0;
  std::string reference;
  for (int run = 0; run < kRuns; ++run) {
    // Frames come twice, or again after others; each first comes in order.
    std::vector<const RecordedFrame*> disordered;
    for (std::size_t i = 0; i < in_order.size(); ++i) {
      disordered.push_back(in_order[i]);
      if (run > 0 && (i + static_cast<std::size_t>(run)) % 5 == 0) {
        disordered.push_back(in_order[i]);
      }
      if (run > 0 && (i + static_cast<std::size_t>(run)) % 7 == 0 && i >= 3) {
        disordered.push_back(in_order[i - 3]);
      }
    }
    int refused_now = 0;
    const std::string bytes = WorldAfter(disordered, &refused_now);
    if (bytes.empty()) return report.Fail("a stream in disorder ended, or its world is empty");
    if (run == 0) reference = bytes;
    different += bytes != reference;
    refused += refused_now;
    const auto expected = static_cast<int>(disordered.size() - in_order.size());
    if (refused_now != expected) {
      report.Detail("  run " + std::to_string(run) + ": " + std::to_string(refused_now) +
                    " frames were refused, " + std::to_string(expected) + " were late");
    }
  }
  report.Add(WithLimit({.key = "live_order",
                        .value = static_cast<double>(different),
                        .unit = "1",
                        .how = "of " + std::to_string(kRuns - 1) +
                               " runs with doubled and late frames, those whose world differs in a "
                               "byte from that of the frames in order; " +
                               std::to_string(refused) + " frames were refused"},
                       0));
}

}  // namespace cwm::benchmarks
