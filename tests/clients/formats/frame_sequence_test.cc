#include "clients/formats/frame_sequence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "clients/formats/pose_file.h"
#include "tests/clients/formats/invalid_file.h"
#include "tests/support/process.h"

namespace cwm::formats {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Pointwise;

class Folder {
 public:
  void Write(const std::string& name, const std::string& text) const {
    std::ofstream(scratch_ / name) << text;
  }
  std::string path() const { return scratch_ / ""; }

 private:
  testing::ScratchDirectory scratch_;
};

std::vector<std::string> NamesOf(const FrameSequence& sequence) {
  std::vector<std::string> names;
  for (const SequenceFrame& frame : sequence.frames) {
    names.push_back(frame.path.substr(frame.path.rfind('/') + 1));
  }
  return names;
}

TEST(FrameSequence, FilesOfAFolderComeInTheOrderOfTheirNumbers) {
  const Folder folder;
  for (const char* name : {"scan10.pcd", "scan9.pcd", "scan1.pcd", "notes.txt"}) {
    folder.Write(name, "");
  }
  const auto clouds = ReadFrameFolder(folder.path());
  ASSERT_TRUE(clouds.ok()) << clouds.status();
  EXPECT_THAT(NamesOf(*clouds), ElementsAre("scan1.pcd", "scan9.pcd", "scan10.pcd"));
  EXPECT_FALSE(clouds->frames[0].stamp_s.has_value());
  EXPECT_FALSE(clouds->frames[0].x_world_sensor.has_value());
}

TEST(FrameSequence, DepthImagesAreTakenAndPicturesBesideThemAreNot) {
  const Folder folder;
  for (const char* name : {"00-color.png", "00-depth.png", "01-color.png", "01-depth.png"}) {
    folder.Write(name, "");
  }
  folder.Write("01-pose.txt", "1 0 0 0.5\n0 0 -1 0\n0 1 0 2\n0 0 0 1\n");
  const auto sequence = ReadFrameFolder(folder.path());
  ASSERT_TRUE(sequence.ok()) << sequence.status();
  EXPECT_THAT(NamesOf(*sequence), ElementsAre("00-depth.png", "01-depth.png"));
  EXPECT_FALSE(sequence->frames[0].x_world_sensor.has_value());
  ASSERT_TRUE(sequence->frames[1].x_world_sensor.has_value());
  EXPECT_THAT(sequence->frames[1].x_world_sensor->position_m, ElementsAre(0.5, 0, 2));
  // y goes to z: a quarter turn about x.
  const double h = std::sqrt(0.5);
  EXPECT_THAT(sequence->frames[1].x_world_sensor->orientation_xyzw,
              Pointwise(DoubleNear(1e-12), {h, 0., 0., h}));
}

TEST(FrameSequence, GravityTurnsPosesUpright) {
  const Folder folder;
  folder.Write("frame-0.depth.png", "");
  folder.Write("frame-0.pose.txt", "1 2 3 0 0 0 1");
  folder.Write("gravity-direction.txt", "0\n2\n0\n");  // the recording's y points down
  const auto sequence = ReadFrameFolder(folder.path());
  ASSERT_TRUE(sequence.ok()) << sequence.status();
  const ScenePose pose = sequence->frames.at(0).x_world_sensor.value_or(ScenePose());
  EXPECT_NEAR(pose.position_m[2], -2, 1e-12) << "2 m down";
  EXPECT_NEAR(std::hypot(pose.position_m[0], pose.position_m[1]), std::sqrt(10), 1e-12);
  folder.Write("gravity-direction.txt", "0 0 0");
  EXPECT_THAT(ReadFrameFolder(folder.path()).status().message(), HasSubstr("not all 0"));
}

TEST(FrameSequence, PosesOfFramesNamedLikeFilesHaveTheirNames) {
  const Folder folder;
  folder.Write("frame-000000.depth.png", "");
  folder.Write("frame-000000.pose.txt", "1 2 3 0 0 0 2");
  folder.Write("image.png", "");  // not of the depth images
  const auto sequence = ReadFrameFolder(folder.path());
  ASSERT_TRUE(sequence.ok()) << sequence.status();
  ASSERT_THAT(NamesOf(*sequence), ElementsAre("frame-000000.depth.png"));
  EXPECT_EQ(*sequence->frames[0].x_world_sensor,
            (ScenePose{.position_m = {1, 2, 3}, .orientation_xyzw = {0, 0, 0, 1}}));
}

TEST(FrameSequence, ListsHaveStampsDeliveriesPosesAndStates) {
  const Folder folder;
  folder.Write("frames.jsonl",
               R"({"file": "b.png", "stamp": 2, "delivery": 2.5, "pose": [1, 2, 3, 0, 0, 0, 1]})"
               "\n\n"
               R"({"file": "a.png", "stamp": 1.5})"
               "\n");
  folder.Write("joint_states.jsonl",
               R"({"robot": "arm", "stamp": 1, "delivery": 1.25, "joints": ["j1", "j2"], )"
               R"("values": [0.5, -1]})"
               "\n");
  const auto sequence = ReadFrameFolder(folder.path());
  ASSERT_TRUE(sequence.ok()) << sequence.status();
  EXPECT_THAT(NamesOf(*sequence), ElementsAre("b.png", "a.png"));
  EXPECT_EQ(sequence->frames[0].stamp_s, 2);
  EXPECT_EQ(sequence->frames[0].delivery_s, 2.5);
  EXPECT_EQ(sequence->frames[0].x_world_sensor->position_m[2], 3);
  EXPECT_EQ(sequence->frames[1].delivery_s, std::nullopt);
  EXPECT_THAT(sequence->frames[1].source, EndsWith("frames.jsonl:3"));
  ASSERT_EQ(sequence->states.size(), 1u);
  const SequenceState& state = sequence->states[0];
  EXPECT_EQ(state.robot, "arm");
  EXPECT_EQ(state.stamp_s, 1);
  EXPECT_EQ(state.delivery_s, 1.25);
  EXPECT_THAT(state.variables, ElementsAre("j1", "j2"));
  EXPECT_THAT(state.values, ElementsAre(0.5, -1));
}

TEST(FrameSequence, LinesOfAListAreWordsOrObjects) {
  const Folder folder;
  folder.Write("p.txt", "0 0 1 0 0 0 1");
  const auto parse = [&](const char* line) { return ParseFrameLine(line, folder.path(), "-:7"); };
  ASSERT_TRUE(parse("  ").ok());
  EXPECT_FALSE(parse("  ")->has_value());
  const auto named = parse("a.png");
  ASSERT_TRUE(named.ok() && named->has_value()) << named.status();
  EXPECT_EQ((*named)->path, folder.path() + "a.png");
  EXPECT_EQ((*named)->source, "-:7");
  EXPECT_EQ((*parse("a.png 12.5"))->stamp_s, 12.5);
  EXPECT_EQ((*parse("a.png 12.5 1,2,3,0,0,0,1"))->x_world_sensor->position_m[1], 2);
  EXPECT_EQ((*parse("a.png 12.5 p.txt"))->x_world_sensor->position_m[2], 1);
  EXPECT_EQ((*parse("/a.png"))->path, "/a.png");
  EXPECT_EQ((*parse(R"({"file": "a.png", "stamp": 3})"))->stamp_s, 3);
}

TEST(FrameSequence, MalformedLinesAreNamedByFileLineAndField) {
  const Folder folder;
  for (const InvalidFile& invalid : std::vector<InvalidFile>{
           {"no number", "a.png soon", "the stamp is soon", "must be a finite number of seconds"},
           {"infinite", "a.png inf", "the stamp is inf", "must be a finite number of seconds"},
           {"nanoseconds", "a.png 1796012928000000000", "the stamp is 1796012928000000000",
            "must be a finite number of seconds, at most 9e9 in magnitude"},
           {"nanoseconds of an object", R"({"file": "a", "stamp": 1796012928000000000})",
            "stamp is 1796012928000000000", "at most 9e9 in magnitude"},
           {"infinite delivery", R"({"file": "a", "delivery": 1e300})", "delivery is 1e+300",
            "must be a finite number of seconds"},
           {"short pose", "a.png 1 1,2,3", "the pose is 1,2,3", "must be X,Y,Z,QX,QY,QZ,QW"},
           {"zero quaternion", "a.png 1 1,2,3,0,0,0,0", "the pose", "must be X,Y,Z,QX,QY,QZ,QW"},
           {"too much", "a.png 1 1,2,3,0,0,0,1 x", "the line", "must be FILE [STAMP [POSE]]"},
           {"no object", "{\"file\": ", "the line", "must be a JSON object"},
           {"no file", "{\"stamp\": 1}", "file", "is missing"},
           {"text stamp", R"({"file": "a", "stamp": "1"})", "stamp is \"1\"",
            "must be a finite number"},
           {"short", R"({"file": "a", "pose": [1]})", "pose is [1]", "must be [x, y, z"}}) {
    SCOPED_TRACE(invalid.name);
    ExpectRefusal(ParseFrameLine(invalid.text, folder.path(), "list.txt:2").status(), "list.txt:2",
                  invalid);
  }
}

TEST(FrameSequence, MalformedFoldersAreRefused) {
  const Folder folder;
  EXPECT_THAT(std::string(ReadFrameFolder(folder.path()).status().message()),
              HasSubstr("has no frames"));
  EXPECT_THAT(std::string(ReadFrameFolder(folder.path() + "absent").status().message()),
              HasSubstr("absent: No such file"));
  folder.Write("frames.jsonl", "{\"file\": \"a.png\"}\n");
  folder.Write("joint_states.jsonl",
               "{\"robot\": \"arm\", \"stamp\": 1, \"joints\": [\"a\"], \"values\": [1, 2]}\n");
  EXPECT_THAT(std::string(ReadFrameFolder(folder.path()).status().message()),
              HasSubstr("joint_states.jsonl:1: values is 2 numbers, must be one for each of 1"));
  folder.Write("joint_states.jsonl", "{\"robot\": \"arm\", \"stamp\": 1, \"values\": 3}\n");
  EXPECT_THAT(std::string(ReadFrameFolder(folder.path()).status().message()),
              HasSubstr("joint_states.jsonl:1: values is 3, must be a list of numbers"));
  folder.Write("joint_states.jsonl",
               "{\"robot\": \"arm\", \"stamp\": 1, \"joints\": \"a\", \"values\": [1]}\n");
  EXPECT_THAT(std::string(ReadFrameFolder(folder.path()).status().message()),
              HasSubstr("joint_states.jsonl:1: joints is \"a\", must be a list of names"));
}

TEST(PoseFile, RotationsOfAnyAngleAreRead) {
  // About (1, 2, 2) / 3 by angles near, at and beyond half a turn: each component is the largest
  // once.
  for (const double angle : {0.1, 1.5, 3.1, 3.14159, 3.2, 6.0}) {
    for (const std::array<double, 3>& a : {std::array{1 / 3., 2 / 3., 2 / 3.},
                                           std::array{0.8, 0.6, 0.}, std::array{0.6, 0., -0.8}}) {
      const double c = std::cos(angle), s = std::sin(angle);
      // Rodrigues' formula.
      std::string text;
      const double cross[3][3] = {{0, -a[2], a[1]}, {a[2], 0, -a[0]}, {-a[1], a[0], 0}};
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
          const double entry = (i == j ? c : 0) + (1 - c) * a[i] * a[j] + s * cross[i][j];
          text += std::to_string(entry) + " ";
        }
        text += "0\n";
      }
      const auto pose = ParsePoseFile(text + "0 0 0 1\n", "p.txt");
      ASSERT_TRUE(pose.ok()) << pose.status();
      std::array<double, 4> expected = {a[0] * std::sin(angle / 2), a[1] * std::sin(angle / 2),
                                        a[2] * std::sin(angle / 2), std::cos(angle / 2)};
      double dot = 0;
      for (std::size_t i = 0; i < 4; ++i) dot += expected[i] * pose->orientation_xyzw[i];
      EXPECT_NEAR(std::abs(dot), 1, 1e-9) << angle;  // six digits are written
    }
  }
}

TEST(PoseFile, WhatIsNoRigidTransformIsRefused) {
  for (const InvalidFile& invalid : std::vector<InvalidFile>{
           {"mirrored", "-1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1", "the pose", "right-handed"},
           {"scaled", "2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1", "the pose", "orthonormal"},
           {"last row", "1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1", "the pose", "last row 0 0 0 1"},
           {"nan", "nan 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1", "the pose is nan", "must be finite"},
           {"short", "1 2 3", "the pose is 3 numbers", "must be a 4 x 4 matrix"},
           {"zero", "1 2 3 0 0 0 0", "the pose is 7 numbers", "must be a 4 x 4 matrix"}}) {
    SCOPED_TRACE(invalid.name);
    ExpectRefusal(ParsePoseFile(invalid.text, "p.txt").status(), "p.txt", invalid);
  }
}

}  // namespace
}  // namespace cwm::formats
