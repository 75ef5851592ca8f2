#include "clients/simulator/sequence_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "clients/formats/depth_image.h"
#include "clients/formats/file_bytes.h"
#include "tests/support/process.h"

namespace cwm::simulator {
namespace {

using Json = nlohmann::json;
using testing::ScratchDirectory;

// Two small sensors; a can that is pushed by a hand, an arm that passes.
constexpr char kScript[] = R"(scene: kitchen
duration_s: 1
robots:
  - name: arm
    urdf: arm.urdf
    pose: {position_m: [0.55, -0.5, 0.9]}
    trajectory:
      - {time_s: 0, values: [0.6, 0.2, 1.6, 1.3]}
      - {time_s: 1, values: [1.36, 0.62, 1.545, 0.977]}
sensors:
  - {name: front, width: 160, height: 120, focal_px: 131, rate_hz: 10, lost: {frames: [3]}, doubled: {frames: [5]}}
  - {name: side, width: 80, height: 60, focal_px: 60, rate_hz: 5, look_at: {from_m: [0.7, 0.9, 1.6], at_m: [0.6, -0.1, 0.95]}}
events:
  - push: {object: cup, from_s: 0.3, to_s: 0.7, by_m: [-0.05, 0, 0], hand: {travel_s: 0.3}}
)";

class SequenceFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(formats::WriteFileBytes(scratch_ / "s.yaml", kScript).ok());
    std::filesystem::copy("clients/simulator/examples/arm.urdf", scratch_ / "arm.urdf");
    auto file = ReadScript(scratch_ / "s.yaml");
    ASSERT_TRUE(file.ok()) << file.status();
    file_ = *std::move(file);
    const absl::Status status = WriteSequence(scratch_ / "out", file_, true);
    ASSERT_TRUE(status.ok()) << status;
  }

  std::string Bytes(const std::string& name) const {
    return formats::ReadFileBytes(scratch_ / ("out/" + name)).value();
  }

  std::vector<Json> Lines(const std::string& name) const {
    std::istringstream text(Bytes(name));
    std::vector<Json> lines;
    for (std::string line; std::getline(text, line);) lines.push_back(Json::parse(line));
    return lines;
  }

  // The depths of an image as a reader of depth images sees them.
  std::vector<float> Depths(const std::string& image, std::optional<double> unit_m = {}) const {
    const auto camera = formats::ParseDepthCamera(Bytes("front/camera.json"), "camera.json");
    EXPECT_TRUE(camera.ok()) << camera.status();
    const auto cloud = formats::ParseDepthImage(Bytes(image), image, *camera, unit_m);
    EXPECT_TRUE(cloud.ok()) << cloud.status();
    std::vector<float> depths;
    for (std::size_t i = 0; i < cloud->bytes.size(); i += cloud->point_step) {
      float point[3];
      std::memcpy(point, cloud->bytes.data() + i, sizeof(point));
      depths.push_back(std::isnan(point[2]) ? 0 : point[2]);
    }
    return depths;
  }

  ScratchDirectory scratch_;
  ScriptFile file_;
};

TEST_F(SequenceFiles, HoldTheDepthsThatWereRendered) {
  const perception::SequenceRenderer renderer(file_.script);
  for (const int k : {0, 5}) {
    const auto frame = renderer.Render(0, k);
    const auto depths = Depths("front/00000" + std::to_string(k) + ".png");
    ASSERT_EQ(depths.size(), frame.depth.depth_m.size());
    for (std::size_t i = 0; i < depths.size(); ++i) {
      // Rounded to the unit of the images, and that to a float.
      ASSERT_NEAR(depths[i], frame.depth.depth_m[i], 0.5 * kDepthUnit_m + 1e-6);
      ASSERT_EQ(depths[i] == 0, frame.depth.depth_m[i] == 0);
    }
  }
}

TEST_F(SequenceFiles, HoldAFrameFileForEachFrameThatIsNotLost) {
  std::vector<std::string> order;
  for (const Json& line : Lines("front/frames.jsonl")) {
    order.push_back(line.at("file"));
    EXPECT_TRUE(std::filesystem::exists(scratch_ / ("out/front/" + order.back())));
    EXPECT_EQ(line.at("pose").size(), 7U);
    EXPECT_LE(line.at("stamp"), line.at("delivery"));
  }
  EXPECT_EQ(order, (std::vector<std::string>{"000000.png", "000001.png", "000002.png", "000004.png",
                                             "000005.png", "000005.png", "000006.png", "000007.png",
                                             "000008.png", "000009.png"}));
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "out/front/000003.png"));
  EXPECT_EQ(Lines("front/truth.jsonl").size(), 9U);
  EXPECT_EQ(Lines("side/truth.jsonl").size(), 5U);
}

TEST_F(SequenceFiles, HoldLabelsThatAgreeWithTheTruth) {
  const Json sequence = Json::parse(Bytes("sequence.json"));
  bool saw_hand = false, saw_robot = false, saw_moving = false;
  for (const Json& truth : Lines("front/truth.jsonl")) {
    std::map<int, int> counts;
    const std::string file = truth.at("file");
    const auto depths = Depths("front/" + file);
    const auto labels = Depths("front/labels/" + file, 1.0);  // label images have the unit 1
    for (std::size_t i = 0; i < labels.size(); ++i) {
      ++counts[static_cast<int>(labels[i])];
      ASSERT_EQ(labels[i] == 0, depths[i] == 0);
    }
    for (std::size_t i = 0; i < truth.at("objects").size(); ++i) {
      const Json& object = truth.at("objects")[i];
      EXPECT_EQ(object.at("name"), sequence.at("objects")[i].at("name"));
      EXPECT_EQ(object.at("pixels"), counts[sequence.at("objects")[i].at("label")]);
      saw_moving |= object.at("moving").get<bool>();
    }
    EXPECT_EQ(truth.at("hand_pixels"), counts[kHandLabel]);
    EXPECT_EQ(truth.at("robot_pixels"), counts[kRobotLabel]);
    EXPECT_EQ(truth.at("mixed_pixels"), counts[kMixedLabel]);
    saw_hand |= truth.at("hand_pixels") > 50;
    saw_robot |= truth.at("robot_pixels") > 50;
  }
  EXPECT_TRUE(saw_hand);
  EXPECT_TRUE(saw_robot);
  EXPECT_TRUE(saw_moving);
}

TEST_F(SequenceFiles, HoldTheJointStatesAndTheFilesOfTheRobot) {
  const auto states = Lines("front/joint_states.jsonl");
  EXPECT_EQ(states.size(), 111U);  // 100 a second, from 0.1 s before
  EXPECT_EQ(states[0].at("robot"), "arm");
  EXPECT_EQ(states[0].at("joints"), Json::parse(R"(["turn", "lift", "elbow", "wrist"])"));
  EXPECT_NEAR(states[60].at("values")[0], 0.98, 1e-9);  // halfway, at 0.5 s
  const Json robot = Json::parse(Bytes("sequence.json")).at("robots")[0];
  EXPECT_EQ(robot.at("urdf"), (scratch_ / "arm.urdf"));
  EXPECT_EQ(robot.at("pose")[1], -0.5);
}

TEST_F(SequenceFiles, AreTheSameBytesForTheSameScript) {
  ASSERT_TRUE(WriteSequence(scratch_ / "again", file_, true).ok());
  int files = 0;
  const std::string first = scratch_ / "out";
  for (const auto& entry : std::filesystem::recursive_directory_iterator(first)) {
    if (!entry.is_regular_file()) continue;
    const auto name = std::filesystem::relative(entry.path(), first).string();
    EXPECT_EQ(formats::ReadFileBytes(entry.path().string()).value(),
              formats::ReadFileBytes(scratch_ / ("again/" + name)).value())
        << name;
    ++files;
  }
  EXPECT_GT(files, 30);
}

}  // namespace
}  // namespace cwm::simulator
