// A robot in view whose hand sweeps over the things.
#include <algorithm>
#include <map>
#include <string>
#include <thread>
#include <utility>

#include "tests/benchmarks/live/bench_robot.h"
#include "tests/benchmarks/live/judge.h"
#include "tests/benchmarks/live/live_benchmarks.h"
#include "tests/benchmarks/live/live_scenes.h"
#include "tests/benchmarks/live/timeline_recorder.h"
#include "tests/benchmarks/server/server_benchmarks.h"

namespace cwm::benchmarks {
namespace {

using perception::SequenceScript;

constexpr double kSpeed_m_s = 0.6;
constexpr double kExplained_m = 0.01;  // of a point by a surface
constexpr int kMaxPixels = 8;

// Boxes of everything published that is no support, no user's and no true thing.
std::vector<PlacedBox> InventedBoxes(const PublishedObjects& published, const Moment& moment) {
  std::vector<bool> is_true(moment.published.size(), false);
  for (const int match : MatchThings(moment)) {
    if (match >= 0) is_true[static_cast<std::size_t>(match)] = true;
  }
  std::vector<PlacedBox> boxes;
  for (std::size_t i = 0; i < moment.published.size(); ++i) {
    if (is_true[i]) continue;
    for (const PlacedBox& box : BoxesOf(*published.at(moment.published[i].name))) {
      boxes.push_back(box);
    }
  }
  return boxes;
}

// The number of the robot's pixels that what is invented explains.
long ExplainedPixels(const perception::SequenceRenderer& renderer, const TrueFrame& frame,
                     const std::vector<PlacedBox>& boxes) {
  long count = 0;
  for (std::size_t pixel = 0; pixel < frame.bodies.size() && !boxes.empty(); ++pixel) {
    const std::int32_t body = frame.bodies[pixel];
    if (body < 0 || renderer.bodies()[static_cast<std::size_t>(body)].kind !=
                        perception::SequenceBody::Kind::kRobot) {
      continue;
    }
    const Vector3 p_W = PointInWorld(frame.frame, pixel);
    count += std::ranges::any_of(
        boxes, [&](const PlacedBox& box) { return Distance_m(box, p_W) <= kExplained_m; });
  }
  return count;
}

// The things that are published when the sweep begins, moment by moment: each moment in which one
// is no longer published is a loss.
void AddKept(const Timeline& timeline, std::size_t from, SceneSamples& samples, Report& report) {
  const std::vector<int> known = MatchThings(timeline[from]);
  double asked = 0, kept = 0;
  for (std::size_t m = from; m < timeline.size(); ++m) {
    const std::vector<int> now = MatchThings(timeline[m]);
    for (std::size_t t = 0; t < known.size(); ++t) {
      if (known[t] < 0) continue;
      ++asked;
      kept += now[t] >= 0 ? 1 : 0;
    }
  }
  samples.Add("asked", asked);
  samples.Add("kept", kept);
  report.Detail("  " + std::to_string(std::ssize(known) - std::ranges::count(known, -1)) + " of " +
                std::to_string(known.size()) + " things are published when the sweep begins");
}

bool PlaySweep(const BenchRobot& robot, int scene, SceneSamples& samples, Report& report) {
  constexpr double kRest_s = 10, kDuration_s = kRest_s + 24, kClock_s = 0.005;
  const auto fail = [&](const std::string& why) {
    report.Fail(why);
    return false;
  };
  SequenceScript script = TableScript({.thing_count = 15,
                                       .duration_s = kDuration_s,
                                       .seed = 5 + static_cast<std::uint64_t>(scene)});
  script.robots.push_back(
      SimulateRobot(robot, SweepingTrajectory(robot, kRest_s, kDuration_s, kSpeed_m_s)));
  script.robots.front().states.clock_offset_s = scene % 2 == 0 ? kClock_s : -kClock_s;
  const perception::SequenceRenderer renderer(script);
  auto frames = RenderFrames(renderer, 0, 0, static_cast<int>(kDuration_s * 30),
                             /*keeps_bodies=*/true);
  LiveWorld world;
  if (!world.up()) return fail("the server does not come up");
  const auto loaded = world.AddRobot(robot, script.robots.front().trajectory.rows.front());
  if (!loaded.ok()) return fail("the robot cannot be loaded: " + loaded.ToString());
  const double offset_s = MoveToPresent(frames);
  LiveSensor& sensor = world.AddSensor("camera_1", frames.front().frame);
  const StatePlayer states(world.address(), script.robots.front(),
                           perception::JointStateDeliveries(script, 0), script.start_stamp_s,
                           offset_s);
  if (!sensor.Send(frames.front().frame) || !sensor.WaitForAnswers(1, std::chrono::seconds(20))) {
    return fail("the stream ended: " + sensor.Finish());
  }
  // Frames that are due already are left out, so that the others come when their states do.
  const double now_s =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  std::erase_if(frames, [&](const TrueFrame& frame) { return frame.frame.stamp_s < now_s; });
  if (frames.empty()) return fail("the first frame took longer than the sequence");
  std::this_thread::sleep_for(std::chrono::duration<double>(frames.front().frame.stamp_s - now_s));
  const auto recording = Record(world, sensor, script, kFirstThing, frames);
  if (!recording) return fail("the stream ended: " + sensor.Finish());
  // The world is interpreted while the robot stands still.
  const auto sweeps = std::ranges::find_if(recording->timeline, [&](const Moment& moment) {
    return moment.stamp_s >= script.start_stamp_s + offset_s + kRest_s;
  });
  const auto from = static_cast<std::size_t>(sweeps - recording->timeline.begin());
  if (from == recording->timeline.size()) return fail("no frame of the sweep was processed");
  double failed = 0;
  std::map<std::string, long> reasons;
  for (std::size_t m = from; m < recording->timeline.size(); ++m) {
    const TrueFrame& frame = frames[recording->frames[m]];
    samples.Add("robot_pixels", static_cast<double>(frame.robot_pixels));
    const auto invented = InventedBoxes(recording->published[m], recording->timeline[m]);
    failed += ExplainedPixels(renderer, frame, invented) > kMaxPixels ? 1 : 0;
    ++reasons[recording->answers[recording->frames[m]].response.reason()];
  }
  samples.Add("failed", failed);
  const auto count = recording->timeline.size() - from;
  std::string text = "  " + robot.name + " at 0.6 m/s: " + std::to_string(count) + " frames of " +
                     std::to_string(static_cast<int>((kDuration_s - kRest_s) * 30));
  for (const auto& [reason, frames_of_it] : reasons) {
    if (!reason.empty()) text += "; " + std::to_string(frames_of_it) + " " + reason;
  }
  report.Detail(text);
  AddKept(recording->timeline, from, samples, report);
  const ChangeVerdict changes = JudgeChanges(recording->timeline, from);
  for (const std::string& line : changes.lines) report.Detail("  arm: " + line);
  samples.Add("removed", changes.unfounded.removed);
  samples.Add("others",
              changes.unfounded.added + changes.unfounded.moved + changes.unfounded.replaced);
  return true;
}

}  // namespace

void MeasureLiveArm(const SceneOptions& options, Report& report) {
  constexpr int kMaxScenes = 14;  // about 10 000 frames
  const auto robot = ReadBenchRobot();
  if (!robot.ok()) return report.Fail("no robot: " + robot.status().ToString());
  const auto samples = MeasureScenes(
      options, "arm", kMaxScenes, report,
      [&](int scene, SceneSamples& scenes) { return PlaySweep(*robot, scene, scenes, report); });
  if (!samples) return;
  const std::vector<double> pixels = samples->Of("robot_pixels");
  const double asked = samples->Sum("asked");
  if (pixels.empty() || Median(pixels) == 0 || asked == 0) {
    return report.Fail("the robot was not seen, or no thing when it began to move");
  }
  const std::string frames = std::to_string(pixels.size()) + " frames of the sweep";
  report.Add(
      WithLimit({.key = "live_arm_frames",
                 .value = samples->Sum("failed"),
                 .unit = "1",
                 .how = "of " + frames +
                        ", those with more than 8 pixels of the robot within 10 mm of "
                        "something published that is no thing; clocks 5 ms apart; median " +
                        std::to_string(static_cast<int>(Median(pixels))) + " pixels of the robot"},
                0));
  report.Add(WithLimit({.key = "live_arm_things_kept",
                        .value = 1e2 * samples->Sum("kept") / asked,
                        .unit = "%",
                        .how = "of the things that were published when the sweep began, hidden or "
                               "not, those that still are in each frame"},
                       99, "at least"));
  report.Add(WithLimit(
      {.key = "live_false_removals_hidden",
       .value = samples->Sum("removed"),
       .unit = "1",
       .how = "things at rest that were removed in " + frames + "; added, moved or replaced " +
              std::to_string(static_cast<int>(samples->Sum("others")))},
      0));
}

}  // namespace cwm::benchmarks
