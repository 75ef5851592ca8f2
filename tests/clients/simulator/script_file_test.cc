#include "clients/simulator/script_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "clients/formats/file_bytes.h"
#include "perception/simulation/sequence_renderer.h"
#include "tests/support/process.h"

namespace cwm::simulator {
namespace {

using perception::SequenceScript;
using ::testing::HasSubstr;
using testing::ScratchDirectory;

constexpr char kExamples[] = "clients/simulator/examples/";  // tests run in the source directory

absl::StatusOr<ScriptFile> ReadText(const std::string& text) {
  const ScratchDirectory scratch;
  const std::string path = scratch / "s.yaml";
  EXPECT_TRUE(formats::WriteFileBytes(path, text).ok());
  const std::string urdf = formats::ReadFileBytes(std::string(kExamples) + "arm.urdf").value();
  EXPECT_TRUE(formats::WriteFileBytes(scratch / "arm.urdf", urdf).ok());
  return ReadScript(path);
}

// The head of a script that needs no more.
constexpr char kHead[] = R"(scene: kitchen
duration_s: 4
sensors: [{name: front}]
)";

constexpr char kArm[] = R"(robots:
  - {name: arm, urdf: arm.urdf, joints: [turn, elbow], trajectory: [{time_s: 0, values: [0, 1]}]}
)";

TEST(ScriptFile, ReadsTheExamples) {
  for (const char* name : {"pushed_mug", "passing_hand", "arm_carries_soup"}) {
    const auto file = ReadScript(std::string(kExamples) + name + ".yaml");
    ASSERT_TRUE(file.ok()) << file.status();
    EXPECT_FALSE(file->script.scene.objects.empty());
    for (const perception::SequenceSensor& sensor : file->script.sensors) {
      EXPECT_GT(perception::FrameCount(file->script, sensor), 100);
    }
  }
}

TEST(ScriptFile, LetsTheArmOfTheExampleCarryTheSoupToItsNewPlace) {
  const auto file = ReadScript(std::string(kExamples) + "arm_carries_soup.yaml");
  ASSERT_TRUE(file.ok()) << file.status();
  const SequenceScript& script = file->script;
  constexpr std::size_t kSoup = 6;
  ASSERT_EQ(script.scene.objects[kSoup].name, "soup");
  const Pose before = perception::ObjectStateAt(script, kSoup, 0).X_WO;
  const Pose lifted = perception::ObjectStateAt(script, kSoup, 3).X_WO;
  const Pose after = perception::ObjectStateAt(script, kSoup, 6).X_WO;
  // The arm's poses are rounded to a milliradian, half a millimetre at the gripper.
  EXPECT_NEAR(lifted.translation().z(), before.translation().z() + 0.15, 0.002);
  EXPECT_NEAR(after.translation().z(), before.translation().z(), 0.001);
  EXPECT_GT((after.translation() - before.translation()).norm(), 0.2);
  EXPECT_GT(after.linear().col(2).z(), 0.9999);  // it stands
  // The arm turned it from 1.36 to 1.95 rad about its own base.
  EXPECT_NEAR(RotationAngle_rad(before.linear(), after.linear()), 0.59, 0.002);
  const Vector3 base = file->robots[0].X_WB.translation();
  EXPECT_NEAR((after.translation() - base).head<2>().norm(),
              (before.translation() - base).head<2>().norm(), 0.001);
}

TEST(ScriptFile, ReadsEveryKeyOfASensor) {
  const auto file = ReadText(R"(scene: {random: table, seed: 3}
duration_s: 2
start_stamp_s: 50
seed: 9
sensors:
  - name: a
    model: 0.003
    width: 64
    height: 48
    focal_px: 50
    look_at: {from_m: [1, 0, 2], at_m: [0, 0, 0.8]}
    rate_hz: 15
    start_s: 0.5
    clock_offset_s: -0.01
    latency_s: 0.02
    device_seed: 77
    lost: {rate: 0.5}
    doubled: {frames: [1]}
    late: {frames: [2, 3], by_s: 0.4}
    swapped: {frames: [4]}
  - {name: b, model: time_of_flight}
)");
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_EQ(file->script.start_stamp_s, 50);
  EXPECT_EQ(file->script.seed, 9U);
  ASSERT_EQ(file->script.sensors.size(), 2U);
  const perception::SequenceSensor& a = file->script.sensors[0];
  EXPECT_EQ(a.noise.model, perception::SensorModel::kGiven);
  EXPECT_EQ(a.noise.given_sigma_m, 0.003);
  EXPECT_EQ(a.camera.width, 64);
  EXPECT_EQ(a.camera.center_y_px, 23.5);
  EXPECT_EQ(std::get<Pose>(a.mount).translation(), Vector3(1, 0, 2));
  EXPECT_EQ(a.rate_hz, 15);
  EXPECT_EQ(a.start_s, 0.5);
  EXPECT_EQ(a.clock_offset_s, -0.01);
  EXPECT_EQ(a.latency_s, 0.02);
  EXPECT_EQ(a.device_seed, 77U);
  EXPECT_EQ(a.lost.rate, 0.5);
  EXPECT_EQ(a.doubled.frames, std::vector<int>{1});
  EXPECT_EQ(a.late.frames, (std::vector<int>{2, 3}));
  EXPECT_EQ(a.late_by_s, 0.4);
  EXPECT_EQ(a.swapped.frames, std::vector<int>{4});
  EXPECT_EQ(file->script.sensors[1].device_seed, 2U);  // sensors differ by default
}

TEST(ScriptFile, MovesRobotsByTheJointsNamed) {
  const auto file = ReadText(std::string(kHead) + R"(robots:
  - name: arm
    urdf: arm.urdf
    joints: [elbow, turn]
    trajectory:
      - {time_s: 1, values: [1, 0]}
      - {time_s: 3, values: [2, -1]}
)");
  ASSERT_TRUE(file.ok()) << file.status();
  const perception::SimulatedRobot& arm = file->script.robots[0];
  EXPECT_EQ(arm.variables, (std::vector<std::string>{"turn", "lift", "elbow", "wrist"}));
  EXPECT_EQ(arm.trajectory.At(0), (std::vector<double>{0, 0, 1, 0}));
  EXPECT_EQ(arm.trajectory.At(2), (std::vector<double>{-0.5, 0, 1.5, 0}));
  EXPECT_EQ(arm.trajectory.At(9), (std::vector<double>{-1, 0, 2, 0}));
  EXPECT_EQ(arm.links.size(), 5U);
  EXPECT_EQ(arm.links[4].parts.size(), 3U);
}

TEST(ScriptFile, RefusesWhatIsWrongAndSaysWhereAndWhat) {
  const std::vector<std::pair<std::string, std::string>> faults = {
      {"scene: kitchen\nduration_s: 4\n", "sensors must be a list of 1 to 16 sensors"},
      {"duration_s: 4\nsensors: [{name: a}]\n", "scene is missing"},
      {"scene: cellar\nduration_s: 4\nsensors: [{name: a}]\n",
       "s.yaml:1: scene is cellar, must be kitchen, table"},
      {"scene: {random: cellar}\nduration_s: 4\n", "scene.random is cellar, is no family; there"},
      {"scene: kitchen\nduration_s: -1\n", "duration_s is -1, must be positive"},
      {"scene: kitchen\nduration_s: long\n", "duration_s is long, must be a finite number"},
      {"scene: kitchen\nduration_s: 1e9\n", "duration_s is 1e9, must be at most 3600"},
      {std::string(kHead) + "speed: 3\n", "s.yaml:4: speed is no known key"},
      {"scene: kitchen\nduration_s: 1\nsensors: [{name: ../a}]\n", "sensors[0].name is ../a, must"},
      {"scene: kitchen\nduration_s: 1\nsensors: [{name: a}, {name: a}]\n",
       "sensors[1].name is a, must not appear twice"},
      {"scene: kitchen\nduration_s: 1\nsensors: [{name: a, model: sick_lms400}]\n",
       "sensors[0].model is sick_lms400, must be a depth camera"},
      {"scene: kitchen\nduration_s: 1\nsensors: [{name: a, rate_hz: 1e5}]\n",
       "sensors[0].rate_hz is 1e5, must be at most 1000"},
      {"scene: kitchen\nduration_s: 1\nsensors: [{name: a, start_s: 1}]\n",
       "sensors[0].start_s is 1, leaves no frame"},
      {"scene: kitchen\nduration_s: 1\nsensors: [{name: a, lost: {frames: [30]}}]\n",
       "sensors[0].lost.frames[0] is 30, must be a whole number from 0 to 29"},
      {"scene: kitchen\nduration_s: 1\nsensors: [{name: a, lost: {rate: 2}}]\n",
       "sensors[0].lost.rate is 2, must be from 0 to 1"},
      {"scene: kitchen\nduration_s: 1\nsensors: [{name: a, on_link: {robot: r, link: l}}]\n",
       "sensors[0].on_link.robot is r, is no robot of the script; there are none"},
      {"scene: kitchen\nduration_s: 1\nsensors: [{name: a, waypoints: [{time_s: 2, pose: {}}]}]\n",
       "sensors[0].waypoints[0].time_s is 2, must be from 0 to duration_s, 1"},
      {std::string(kHead) + "robots: [{name: arm, urdf: none.urdf}]\n",
       "robots[0].urdf is none.urdf, cannot be used"},
      {std::string(kHead) +
           "robots: [{name: arm, urdf: arm.urdf, joints: [hip], trajectory: [{time_s: 0}]}]\n",
       "robots[0].joints[0] is hip, is no joint of arm; there are turn, lift, elbow, wrist"},
      {std::string(kHead) +
           "robots: [{name: arm, urdf: arm.urdf, trajectory: [{time_s: 0, values: [0, 1]}]}]\n",
       "robots[0].trajectory[0].values must be a list of 4 numbers"},
      {std::string(kHead) + "robots: [{name: arm, urdf: arm.urdf, joints: [elbow], trajectory: "
                            "[{time_s: 0, values: [-1]}]}]\n",
       "puts elbow at -1, must be within its limits, 0 to 2.8"},
      {std::string(kHead) + "robots: [{name: arm, urdf: arm.urdf, joints: [elbow], trajectory: "
                            "[{time_s: 2, values: [1]}, {time_s: 1, values: [1]}]}]\n",
       "robots[0].trajectory[1].time_s is 1, must be later than the one before"},
      {std::string(kHead) + "hands: [{name: h, waypoints: []}]\n",
       "hands[0].waypoints must be a list with at least one time_s"},
      {std::string(kHead) + "events: [{kick: {object: mug}}]\n", "events[0].kick is no known key"},
      {std::string(kHead) + "events:\n  - take: {object: plate, at_s: 1}\n",
       "s.yaml:5: events[0].take.object is plate, is no object of the scene; there are counter"},
      {std::string(kHead) + "events: [{take: {object: mug, at_s: 5}}]\n",
       "events[0].take.at_s is 5, must be from 0 to duration_s, 4"},
      {std::string(kHead) +
           "events: [{push: {object: mug, from_s: 2, to_s: 1, by_m: [0, 0, 1]}}]\n",
       "events[0].push.to_s is 1, must be later than from_s"},
      {std::string(kHead) + "events: [{push: {object: mug, from_s: 1, to_s: 2}}]\n",
       "events[0].push must hold either by_m or to"},
      {std::string(kHead) + "events: [{push: {object: mug, from_s: 1, to_s: 3, by_m: [0, 0, 1]}}, "
                            "{take: {object: mug, at_s: 2}}]\n",
       "events[1].take begins at 2 s, must not begin before"},
      {std::string(kHead) + "events: [{take: {object: mug, at_s: 1, hand: false}}, {push: {object: "
                            "mug, from_s: 2, to_s: 3, by_m: [0, 0, 1]}}]\n",
       "events[1].push mug is not there at 2 s"},
      {std::string(kHead) + "events: [{push: {object: mug, from_s: 0, to_s: 1, by_m: [0, 0, 1]}}, "
                            "{put: {object: mug, at_s: 3}}]\n",
       "events[1].put mug is still there at 2.2 s"},
      {std::string(kHead) + "events: [{carry: {object: mug, from_s: 1, to_s: 2}}]\n",
       "events[0].carry must hold either robot or hand"},
      {std::string(kHead) + kArm +
           "events: [{carry: {object: mug, robot: arm, link: toe, from_s: 1, to_s: 2}}]\n",
       "events[0].carry.link is toe, is no link of arm; there are base, shoulder"},
      {std::string(kHead) + "events: [{take: {object: mug, at_s: 1, hand: maybe}}]\n",
       "events[0].take.hand is maybe, must be true or false"},
      {"scene: [\n", "s.yaml:"},
  };
  for (const auto& [text, message] : faults) {
    const auto file = ReadText(text);
    ASSERT_FALSE(file.ok()) << text;
    EXPECT_EQ(file.status().code(), absl::StatusCode::kInvalidArgument) << text;
    EXPECT_THAT(std::string(file.status().message()), HasSubstr(message)) << text;
  }
}

TEST(ScriptFile, PutsAnObjectThatWasNotThereBefore) {
  const auto file = ReadText(std::string(kHead) +
                             "events: [{put: {object: mug, at_s: 2, hand: {travel_s: 1}}}]\n");
  ASSERT_TRUE(file.ok()) << file.status();
  const SequenceScript& script = file->script;
  const std::size_t mug = script.scene.objects.size() - 1;
  EXPECT_FALSE(perception::ObjectStateAt(script, mug, 0.9).is_present);
  EXPECT_TRUE(perception::ObjectStateAt(script, mug, 1.1).is_present);
  EXPECT_LT((perception::ObjectStateAt(script, mug, 2).X_WO.matrix() -
             script.scene.objects[mug].X_WO.matrix())
                .norm(),
            1e-12);  // roundings of a few poses
}

}  // namespace
}  // namespace cwm::simulator
