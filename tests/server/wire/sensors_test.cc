// Depth images, uploads of them, and what watchers get of running sensors.
#include "server/wire/sensors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "server/wire/watch_events.h"
#include "tests/server/core/test_objects.h"
#include "tests/server/wire/wire_test_values.h"

namespace cwm::server {
namespace {

using ::testing::FloatEq;
using ::testing::HasSubstr;
using ::testing::Pointwise;

constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinite = std::numeric_limits<float>::infinity();

v1::DepthLayout Layout(v1::DepthType type, int width, int height) {
  v1::DepthLayout layout;
  layout.set_type(type);
  layout.set_width(width);
  layout.set_height(height);
  layout.mutable_pinhole()->set_fx_px(100);
  layout.mutable_pinhole()->set_fy_px(50);
  layout.mutable_pinhole()->set_cx_px(1);
  layout.mutable_pinhole()->set_cy_px(0.5);
  return layout;
}

absl::StatusOr<std::vector<float>> Decode(const v1::DepthLayout& layout, std::string_view bytes) {
  const FieldPath root;
  const auto plan = DepthPlanFromProto(layout, root.Field("depth"));
  if (!plan.ok()) return plan.status();
  const auto image = DecodeDepth(*plan, bytes, root.Field("data"));
  if (!image.ok()) return image.status();
  return (*image)->depth_m;
}

TEST(WireDepth, DepthsAreInMetresAndNoReturnsAreZero) {
  v1::DepthLayout layout = Layout(v1::DEPTH_TYPE_U16, 2, 2);
  const std::string bytes = BytesOf<std::uint16_t>({0, 1500, 65534, 65535});
  auto depths = Decode(layout, bytes);
  ASSERT_TRUE(depths.ok()) << depths.status();
  EXPECT_THAT(*depths, Pointwise(FloatEq(), {0.0F, 1.5F, 65.534F, 0.0F}));
  layout.set_unit_m(0.0002);
  depths = Decode(layout, bytes);
  EXPECT_FLOAT_EQ((*depths)[1], 0.3F);
  layout = Layout(v1::DEPTH_TYPE_F32, 3, 2);
  depths = Decode(layout, BytesOf<float>({kNotANumber, kInfinite, -kInfinite, -2, 0, 2.5F}));
  ASSERT_TRUE(depths.ok());
  EXPECT_EQ(*depths, (std::vector<float>{0, 0, 0, 0, 0, 2.5F}));
  EXPECT_THAT(Decode(layout, "12").status().message(), HasSubstr("data: has 2 bytes"));
}

TEST(WireDepth, AnUploadedDepthImageIsTheOrganisedCloudOfItsCamera) {
  v1::IngestCloudHeader header;
  *header.mutable_depth() = Layout(v1::DEPTH_TYPE_U16, 3, 2);
  const FieldPath root;
  const FieldPath path = root.Field("header");
  const auto plan = CloudPlanFromProto(header, Limits{}, path);
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_EQ(plan->point_count, 6);
  EXPECT_EQ(plan->total_bytes, 12);
  const auto cloud = DecodeCloud(*plan, BytesOf<std::uint16_t>({1000, 0, 2000, 3000, 65535, 1000}));
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_TRUE(cloud->cloud.organised());
  EXPECT_EQ(cloud->cloud.width, 3);
  EXPECT_EQ(cloud->cloud.height, 2);
  EXPECT_TRUE(cloud->cloud.points[0].isApprox(Eigen::Vector3f(-0.01F, -0.01F, 1)));
  EXPECT_TRUE(std::isnan(cloud->cloud.points[1].x()));
  EXPECT_TRUE(cloud->cloud.points[3].isApprox(Eigen::Vector3f(-0.03F, 0.03F, 3)));
  EXPECT_FALSE(DecodeCloud(*plan, std::string(12, '\0')).ok());  // no return at all
}

TEST(WirePoints, ThatTheKnownCameraDoesNotSeeTellAnotherOne) {
  constexpr int kWidth = 64, kHeight = 48;
  v1::SensorCalibration calibration;
  calibration.set_sensor("head");
  v1::CloudLayout& layout = *calibration.mutable_layout();
  for (const char* name : {"x", "y", "z"}) {
    v1::CloudField& field = *layout.add_fields();
    field.set_name(name);
    field.set_type(v1::FIELD_TYPE_F32);
    field.set_offset(4 * (layout.fields_size() - 1));
  }
  layout.set_point_step(12);
  calibration.set_width(kWidth);
  calibration.set_height(kHeight);
  calibration.set_greatest_range_m(5);
  const FieldPath root;
  const auto plan = SensorPlanFromProto(calibration, Limits{}, root);
  ASSERT_TRUE(plan.ok()) << plan.status();
  // A wall at 1.5 m.
  const auto wall = [](float focal_px, float center_u_px) {
    std::vector<float> xyz;
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        const auto column = static_cast<float>(u), row = static_cast<float>(v);
        xyz.insert(xyz.end(), {1.5F * (column - center_u_px) / focal_px,
                               1.5F * (row - 23.5F) / focal_px, 1.5F});
      }
    }
    return xyz;
  };
  const auto read = [&](const std::vector<float>& xyz,
                        const std::optional<perception::DepthCamera>& known) {
    v1::SensorFrame frame;
    frame.set_points(BytesOf<float>(xyz));
    LiveFrame live;
    const absl::Status status = ImageFromProto(frame, *plan, known, root, live);
    return status.ok() ? absl::StatusOr<LiveFrame>(live) : status;
  };
  const auto first = read(wall(64, 31.5F), std::nullopt);
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_NEAR(first->camera.pinhole.focal_u_px, 64, 1e-3);
  perception::DepthCamera known = first->camera;
  known.greatest_range_m = 9;                      // of an earlier stream
  const auto same = read(wall(64, 32.5F), known);  // one pixel aside
  ASSERT_TRUE(same.ok()) << same.status();
  EXPECT_EQ(same->camera, first->camera);
  for (const auto& [focal_px, center_u_px] : {std::pair{32.0F, 31.5F}, std::pair{64.0F, 40.0F}}) {
    const auto other = read(wall(focal_px, center_u_px), known);
    ASSERT_TRUE(other.ok()) << other.status();
    EXPECT_NEAR(other->camera.pinhole.focal_u_px, focal_px, 1e-3);
    EXPECT_NEAR(other->camera.pinhole.center_u_px, center_u_px, 1e-3);
  }
  std::vector<float> turned = wall(64, 31.5F);
  std::ranges::reverse(turned);
  EXPECT_THAT(read(turned, known).status().message(), HasSubstr("points: fits no pinhole camera"));
  const std::vector<float> nothing(turned.size(), kNotANumber);
  const auto empty = read(nothing, known);
  ASSERT_TRUE(empty.ok()) << empty.status();
  EXPECT_EQ(empty->camera, first->camera);
}

TEST(WireDepth, WhatAnImageTellsMustAgreeWithIt) {
  const FieldPath root;
  const FieldPath path = root.Field("header");
  v1::IngestCloudHeader header;
  *header.mutable_depth() = Layout(v1::DEPTH_TYPE_U16, 3, 2);
  header.set_point_count(6);
  header.set_total_bytes(12);
  header.set_width(3);
  header.set_height(2);
  EXPECT_TRUE(CloudPlanFromProto(header, Limits{}, path).ok());
  const auto error = [&](const v1::IngestCloudHeader& bad) {
    return std::string(CloudPlanFromProto(bad, Limits{}, path).status().message());
  };
  v1::IngestCloudHeader bad = header;
  bad.set_point_count(5);
  EXPECT_THAT(error(bad), HasSubstr("header.point_count: is 5, must be absent or 6"));
  bad = header;
  bad.set_total_bytes(13);
  EXPECT_THAT(error(bad), HasSubstr("header.total_bytes: is 13"));
  bad = header;
  bad.mutable_layout()->set_point_step(12);
  EXPECT_THAT(error(bad), HasSubstr("header.layout: is set, must be absent"));
  bad = header;
  bad.set_scale(0.001);
  EXPECT_THAT(error(bad), HasSubstr("header.scale: is set"));
  bad = header;
  bad.set_frame(v1::CLOUD_FRAME_WORLD);
  EXPECT_THAT(error(bad), HasSubstr("header.frame: is set"));
  bad = header;
  bad.mutable_depth()->mutable_pinhole()->set_fx_px(0);
  EXPECT_THAT(error(bad), HasSubstr("header.depth.pinhole.fx_px: is 0"));
}

TEST(WireSensors, NamesHaveNoControlCharacters) {
  const FieldPath root;
  const FieldPath path = root.Field("sensor");
  for (const char* name : {"head", "wrist camera", "Kamera über dem Tisch", "棚"}) {
    EXPECT_TRUE(CheckSensorName(name, path).ok()) << name;
  }
  EXPECT_EQ(FieldAtFault(CheckSensorName("", path)), "sensor");
  for (const char* name : {"a\nb", "\x1b[2Jhead", "tab\t", "\x7f", "c1 \xc2\x9b 2J"}) {
    const absl::Status status = CheckSensorName(name, path);
    EXPECT_EQ(FieldAtFault(status), "sensor");
    EXPECT_THAT(status.message(), ::testing::Not(HasSubstr(name)));
  }
  EXPECT_THAT(CheckSensorName("\x1b[2J", path).message(),
              HasSubstr("sensor: is \"\\x1b[2J\", must have no control characters"));
  EXPECT_THAT(CheckSensorName(std::string(129, 'a'), path).message(), HasSubstr("at most 128"));
}

// A watcher of a moving object gets some 130 bytes a frame: the world's uid, the revision, the
// object's name, its pose in doubles, its motion.
TEST(WireSensorFacts, AMovingObjectIsToldInFewBytes) {
  const auto world = std::make_shared<World>("w", std::string(32, 'u'), Retention{});
  ASSERT_TRUE(world->Apply(std::vector{Put("object_12")}, {}).ok());
  const SnapshotPtr before = world->Snapshot();
  world->observations().SetFacts("object_12",
                                 SensorFacts{.motion = SensorFacts::Motion::kMoving,
                                             .visibility = SensorFacts::Visibility::kVisible},
                                 *before);
  const Pose X_WO =
      MakeTranslation(0.123, 0.456, 0.789) * Eigen::AngleAxisd(0.3, Vector3(1, 2, 3).normalized());
  ASSERT_TRUE(
      world->Apply(std::vector{collision::Change{collision::MoveObject{"object_12", X_WO}, {}}}, {})
          .ok());
  GeometryStore store(1 << 20, Limits{});
  WatchStep step{.kind = WatchStep::Kind::kEvents,
                 .revision = world->Snapshot()->revision(),
                 .deltas = collision::Difference(*before, *world->Snapshot())};
  std::size_t next = 0;
  const v1::WatchWorldResponse message = EventsPiece(step, {*world, View::kShapes, store}, &next);
  ASSERT_EQ(message.events().events_size(), 1);
  EXPECT_EQ(message.events().events(0).move().name(), "object_12");
  EXPECT_EQ(message.events().events(0).motion(), v1::MOTION_MOVING);
  EXPECT_LT(message.events().events(0).ByteSizeLong(), 90U);
  EXPECT_LT(message.ByteSizeLong(), 140U);
  // The other facts follow with the next bookmark.
  std::uint64_t observed = 0;
  const v1::WatchWorldResponse bookmark =
      BookmarkMessage(world->Snapshot()->revision(), *world, &observed);
  ASSERT_TRUE(bookmark.bookmark().facts().contains("object_12"));
  const v1::SensorFacts& facts = bookmark.bookmark().facts().at("object_12");
  EXPECT_EQ(facts.visibility(), v1::VISIBILITY_VISIBLE);
  EXPECT_TRUE(facts.identity_certain());
  EXPECT_EQ(
      BookmarkMessage(world->Snapshot()->revision(), *world, &observed).bookmark().facts_size(), 0);
  // No longer followed: told as facts without a value.
  world->observations().SetFacts("object_12", std::nullopt, *world->Snapshot());
  const v1::WatchWorldResponse last =
      BookmarkMessage(world->Snapshot()->revision(), *world, &observed);
  EXPECT_EQ(last.bookmark().facts().at("object_12").motion(), v1::MOTION_UNSPECIFIED);
}

}  // namespace
}  // namespace cwm::server
