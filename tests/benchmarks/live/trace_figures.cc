// Traces of three sensors that stream at once, replayed in the order in which the world took their
// frames.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "perception/simulation/deliveries.h"
#include "perception/simulation/hand.h"
#include "perception/simulation/random_draws.h"
#include "tests/benchmarks/live/live_benchmarks.h"
#include "tests/benchmarks/live/live_scenes.h"
#include "tests/benchmarks/live/live_world.h"
#include "tests/benchmarks/live/world_bytes.h"
#include "tests/benchmarks/server/server_benchmarks.h"

namespace cwm::benchmarks {
namespace {

constexpr std::size_t kSensors = 3;
constexpr int kThings = 6;
constexpr double kPush_s = 0.8, kDuration_s = 2.9;
constexpr int kMaxRuns = 1'000;
constexpr int kReplayCores[] = {1, 0};  // 0: all
constexpr int kScale = 2;               // smaller images than those of the other figures
// chosen: so often a sensor sends its next frame before the last one is answered.
constexpr double kHasteRate = 0.2;
constexpr auto kPatience = std::chrono::minutes(2);

// A thing moves, and a hand pushes another one, before three cameras.
perception::SequenceScript PushesBeforeThree() {
  perception::SequenceScript script = PushedThing(
      kPush_s, {.thing_count = kThings, .duration_s = kDuration_s, .sensor_count = kSensors});
  ScaleDown(kScale, script);
  const std::size_t pushed = kFirstThing + 4;
  const perception::HandReach reach{.from_W = perception::ReachFrom(script, pushed, kPush_s)};
  perception::PushByHand(pushed, {.begin_s = kPush_s, .end_s = kPush_s + 1},
                         MakeTranslation(-0.05, 0, 0) * script.scene.objects[pushed].X_WO, reach,
                         script);
  return script;
}

// The frames of a sensor in the order in which they come; the choices follow from the seed.
std::vector<std::size_t> LateAndDoubled(perception::SequenceScript script, std::size_t sensor,
                                        std::uint64_t seed) {
  script.seed = seed;
  script.sensors[sensor].doubled.rate = 0.1;
  script.sensors[sensor].late.rate = 0.1;
  std::vector<std::size_t> frames;
  for (const auto& delivery : perception::FrameDeliveries(script, sensor)) {
    frames.push_back(static_cast<std::size_t>(delivery.frame));
  }
  return frames;
}

using Frames = std::vector<std::vector<TrueFrame>>;  // by sensor

struct TracedFrame {
  std::size_t sensor = 0;
  std::size_t frame = 0;
};
using Trace = std::vector<TracedFrame>;

std::vector<std::unique_ptr<LiveSensor>> OpenSensors(const LiveWorld& world, const Frames& frames) {
  std::vector<std::unique_ptr<LiveSensor>> sensors;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    v1::SensorCalibration calibration =
        CalibrationOf(kLiveWorld, "camera_" + std::to_string(i + 1), frames[i].front().frame,
                      /*is_fixed=*/true);
    calibration.set_lockstep(true);
    sensors.push_back(std::make_unique<LiveSensor>(world.address(), std::move(calibration)));
  }
  return sensors;
}

struct Recording {
  Trace trace = {};
  WorldBytes world = {};
  int unprocessed = 0;  // dropped and refused frames
};

// Three clients send at once. Empty if a stream ends, or the numbers of the frames have gaps.
std::optional<Recording> Record(const Frames& frames,
                                const std::vector<std::vector<std::size_t>>& sent,
                                std::uint64_t seed) {
  const LiveWorld world;
  if (!world.up()) return std::nullopt;
  const auto sensors = OpenSensors(world, frames);
  std::vector<std::jthread> clients;
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    clients.emplace_back([&, i] {
      perception::RandomDraws draws(seed, i);
      for (const std::size_t frame : sent[i]) {
        const auto index = sensors[i]->Send(frames[i][frame].frame);
        if (!index) return;
        if (draws.Uniform(0, 1) < kHasteRate) continue;
        if (!sensors[i]->WaitForAnswers(*index + 1, kPatience)) return;
      }
      sensors[i]->WaitForAnswers(sent[i].size(), kPatience);
    });
  }
  clients.clear();  // joins
  Recording recording;
  std::map<std::int64_t, TracedFrame> by_number;
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const std::vector<FrameAnswer> answers = sensors[i]->answers();
    if (answers.size() != sent[i].size()) return std::nullopt;
    for (std::size_t k = 0; k < answers.size(); ++k) {
      if (!answers[k].is_processed()) {
        ++recording.unprocessed;
        continue;
      }
      by_number[answers[k].response.sequence_number()] = {.sensor = i, .frame = sent[i][k]};
    }
  }
  for (const auto& [number, frame] : by_number) {
    recording.trace.push_back(frame);
    if (number != static_cast<std::int64_t>(recording.trace.size())) return std::nullopt;
  }
  auto bytes = BytesOf(world.server().connection(), kLiveWorld);
  if (!bytes) return std::nullopt;
  recording.world = *std::move(bytes);
  return recording;
}

// Sends the frames of the trace one after the other, to a server on so many cores. Empty if one of
// them is not processed, or gets another number.
std::optional<WorldBytes> Replay(const Frames& frames, const Trace& trace, int cores) {
  const LiveWorld world({.cores = cores});
  if (!world.up()) return std::nullopt;
  const auto sensors = OpenSensors(world, frames);
  for (std::size_t k = 0; k < trace.size(); ++k) {
    const auto& [sensor, frame] = trace[k];
    const auto answer = sensors[sensor]->SendAndWait(frames[sensor][frame].frame);
    if (!answer || !answer->is_processed()) return std::nullopt;
    if (answer->response.sequence_number() != static_cast<std::int64_t>(k) + 1) return std::nullopt;
  }
  return BytesOf(world.server().connection(), kLiveWorld);
}

bool MeasureTrace(const perception::SequenceScript& script, const Frames& frames, int scene,
                  SceneSamples& samples, Report& report) {
  const std::uint64_t seed = 1 + static_cast<std::uint64_t>(scene);
  std::vector<std::vector<std::size_t>> sent;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    sent.push_back(LateAndDoubled(script, i, seed));
  }
  const auto recording = Record(frames, sent, seed);
  if (!recording) {
    report.Fail("a stream of three sensors ended, its world is empty, or numbers have gaps");
    return false;
  }
  for (const int cores : kReplayCores) {
    const auto world = Replay(frames, recording->trace, cores);
    if (!world) {
      report.Fail("a frame of a trace was not processed with its number when it was replayed");
      return false;
    }
    const bool is_different = *world != recording->world;
    samples.Add("different", is_different ? 1 : 0);
    if (is_different) {
      report.Detail("  seed " + std::to_string(seed) +
                    " differs: " + FirstDifference(*world, recording->world));
    }
  }
  samples.Add("processed", static_cast<double>(recording->trace.size()));
  samples.Add("unprocessed", recording->unprocessed);
  samples.Add("objects", static_cast<double>(recording->world.objects.size()));
  samples.Add("revision", std::stod(recording->world.revision));
  return true;
}

}  // namespace

void MeasureLiveTrace(const SceneOptions& options, Report& report) {
  const perception::SequenceRenderer renderer(PushesBeforeThree());
  Frames frames;
  for (std::size_t i = 0; i < kSensors; ++i) {
    frames.push_back(RenderFrames(renderer, i, 0, static_cast<int>(kDuration_s * 30)));
  }
  MoveToPast(frames);
  const auto samples =
      MeasureScenes(options, "trace", kMaxRuns / static_cast<int>(std::size(kReplayCores)), report,
                    [&](int scene, SceneSamples& scenes) {
                      return MeasureTrace(renderer.script(), frames, scene, scenes, report);
                    });
  if (!samples) return;
  const auto median = [&](const char* key) {
    return std::to_string(static_cast<int>(Median(samples->Of(key))));
  };
  report.Add(WithLimit(
      {.key = "live_order_sensors",
       .value = samples->Sum("different"),
       .unit = "1",
       .how = "of " + std::to_string(samples->Of("different").size()) +
              " replays, half of them on one core, of " + std::to_string(samples->scene_count()) +
              " traces of three sensors that streamed at once, those whose objects or events "
              "differ in a byte from those of the recording; median " +
              median("processed") + " frames processed and " + median("unprocessed") +
              " dropped or refused, " + median("revision") + " revisions and " + median("objects") +
              " objects a trace"},
      0));
}

}  // namespace cwm::benchmarks
