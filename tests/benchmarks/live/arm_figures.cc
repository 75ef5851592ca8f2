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

}  // namespace

void MeasureLiveArm(Report& report) {
  constexpr double kRest_s = 12, kDuration_s = kRest_s + 24, kClock_s = 0.005;
  const auto robot = ReadBenchRobot();
  if (!robot.ok()) return report.Fail("no robot: " + robot.status().ToString());
  SequenceScript script = TableScript({.thing_count = 15, .duration_s = kDuration_s, .seed = 5});
  script.robots.push_back(
      SimulateRobot(*robot, SweepingTrajectory(*robot, kRest_s, kDuration_s, kSpeed_m_s)));
  script.robots.front().states.clock_offset_s = kClock_s;
  const perception::SequenceRenderer renderer(script);
  auto frames = RenderFrames(renderer, 0, 0, static_cast<int>(kDuration_s * 30),
                             /*keeps_bodies=*/true);
  LiveWorld world;
  if (!world.up()) return report.Fail("the server does not come up");
  const auto loaded = world.AddRobot(*robot, script.robots.front().trajectory.rows.front());
  if (!loaded.ok()) return report.Fail("the robot cannot be loaded: " + loaded.ToString());
  const double offset_s = MoveToPresent(frames);
  LiveSensor& sensor = world.AddSensor("camera_1", frames.front().frame);
  const StatePlayer states(world.address(), script.robots.front(),
                           perception::JointStateDeliveries(script, 0), script.start_stamp_s,
                           offset_s);
  if (!sensor.Send(frames.front().frame) || !sensor.WaitForAnswers(1, std::chrono::seconds(20))) {
    return report.Fail("the stream ended: " + sensor.Finish());
  }
  // Frames that are due already are left out, so that the others come when their states do.
  const double now_s =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  std::erase_if(frames, [&](const TrueFrame& frame) { return frame.frame.stamp_s < now_s; });
  if (frames.empty()) return report.Fail("the first frame took longer than the sequence");
  std::this_thread::sleep_for(std::chrono::duration<double>(frames.front().frame.stamp_s - now_s));
  const auto recording = Record(world, sensor, script, kFirstThing, frames);
  if (!recording) return report.Fail("the stream ended: " + sensor.Finish());
  // The world is interpreted while the robot stands still.
  const auto sweeps = std::ranges::find_if(recording->timeline, [&](const Moment& moment) {
    return moment.stamp_s >= script.start_stamp_s + offset_s + kRest_s;
  });
  const auto from = static_cast<std::size_t>(sweeps - recording->timeline.begin());
  if (from == recording->timeline.size()) return report.Fail("no frame of the sweep was processed");
  long failed = 0, robot_pixels = 0, asked = 0, kept = 0;
  std::map<std::string, long> reasons;
  for (std::size_t m = from; m < recording->timeline.size(); ++m) {
    const Moment& moment = recording->timeline[m];
    const TrueFrame& frame = frames[recording->frames[m]];
    robot_pixels += frame.robot_pixels;
    failed += ExplainedPixels(renderer, frame, InventedBoxes(recording->published[m], moment)) >
              kMaxPixels;
    ++reasons[recording->answers[recording->frames[m]].response.reason()];
    for (const int match : MatchThings(moment)) {
      ++asked;
      kept += match >= 0;
    }
  }
  const auto count = recording->timeline.size() - from;
  if (robot_pixels == 0 || asked == 0) return report.Fail("the robot was not seen");
  std::string text = "  " + robot->name + " at 0.6 m/s: " + std::to_string(count) + " frames, " +
                     std::to_string(robot_pixels / static_cast<long>(count)) +
                     " pixels of it a frame";
  for (const auto& [reason, frames_of_it] : reasons) {
    if (!reason.empty()) text += "; " + std::to_string(frames_of_it) + " " + reason;
  }
  report.Detail(text);
  report.Add(WithLimit({.key = "live_arm_frames",
                        .value = static_cast<double>(failed),
                        .unit = "1",
                        .how = "frames of " + std::to_string(count) +
                               " with more than 8 pixels of the robot within 10 mm of something "
                               "published that is no thing; states 5 ms late"},
                       0));
  report.Add(WithLimit({.key = "live_arm_things_kept",
                        .value = 1e2 * static_cast<double>(kept) / static_cast<double>(asked),
                        .unit = "%",
                        .how = "of the things at rest, hidden or not, those published in each "
                               "frame of the sweep"},
                       99, "at least"));
  const ChangeVerdict changes = JudgeChanges(recording->timeline, from);
  for (const std::string& line : changes.lines) report.Detail("  arm: " + line);
  report.Add(
      WithLimit({.key = "live_false_removals_hidden",
                 .value = static_cast<double>(changes.unfounded.removed),
                 .unit = "1",
                 .how = "things at rest that were removed in " + std::to_string(count) +
                        " frames of the sweep; added " + std::to_string(changes.unfounded.added) +
                        ", moved " + std::to_string(changes.unfounded.moved) + ", replaced " +
                        std::to_string(changes.unfounded.replaced)},
                0));
}

}  // namespace cwm::benchmarks
