#include "clients/cli/frame_loader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "clients/cli/exit_code.h"
#include "tests/support/process.h"

namespace cwm::cli {
namespace {

using ::testing::HasSubstr;

// An NPY of one row of depths; wider than a list of points.
template <class T>
std::string DepthRow(const char* type, const std::vector<T>& depths) {
  std::string header = std::string("{'descr': '") + type +
                       "', 'fortran_order': False, 'shape': (1, " + std::to_string(depths.size()) +
                       "), }\n";
  std::string bytes("\x93NUMPY\x01\x00", 8);
  bytes.push_back(static_cast<char>(header.size()));
  bytes.push_back(0);
  bytes += header;
  bytes.append(reinterpret_cast<const char*>(depths.data()), depths.size() * sizeof(T));
  return bytes;
}

class FrameLoading : public ::testing::Test {
 protected:
  formats::SequenceFrame Write(const std::string& name, const std::string& bytes) const {
    std::ofstream(scratch_ / name) << bytes;
    return {.path = scratch_ / name, .source = scratch_ / "frames.jsonl:1"};
  }

  testing::ScratchDirectory scratch_;
  const std::vector<std::uint16_t> depths_ = std::vector<std::uint16_t>(17, 800);
};

TEST_F(FrameLoading, DepthImagesAreSentAsTheyAreWithTheCameraBesideThem) {
  std::ofstream(scratch_ / "camera.json")
      << R"({"fx": 500, "fy": 501, "cx": 8, "cy": 0.5, "depth_unit_m": 0.0005})";
  formats::SequenceFrame frame = Write("a.npy", DepthRow("<u2", depths_));
  frame.x_world_sensor = formats::ScenePose{.position_m = {1, 2, 3}};
  FrameLoader loader({});
  const auto message = loader.Load(frame);
  ASSERT_TRUE(message.ok()) << message.status();
  EXPECT_EQ(message->depth().size(), 34u);
  EXPECT_EQ(std::memcmp(message->depth().data(), depths_.data(), 34), 0);
  EXPECT_EQ(message->x_world_sensor().tz_m(), 3);
  EXPECT_FALSE(message->has_frame_stamp());
  const cwm::v1::DepthLayout& depth = loader.layout().depth();
  EXPECT_EQ(depth.type(), cwm::v1::DEPTH_TYPE_U16);
  EXPECT_EQ(depth.width(), 17);
  EXPECT_EQ(depth.height(), 1);
  EXPECT_EQ(depth.unit_m(), 0.0005);
  EXPECT_EQ(depth.pinhole().fy_px(), 501);
}

TEST_F(FrameLoading, OptionsOverrideUnitIntrinsicsAndPoses) {
  formats::SequenceFrame frame = Write("a.npy", DepthRow("<f4", std::vector<float>(17, 1)));
  frame.x_world_sensor = formats::ScenePose{};
  FrameLoader loader({.intrinsics = "500,500,8,0", .unit_m = 2, .use_poses = false});
  const auto message = loader.Load(frame);
  ASSERT_TRUE(message.ok()) << message.status();
  EXPECT_FALSE(message->has_x_world_sensor());
  EXPECT_EQ(loader.layout().depth().type(), cwm::v1::DEPTH_TYPE_F32);
  EXPECT_EQ(loader.layout().depth().unit_m(), 2);
}

TEST_F(FrameLoading, CloudsAreSentByTheirGeometry) {
  FrameLoader loader({});
  const auto message = loader.Load(
      Write("a.pcd",
            "VERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n"
            "WIDTH 2\nHEIGHT 2\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4\nDATA ascii\n"
            "0 0 1 9\n1 0 1 9\n0 1 1 9\n1 1 1 9\n"));
  ASSERT_TRUE(message.ok()) << message.status();
  EXPECT_EQ(message->points().size(), 4 * 12u);
  EXPECT_EQ(loader.layout().width(), 2);
  EXPECT_EQ(loader.layout().height(), 2);
  EXPECT_EQ(loader.layout().layout().fields_size(), 3);
}

TEST_F(FrameLoading, FramesUnlikeTheFirstAreRefused) {
  FrameLoader loader({.intrinsics = "500,500,8,0"});
  ASSERT_TRUE(loader.Load(Write("a.npy", DepthRow("<u2", depths_))).ok());
  const auto wide = loader.Load(Write("b.npy", DepthRow("<u2", std::vector<std::uint16_t>(18, 1))));
  EXPECT_THAT(std::string(wide.status().message()),
              HasSubstr("b.npy: the frame is a depth image of 18 x 1 integers, must be a depth "
                        "image of 17 x 1 integers like "));
  EXPECT_THAT(std::string(wide.status().message()), HasSubstr("frames.jsonl:1: "));
  EXPECT_FALSE(loader.Load(Write("c.npy", DepthRow("<f4", std::vector<float>(17, 1)))).ok());
  EXPECT_TRUE(loader.Load(Write("d.npy", DepthRow("<u2", depths_))).ok());
}

TEST_F(FrameLoading, WhatIsMissingIsNamed) {
  FrameLoader loader({});
  EXPECT_THAT(
      std::string(
          loader.Load({.path = scratch_ / "absent.png", .source = "list:7"}).status().message()),
      HasSubstr("list:7: "));
  const auto no_camera = loader.Load(Write("a.npy", DepthRow("<u2", depths_)));
  EXPECT_TRUE(IsUsageError(no_camera.status())) << no_camera.status();
  EXPECT_THAT(std::string(no_camera.status().message()), HasSubstr("--intrinsics"));
}

}  // namespace
}  // namespace cwm::cli
