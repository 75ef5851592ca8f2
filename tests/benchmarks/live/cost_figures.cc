// The cost of frames: latency of changes, rates of static frames, processor time.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <thread>
#include <utility>

#include "tests/benchmarks/live/live_benchmarks.h"
#include "tests/benchmarks/live/live_scenes.h"
#include "tests/benchmarks/live/live_world.h"
#include "tests/benchmarks/live/revision_probe.h"
#include "tests/benchmarks/server/server_benchmarks.h"

namespace cwm::benchmarks {
namespace {

using perception::SequenceRenderer;
using perception::SequenceScript;

constexpr double kRate_hz = 30;
constexpr double kSettle_s = 2;  // of static frames, before anything is measured
constexpr int kSettleFrames = static_cast<int>(kSettle_s * kRate_hz);
constexpr auto kPatience = std::chrono::seconds(30);

std::vector<TrueFrame> Split(std::vector<TrueFrame>& frames, int count) {
  const auto end = frames.begin() + std::min<std::ptrdiff_t>(count, std::ssize(frames));
  std::vector<TrueFrame> first(std::make_move_iterator(frames.begin()),
                               std::make_move_iterator(end));
  frames.erase(frames.begin(), end);
  return first;
}

struct Fates {
  int processed = 0, dropped = 0, refused = 0, unanswered = 0;
};

Fates FatesFrom(const std::vector<FrameAnswer>& answers, std::size_t first) {
  Fates fates;
  for (std::size_t i = first; i < answers.size(); ++i) {
    switch (answers[i].response.fate()) {
      case v1::FRAME_FATE_PROCESSED:
        ++fates.processed;
        break;
      case v1::FRAME_FATE_DROPPED:
        ++fates.dropped;
        break;
      case v1::FRAME_FATE_REFUSED:
        ++fates.refused;
        break;
      default:
        ++fates.unanswered;
    }
  }
  return fates;
}

std::string TextOf(const Fates& fates) {
  char text[120];
  std::snprintf(text, sizeof(text), "%d processed, %d dropped, %d refused, %d unanswered",
                fates.processed, fates.dropped, fates.refused, fates.unanswered);
  return text;
}

// Median milliseconds by stage over the processed answers.
std::string StagesOf(const std::vector<FrameAnswer>& answers, std::size_t first) {
  std::vector<std::string> names;
  std::map<std::string, std::vector<double>> times_ms;
  for (std::size_t i = first; i < answers.size(); ++i) {
    if (!answers[i].is_processed()) continue;
    for (const v1::StageTime& stage : answers[i].response.stages()) {
      if (!times_ms.count(stage.stage())) names.push_back(stage.stage());
      times_ms[stage.stage()].push_back(stage.elapsed_ms());
    }
  }
  std::string text;
  for (const std::string& name : names) {
    char stage[80];
    std::snprintf(stage, sizeof(stage), "%s%s %.2f", text.empty() ? "" : ", ", name.c_str(),
                  Median(times_ms[name]));
    text += stage;
  }
  return text;
}

// A board that faces the sensor, 0.7 m before it, and waves sideways; it covers this share of the
// image.
SequenceScript WavingBoard(double share, double duration_s) {
  constexpr double kDistance_m = 0.7, kStroke_m = 0.06, kStroke_s = 0.4, kThickness_m = 0.01;
  SequenceScript script = TableScript({.duration_s = duration_s});
  if (share == 0) return script;
  const perception::PinholeCamera camera = perception::CameraAt(script, script.sensors.front(), 0);
  const double edge_m =
      std::sqrt(share * camera.width * camera.height) * kDistance_m / camera.focal_px;
  const auto board_at = [&](double x_m) {
    return Pose(camera.X_WC * MakeTranslation(x_m, 0, kDistance_m));
  };
  const std::size_t board = script.scene.objects.size();
  script.scene.objects.push_back(
      {.name = "board",
       .parts = {{.shape = Box{.size_m = {edge_m, edge_m, kThickness_m}}}},
       .X_WO = board_at(-0.5 * kStroke_m)});
  script.events.push_back({.object = board,
                           .begin_s = kSettle_s,
                           .what = perception::AppearEvent{.X_WO = board_at(-0.5 * kStroke_m)}});
  double sign = 1;
  for (double begin_s = kSettle_s; begin_s + kStroke_s <= duration_s; begin_s += kStroke_s) {
    script.events.push_back(
        {.object = board,
         .begin_s = begin_s,
         .end_s = begin_s + kStroke_s,
         .what = perception::MoveEvent{.X_WO = board_at(0.5 * sign * kStroke_m)}});
    sign = -sign;
  }
  return script;
}

// Processor milliseconds of the server a frame at this share of changed pixels; the share of the
// truth goes to `changed`.
std::optional<double> CpuOfFrame_ms(double share, int stored_boxes, double* changed,
                                    Report& report) {
  constexpr double kMeasured_s = 8;
  const SequenceRenderer renderer(WavingBoard(share, kSettle_s + kMeasured_s + 1));
  auto frames = RenderFrames(renderer, 0, 0, static_cast<int>((kSettle_s + 1 + kMeasured_s) * 30));
  LiveWorld world;
  if (!world.up()) {
    report.Fail("the server does not come up");
    return std::nullopt;
  }
  if (const auto put = world.PutHiddenBoxes(stored_boxes); stored_boxes > 0 && !put.ok()) {
    report.Fail("boxes cannot be put: " + put.ToString());
    return std::nullopt;
  }
  auto still = Split(frames, kSettleFrames);
  LiveSensor& sensor = world.AddSensor("camera_1", still.front().frame);
  if (const std::string error = Settle(world, sensor, still); !error.empty()) {
    report.Fail(error);
    return std::nullopt;
  }
  const std::size_t first = sensor.sent_count();
  MoveToPresent(frames);
  const double before_s = world.server().Cpu_s();
  const bool is_played = Play(sensor, frames);
  const double cpu_ms = 1e3 * (world.server().Cpu_s() - before_s);
  if (!is_played) {
    report.Fail("the stream ended: " + sensor.Finish());
    return std::nullopt;
  }
  double pixels = 0;
  const std::size_t board = renderer.script().scene.objects.size() - 1;
  for (const TrueFrame& frame : frames) {
    if (share > 0) pixels += static_cast<double>(frame.objects[board].pixel_count);
  }
  *changed = pixels / static_cast<double>(frames.size()) / (640 * 480);
  const auto answers = sensor.answers();
  const Fates fates = FatesFrom(answers, first);
  const double frame_ms = cpu_ms / std::max(fates.processed, 1);  // dropped frames cost little
  char text[160];
  std::snprintf(text, sizeof(text), "  %4.1f %% changed, %3d more objects: %.2f ms a frame; ",
                1e2 * *changed, stored_boxes, frame_ms);
  report.Detail(text + TextOf(fates) + "; stages " + StagesOf(answers, first));
  return frame_ms;
}

// The greatest rate, of these, at which no frame of any sensor is dropped; frames of a static
// scene. Empty if the server fails.
bool DropsNothingAt(double rate_hz, int sensors, Report& report) {
  constexpr double kMeasured_s = 6, kWarmUp_s = 2;
  SequenceScript script =
      TableScript({.duration_s = kWarmUp_s + kMeasured_s, .sensor_count = sensors});
  for (perception::SequenceSensor& sensor : script.sensors) sensor.rate_hz = rate_hz;
  const SequenceRenderer renderer(script);
  std::vector<std::vector<TrueFrame>> frames;
  for (std::size_t i = 0; i < script.sensors.size(); ++i) {
    frames.push_back(RenderFrames(renderer, i, 0, static_cast<int>(script.duration_s * rate_hz)));
  }
  LiveWorld world;
  if (!world.up()) {
    report.Fail("the server does not come up");
    return false;
  }
  std::vector<LiveSensor*> streams;
  std::vector<std::size_t> first;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    auto still = Split(frames[i], static_cast<int>(kWarmUp_s * rate_hz));
    streams.push_back(&world.AddSensor(script.sensors[i].name, still.front().frame));
    if (const std::string error = Settle(world, *streams[i], still); !error.empty()) {
      report.Fail(error);
      return false;
    }
    first.push_back(streams[i]->sent_count());
  }
  std::vector<std::thread> players;
  for (std::size_t i = 0; i < frames.size(); ++i) MoveToPresent(frames[i]);
  const double before_s = world.server().Cpu_s();
  const auto start = SteadyClock::now();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    players.emplace_back([&, i] { Play(*streams[i], frames[i]); });
  }
  for (std::thread& player : players) player.join();
  const double cores = (world.server().Cpu_s() - before_s) /
                       std::chrono::duration<double>(SteadyClock::now() - start).count();
  Fates sum;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Fates fates = FatesFrom(streams[i]->answers(), first[i]);
    sum.processed += fates.processed;
    sum.dropped += fates.dropped;
    sum.refused += fates.refused;
    sum.unanswered += fates.unanswered;
  }
  char text[100];
  std::snprintf(text, sizeof(text), "  %d sensors at %.0f Hz: %.2f cores; ", sensors, rate_hz,
                cores);
  report.Detail(text + TextOf(sum));
  return sum.dropped == 0 && sum.refused == 0 && sum.unanswered == 0 && sum.processed > 0;
}

// The greatest of the rates without a dropped frame; 0 if there is none.
double GreatestRate_hz(const std::vector<double>& descending_hz, int sensors, Report& report) {
  for (const double rate_hz : descending_hz) {
    if (DropsNothingAt(rate_hz, sensors, report)) return rate_hz;
    if (report.failed()) return 0;
  }
  return 0;
}

}  // namespace

void MeasureLiveRevisions(Report& report) {
  constexpr int kFrames = 3'000, kBatch = 300, kSecond = 30;
  const SequenceRenderer renderer(TableScript({.duration_s = (kFrames + kSecond) / kRate_hz + 1}));
  auto frames = RenderFrames(renderer, 0, 0, kSecond);
  LiveWorld world;
  if (!world.up()) return report.Fail("the server does not come up");
  LiveSensor& sensor = world.AddSensor("camera_1", frames.front().frame);
  if (const std::string error = Settle(world, sensor, frames); !error.empty()) {
    return report.Fail(error);
  }
  bool is_played = true;
  const std::int64_t before = world.Revision();
  const std::size_t first = sensor.sent_count();
  for (int i = 0; i < kFrames && is_played; i += kBatch) {
    frames = RenderFrames(renderer, 0, kSecond + i, kBatch);
    MoveToPresent(frames);
    is_played = Play(sensor, frames);
  }
  if (!is_played) return report.Fail("the stream ended: " + sensor.Finish());
  const std::int64_t after = world.Revision();
  const auto answers = sensor.answers();
  for (std::size_t i = first; i < answers.size(); ++i) {
    const v1::FrameChanges& changes = answers[i].response.changes();
    if (changes.ByteSizeLong() == 0) continue;
    report.Detail("  frame " + std::to_string(i) + ": " + changes.ShortDebugString());
  }
  report.Detail("  static scene: " + TextOf(FatesFrom(answers, first)));
  report.Add(
      WithLimit({.key = "live_static_revisions",
                 .value = static_cast<double>(after - before),
                 .unit = "1",
                 .how = "revisions in 3 000 frames of a static table that was interpreted before"},
                0));
}

void MeasureLiveChange(Report& report) {
  constexpr double kMeasured_s = 20;
  Yardstick_ms(report);
  const SequenceRenderer renderer(PushedThing(kSettle_s, {.duration_s = kSettle_s + kMeasured_s}));
  auto frames = RenderFrames(renderer, 0, 0, static_cast<int>((kSettle_s + kMeasured_s) * 30));
  LiveWorld world;
  if (!world.up()) return report.Fail("the server does not come up");
  auto still = Split(frames, kSettleFrames);
  LiveSensor& sensor = world.AddSensor("camera_1", still.front().frame);
  if (const std::string error = Settle(world, sensor, still); !error.empty()) {
    return report.Fail(error);
  }
  const std::size_t first = sensor.sent_count();
  PublishedWorld& published = world.published();
  published.WaitFor(world.Revision());
  std::vector<double> times_ms;
  {
    const RevisionProbe probe(world.address(), kLiveWorld);
    MoveToPresent(frames);
    if (!Play(sensor, frames)) return report.Fail("the stream ended: " + sensor.Finish());
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    times_ms = ChangeTimes_ms(sensor.answers(), first, probe);
  }
  const auto answers = sensor.answers();
  std::vector<double> answer_ms;
  for (std::size_t i = first; i < answers.size(); ++i) answer_ms.push_back(answers[i].Answer_ms());
  char text[200];
  std::snprintf(
      text, sizeof(text),
      "  pushed thing: %zu of %zu frames moved it; a frame is answered in p50 %.1f ms, "
      "p95 %.1f ms; a watcher got %.0f bytes a frame; ",
      times_ms.size(), answers.size() - first, Quantile(answer_ms, 0.5), Quantile(answer_ms, 0.95),
      static_cast<double>(published.event_bytes()) / static_cast<double>(answers.size() - first));
  report.Detail(text + TextOf(FatesFrom(answers, first)) + "; stages " + StagesOf(answers, first));
  // The thing moves in nearly every frame; turning takes some.
  if (times_ms.size() < (answers.size() - first) / 2) {
    return report.Fail("the world followed the pushed thing in " + std::to_string(times_ms.size()) +
                       " of " + std::to_string(answers.size() - first) + " frames");
  }
  const std::string how =
      " from the last byte of a frame to the answer of a query, on another connection, at the "
      "revision that it made; one of 20 things pushed at 4 cm/s, 20 s at 30 Hz";
  report.Add(BesideYardstick({.key = "live_change_p50_ms",
                              .value = Quantile(times_ms, 0.5),
                              .unit = "ms",
                              .how = "p50" + how},
                             10, std::nullopt, report));
  report.Add(BesideYardstick({.key = "live_change_p95_ms",
                              .value = Quantile(times_ms, 0.95),
                              .unit = "ms",
                              .how = "p95" + how},
                             25, 0.4, report));
}

void MeasureLiveStatic(Report& report) {
  Yardstick_ms(report);
  const double one_hz = GreatestRate_hz({100, 60, 30, 15, 5}, 1, report);
  if (report.failed()) return;
  const double three_hz = GreatestRate_hz({30, 15, 5, 2}, 3, report);
  if (report.failed()) return;
  const std::string how =
      "the greatest of the tried rates at which no frame of a static table was "
      "dropped in 6 s, ";
  report.Add(WithLimit({.key = "live_static_fps_1",
                        .value = one_hz,
                        .unit = "1/s",
                        .how = how + "one sensor (100, 60, 30, 15, 5)"},
                       100, "at least"));
  report.Add(WithLimit({.key = "live_static_fps_3",
                        .value = three_hz,
                        .unit = "1/s",
                        .how = how + "three sensors (30, 15, 5, 2)"},
                       30, "at least"));
}

void MeasureLiveCpu(Report& report) {
  constexpr struct {
    const char* key;
    double share;
    double limit_ms;
    std::optional<double> asked_ratio;
  } kRows[] = {{"live_cpu_ms_0", 0, 4, 0.07},
               {"live_cpu_ms_2", 0.02, 8, std::nullopt},
               {"live_cpu_ms_5", 0.05, 12, std::nullopt},
               {"live_cpu_ms_20", 0.2, 40, std::nullopt}};
  constexpr int kMoreObjects = 180;
  Yardstick_ms(report);
  std::optional<double> static_ms;
  for (const auto& row : kRows) {
    double changed = 0;
    const auto cpu_ms = CpuOfFrame_ms(row.share, 0, &changed, report);
    if (!cpu_ms) return;
    if (row.share == 0) static_ms = cpu_ms;
    char how[200];
    std::snprintf(
        how, sizeof(how),
        "processor time of the server by processed frame, 20 things at rest and a board that waves "
        "before them over %.1f %% of the pixels, 8 s at 30 Hz",
        1e2 * changed);
    report.Add(BesideYardstick({.key = row.key, .value = *cpu_ms, .unit = "ms", .how = how},
                               row.limit_ms, row.asked_ratio, report));
  }
  double changed = 0;
  const auto many_ms = CpuOfFrame_ms(0, kMoreObjects, &changed, report);
  if (!many_ms) return;
  report.Add(WithLimit({.key = "live_cpu_known_ratio",
                        .value = *many_ms / *static_ms,
                        .unit = "x",
                        .how = "processor time of a static frame with 180 more known objects in "
                               "the view, hidden by the table, to that without"},
                       1.2));
}

}  // namespace cwm::benchmarks
