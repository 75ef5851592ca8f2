#include "server/wire/clouds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "tests/server/wire/wire_test_values.h"

namespace cwm::server {
namespace {

using ::testing::HasSubstr;

constexpr float kNanF = std::numeric_limits<float>::quiet_NaN();

void AddField(v1::CloudLayout* layout, const char* name, int offset, v1::FieldType type) {
  v1::CloudField* field = layout->add_fields();
  field->set_name(name);
  field->set_offset(offset);
  field->set_type(type);
}

// Points with x y z in single precision.
v1::IngestCloudHeader PackedHeader(std::int64_t count) {
  v1::IngestCloudHeader header;
  AddField(header.mutable_layout(), "x", 0, v1::FIELD_TYPE_F32);
  AddField(header.mutable_layout(), "y", 4, v1::FIELD_TYPE_F32);
  AddField(header.mutable_layout(), "z", 8, v1::FIELD_TYPE_F32);
  header.mutable_layout()->set_point_step(12);
  header.set_point_count(count);
  header.set_total_bytes(12 * count);
  return header;
}

absl::StatusOr<CloudPlan> Convert(const v1::IngestCloudHeader& header) {
  const FieldPath root;
  return CloudPlanFromProto(header, Limits{}, root.Field("header"));
}

TEST(WireCloud, PackedPointsAreReadAsTheyLie) {
  const auto plan = Convert(PackedHeader(3));
  ASSERT_TRUE(plan.ok()) << plan.status();
  const auto cloud = DecodeCloud(*plan, BytesOf<float>({1, 2, 3, kNanF, kNanF, kNanF, 7, 8, 9}));
  ASSERT_TRUE(cloud.ok());
  ASSERT_EQ(cloud->cloud.size(), 3u);
  EXPECT_EQ(cloud->cloud.points[0], Eigen::Vector3f(1, 2, 3));
  EXPECT_TRUE(std::isnan(cloud->cloud.points[1].x()));
  EXPECT_EQ(cloud->cloud.points[2], Eigen::Vector3f(7, 8, 9));
  EXPECT_FALSE(cloud->cloud.organised());
  EXPECT_TRUE(cloud->cloud.normals.empty());
}

TEST(WireCloud, MixedLayoutsAreReadFieldByField) {
  v1::IngestCloudHeader header;
  v1::CloudLayout* layout = header.mutable_layout();
  AddField(layout, "z", 0, v1::FIELD_TYPE_F64);
  AddField(layout, "rgb", 8, v1::FIELD_TYPE_U32);
  AddField(layout, "y", 12, v1::FIELD_TYPE_F32);
  AddField(layout, "x", 16, v1::FIELD_TYPE_F64);
  AddField(layout, "normal_x", 24, v1::FIELD_TYPE_F32);
  AddField(layout, "normal_y", 28, v1::FIELD_TYPE_F32);
  AddField(layout, "normal_z", 32, v1::FIELD_TYPE_F32);
  layout->set_point_step(40);
  header.set_point_count(2);
  header.set_total_bytes(80);
  const auto plan = Convert(header);
  ASSERT_TRUE(plan.ok()) << plan.status();
  std::string bytes;
  for (const float base : {1.0f, 10.0f}) {
    bytes += BytesOf<double>({base + 2}) + BytesOf<std::uint32_t>({0}) +
             BytesOf<float>({base + 1}) + BytesOf<double>({base}) + BytesOf<float>({0, 0, base, 0});
  }
  const auto cloud = DecodeCloud(*plan, bytes);
  ASSERT_TRUE(cloud.ok());
  EXPECT_EQ(cloud->cloud.points[1], Eigen::Vector3f(10, 11, 12));
  EXPECT_EQ(cloud->cloud.normals[1], Eigen::Vector3f(0, 0, 10));
}

TEST(WireCloud, DoublesThatWouldLoseTheirPrecisionAreRefused) {
  v1::IngestCloudHeader header;
  AddField(header.mutable_layout(), "x", 0, v1::FIELD_TYPE_F64);
  AddField(header.mutable_layout(), "y", 8, v1::FIELD_TYPE_F64);
  AddField(header.mutable_layout(), "z", 16, v1::FIELD_TYPE_F64);
  header.mutable_layout()->set_point_step(24);
  header.set_point_count(2);
  header.set_total_bytes(48);
  const auto plan = Convert(header);
  ASSERT_TRUE(plan.ok());
  EXPECT_TRUE(
      DecodeCloud(*plan, BytesOf<double>({0, 0, 1, 0.99 * kMaxPointDistance_m, 0, 1})).ok());
  const auto refused = DecodeCloud(*plan, BytesOf<double>({0, 0, 1, 0, 4.5e6, 1}));
  EXPECT_EQ(FieldAtFault(refused.status()), "point 1.y");
  EXPECT_THAT(TextOf(refused.status()),
              HasSubstr("for a map's offset the viewpoint or x_world_sensor"));
  EXPECT_THAT(TextOf(refused.status()), HasSubstr("for millimetres give a scale of 0.001"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(DecodeCloud(*plan, BytesOf<double>({nan, nan, nan, 0, 0, 1})).ok());
}

// Coordinates times the scale, less the viewpoint.
TEST(WireCloud, PointsBecomeMetresRelativeToTheirViewpoint) {
  v1::IngestCloudHeader header = PackedHeader(3);
  header.set_scale(0.001);
  header.mutable_viewpoint()->set_x(1);
  header.mutable_viewpoint()->set_z(2);
  const auto plan = Convert(header);
  ASSERT_TRUE(plan.ok()) << plan.status();
  const auto decoded =
      DecodeCloud(*plan, BytesOf<float>({1500, 250, 1000, 0, 0, 0, 1000, 0, 2000}));
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_TRUE(decoded->cloud.points[0].isApprox(Eigen::Vector3f(0.5F, 0.25F, -1)));
  EXPECT_TRUE(decoded->cloud.points[1].isZero(0)) << "no return, as the driver says it";
  EXPECT_TRUE(decoded->cloud.points[2].isZero(0)) << "a no-return that was turned into a frame";
  EXPECT_EQ(decoded->viewpoint_C, Vector3(1, 0, 2));
  EXPECT_TRUE(decoded->cloud.seen_from_origin);
}

TEST(WireCloud, PointsOfTheWorldHaveNoPoseAndMayHaveBeenSeenFromAnywhere) {
  v1::IngestCloudHeader header = PackedHeader(2);
  header.set_frame(v1::CLOUD_FRAME_WORLD);
  const auto plan = Convert(header);
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_TRUE(plan->request.in_world_frame);
  EXPECT_TRUE(plan->request.options.X_WC->isApprox(Pose::Identity()));
  const auto decoded = DecodeCloud(*plan, BytesOf<float>({1000, 4, 1, 1002, 4, 1}));
  ASSERT_TRUE(decoded.ok());
  EXPECT_EQ(decoded->viewpoint_C, Vector3(1001, 4, 1 + kUnknownHeight_m));
  EXPECT_TRUE(decoded->cloud.points[0].isApprox(Eigen::Vector3f(-1, 0, -1.5F)));
  EXPECT_FALSE(decoded->cloud.seen_from_origin);
  header.mutable_viewpoint()->set_z(3);
  EXPECT_TRUE(Convert(header)->request.cloud.seen_from_origin);
  header.mutable_up()->set_z(1);
  EXPECT_EQ(FieldAtFault(Convert(header).status()), "header.up");
}

TEST(WireCloud, ScalesFramesAndNoiseAreCheckedByTheirFields) {
  v1::IngestCloudHeader header = PackedHeader(1);
  header.set_scale(-1);
  EXPECT_EQ(FieldAtFault(Convert(header).status()), "header.scale");
  header.set_scale(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(FieldAtFault(Convert(header).status()), "header.scale");
  header.set_scale(0);
  header.set_frame(static_cast<v1::CloudFrame>(7));
  EXPECT_EQ(FieldAtFault(Convert(header).status()), "header.frame");
  header.clear_frame();
  header.mutable_sensor_model()->set_kind(v1::SensorModel::KIND_QUADRATIC);
  EXPECT_EQ(FieldAtFault(Convert(header).status()), "header.sensor_model.quadratic_per_m");
  header.mutable_sensor_model()->set_sigma_m(0.001);
  header.mutable_sensor_model()->set_quadratic_per_m(0.002);
  const auto plan = Convert(header);
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_DOUBLE_EQ(plan->request.options.noise.AxialSigma_m(2), 0.009);
}

// The interpreter judges the unit from the whole cloud, and single precision can hold the values.
TEST(WireCloud, MillimetresAsFloatsAreLeftToTheInterpreter) {
  const auto plan = Convert(PackedHeader(2));
  ASSERT_TRUE(plan.ok());
  EXPECT_TRUE(DecodeCloud(*plan, BytesOf<float>({0, 0, 800, 0, 120, 5000})).ok());
}

TEST(WireCloud, CloudsWithoutAPointAreRefusedByTheirField) {
  const auto plan = Convert(PackedHeader(2));
  ASSERT_TRUE(plan.ok());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto nothing = DecodeCloud(*plan, BytesOf<float>({nan, nan, nan, 0, nan, 1}));
  EXPECT_EQ(FieldAtFault(nothing.status()), "chunk.data");
  EXPECT_THAT(TextOf(nothing.status()), HasSubstr("2 points, none of them finite"));
  EXPECT_TRUE(DecodeCloud(*plan, BytesOf<float>({nan, nan, nan, 0, 0, 1})).ok());
}

TEST(WireCloud, CoordinatesThatNoWorldHoldsAreRefusedByTheirPoint) {
  const auto plan = Convert(PackedHeader(2));
  ASSERT_TRUE(plan.ok());
  const auto far = DecodeCloud(*plan, BytesOf<float>({0, 0, 1, 0, -1e30f, 1}));
  EXPECT_EQ(FieldAtFault(far.status()), "point 1.y");
  EXPECT_THAT(TextOf(far.status()), HasSubstr("is -1e+30, must be within 1e+06"));
  EXPECT_TRUE(DecodeCloud(*plan, BytesOf<float>({0, 0, 1, 0, -1e6f, 1})).ok());
}

TEST(WireCloud, TheWriterCanNameTheWorldAndTheRevisionThatItKnows) {
  v1::IngestCloudHeader header = PackedHeader(1);
  EXPECT_EQ(Convert(header)->request.write.expected_revision, std::nullopt);
  header.set_expected_revision(7);
  header.set_world_uid("uid");
  const auto plan = Convert(header);
  ASSERT_TRUE(plan.ok());
  EXPECT_EQ(plan->request.write.expected_revision, collision::Revision{7});
  EXPECT_EQ(plan->world_uid, "uid");
}

TEST(WireCloud, KindsOfShapesCanBeSwitchedOff) {
  v1::IngestCloudHeader header = PackedHeader(1);
  const auto all = Convert(header);
  ASSERT_TRUE(all.ok());
  EXPECT_TRUE(all->request.options.modeler.search_cylinders);
  header.mutable_options()->set_search_cylinders(false);
  const auto some = Convert(header);
  ASSERT_TRUE(some.ok());
  EXPECT_FALSE(some->request.options.modeler.search_cylinders);
  EXPECT_TRUE(some->request.options.modeler.search_planes);
  EXPECT_TRUE(some->request.options.modeler.search_spheres);
  EXPECT_TRUE(some->request.options.modeler.search_cones);
}

TEST(WireCloud, ClutterCanBeLeftWithoutClusters) {
  v1::IngestCloudHeader header = PackedHeader(1);
  EXPECT_EQ(Convert(header)->request.options.clustering, perception::Clustering::kObjects);
  header.mutable_options()->set_clustering(v1::CLUSTERING_NONE);
  EXPECT_EQ(Convert(header)->request.options.clustering, perception::Clustering::kNone);
  header.mutable_options()->set_clustering(static_cast<v1::Clustering>(77));
  EXPECT_FALSE(Convert(header).ok());
}

TEST(WireCloud, OrganisedCloudsKeepTheirShape) {
  v1::IngestCloudHeader header = PackedHeader(6);
  header.set_width(3);
  header.set_height(2);
  const auto plan = Convert(header);
  ASSERT_TRUE(plan.ok());
  EXPECT_EQ(plan->request.cloud.width, 3);
  EXPECT_EQ(plan->request.cloud.height, 2);
}

TEST(WireCloud, OptionsReachTheInterpreter) {
  v1::IngestCloudHeader header = PackedHeader(1);
  header.set_world("w");
  header.set_sensor("head");
  header.set_request_id("r1");
  header.set_mode(v1::INGEST_MODE_SEGMENT_ONLY);
  header.mutable_up()->set_y(-2);
  header.mutable_x_world_sensor()->set_qx(1);
  header.mutable_sensor_model()->set_kind(v1::SensorModel::KIND_CONSTANT);
  header.mutable_sensor_model()->set_sigma_m(0.004);
  header.mutable_time_budget()->set_seconds(2);
  header.mutable_frame_stamp()->set_seconds(1'000);
  const auto plan = Convert(header);
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_EQ(plan->world, "w");
  EXPECT_EQ(plan->request.sensor, "head");
  EXPECT_EQ(plan->request.write.request_id, "r1");
  EXPECT_EQ(plan->request.mode, IngestMode::kSegmentOnly);
  EXPECT_EQ(plan->request.options.up_C, Vector3(0, -2, 0));
  EXPECT_TRUE(plan->request.options.X_WC.has_value());
  EXPECT_EQ(plan->request.options.noise.given_sigma_m, 0.004);
  EXPECT_EQ(plan->time_budget, std::chrono::seconds(2));
  EXPECT_EQ(plan->request.frame_stamp.time_since_epoch(), std::chrono::seconds(1'000));
}

TEST(WireCloud, HeadersThatLieAreRefusedByTheirField) {
  struct Case {
    std::function<void(v1::IngestCloudHeader&)> spoil;
    std::string field;
  };
  const std::vector<Case> cases = {
      {[](auto& h) { h.set_point_count(0); }, "header.point_count"},
      {[](auto& h) { h.set_sensor("head\x1b[2J"); }, "header.sensor"},
      {[](auto& h) { h.set_point_count(-5); }, "header.point_count"},
      {[](auto& h) { h.set_point_count(20'000'001); }, "header.point_count"},
      {[](auto& h) { h.set_point_count(std::numeric_limits<std::int64_t>::max()); },
       "header.point_count"},
      {[](auto& h) { h.set_total_bytes(h.total_bytes() - 1); }, "header.total_bytes"},
      {[](auto& h) { h.set_width(-1); }, "header.width"},
      {[](auto& h) {
         h.set_width(3);
         h.set_height(3);
       },
       "header.height"},
      {[](auto& h) { h.clear_layout(); }, "header.layout.point_step"},
      {[](auto& h) { h.mutable_layout()->clear_fields(); }, "header.layout.fields"},
      {[](auto& h) { h.mutable_layout()->mutable_fields(2)->set_name("w"); },
       "header.layout.fields"},
      {[](auto& h) { h.mutable_layout()->mutable_fields(2)->set_name("x"); },
       "header.layout.fields[2].name"},
      {[](auto& h) { h.mutable_layout()->mutable_fields(2)->set_offset(9); },
       "header.layout.fields[2].offset"},
      {[](auto& h) { h.mutable_layout()->mutable_fields(0)->set_offset(-4); },
       "header.layout.fields[0].offset"},
      {[](auto& h) { h.mutable_layout()->mutable_fields(1)->set_type(v1::FIELD_TYPE_I32); },
       "header.layout.fields[1].type"},
      {[](auto& h) { h.mutable_layout()->mutable_fields(1)->clear_type(); },
       "header.layout.fields[1].type"},
      {[](auto& h) { h.mutable_up(); }, "header.up"},
      {[](auto& h) { h.mutable_up()->set_x(std::numeric_limits<double>::infinity()); },
       "header.up.x"},
      {[](auto& h) { h.mutable_x_world_sensor(); }, "header.x_world_sensor.qx..qw"},
      {[](auto& h) { h.mutable_sensor_model()->set_kind(v1::SensorModel::KIND_CONSTANT); },
       "header.sensor_model.sigma_m"},
      {[](auto& h) { h.set_mode(static_cast<v1::IngestMode>(12)); }, "header.mode"},
      {[](auto& h) { h.mutable_time_budget()->set_seconds(-1); }, "header.time_budget"},
      {[](auto& h) { h.mutable_frame_stamp()->set_nanos(-1); }, "header.frame_stamp"},
      {[](auto& h) { h.set_request_id(std::string(1'000, 'r')); }, "header.request_id"},
  };
  for (const Case& c : cases) {
    v1::IngestCloudHeader header = PackedHeader(6);
    c.spoil(header);
    EXPECT_EQ(FieldAtFault(Convert(header).status()), c.field) << Convert(header).status();
  }
}

IngestOutcome Outcome(std::size_t label_count) {
  IngestOutcome outcome;
  outcome.revision = {4};
  outcome.report.points_in = label_count;
  outcome.labels.assign(label_count, 20);
  outcome.added = {"object_1"};
  return outcome;
}

TEST(WireCloud, LabelsTravelInlineOrByHash) {
  const World world("w", "uid", Retention{});
  GeometryStore store(1 << 20);
  Limits limits;
  limits.max_inline_bytes = 16;
  v1::IngestCloudResponse small;
  ASSERT_TRUE(IngestReplyToProto({Outcome(4), world, true}, limits, store, &small).ok());
  EXPECT_EQ(NumbersIn<std::uint32_t>(small.labels()), std::vector<std::uint32_t>(4, 20));
  EXPECT_EQ(small.revision(), 4);
  EXPECT_EQ(small.changes().added(0), "object_1");
  v1::IngestCloudResponse large;
  ASSERT_TRUE(IngestReplyToProto({Outcome(5), world, true}, limits, store, &large).ok());
  EXPECT_TRUE(large.labels().empty());
  const auto blob = store.Get(large.labels_hash());
  ASSERT_TRUE(blob.ok());
  EXPECT_EQ(NumbersIn<std::uint32_t>(*(*blob)->bytes), std::vector<std::uint32_t>(5, 20));
  v1::IngestCloudResponse none;
  ASSERT_TRUE(IngestReplyToProto({Outcome(5), world, false}, limits, store, &none).ok());
  EXPECT_TRUE(none.labels().empty() && none.labels_hash().empty());
}

}  // namespace
}  // namespace cwm::server
