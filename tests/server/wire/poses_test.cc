#include "server/wire/poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/server/wire/wire_test_values.h"

namespace cwm::server {
namespace {

using ::testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Round trips convert to a unit quaternion and back: a few units in the last place.
constexpr double kRoundTrip = 1e-14;
constexpr std::int64_t kManyRows = 65'536;

std::vector<Pose> RandomPoses(int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Pose> poses;
  for (int i = 0; i < count; ++i) {
    const Quaternion q{uniform(random), uniform(random), uniform(random), uniform(random)};
    poses.push_back(MakePose({uniform(random), uniform(random), uniform(random)}, q.normalized()));
  }
  return poses;
}

std::vector<double> RowOf(const Pose& pose) {
  const v1::Pose p = PoseToProto(pose);
  return {p.tx_m(), p.ty_m(), p.tz_m(), p.qx(), p.qy(), p.qz(), p.qw()};
}

v1::PoseRows RowsOf(const std::vector<Pose>& poses) {
  v1::PoseRows rows;
  for (const Pose& pose : poses) rows.mutable_data()->append(BytesOf(RowOf(pose)));
  return rows;
}

TEST(WirePose, SurvivesARoundTrip) {
  for (const Pose& pose : RandomPoses(100)) {
    const auto back = PoseFromProto(PoseToProto(pose), {});
    ASSERT_TRUE(back.ok());
    EXPECT_TRUE(back->isApprox(pose, kRoundTrip));
  }
}

TEST(WirePose, HasANonNegativeRealPart) {
  for (const Pose& pose : RandomPoses(100)) EXPECT_GE(PoseToProto(pose).qw(), 0);
}

TEST(WirePose, IsNormalisedWithinTheToleranceAndRefusedBeyond) {
  v1::Pose pose;
  pose.set_qw(1 + 0.99 * kQuaternionTolerance);
  const auto accepted = PoseFromProto(pose, {});
  ASSERT_TRUE(accepted.ok());
  EXPECT_TRUE(accepted->linear().isIdentity(kRoundTrip));
  pose.set_qw(1 + 1.01 * kQuaternionTolerance);
  const FieldPath root;
  const auto refused = PoseFromProto(pose, root.Field("x_world_object"));
  EXPECT_EQ(FieldAtFault(refused.status()), "x_world_object.qx..qw");
  EXPECT_THAT(TextOf(refused.status()), HasSubstr("must be 1 within 1e-3"));
}

TEST(WirePose, RefusesEveryBadComponentByName) {
  struct Case {
    void (v1::Pose::*set)(double);
    std::string field;
  };
  const FieldPath root;
  for (const Case& c : std::vector<Case>{{&v1::Pose::set_tx_m, "p.tx_m"},
                                         {&v1::Pose::set_ty_m, "p.ty_m"},
                                         {&v1::Pose::set_tz_m, "p.tz_m"},
                                         {&v1::Pose::set_qx, "p.qx"},
                                         {&v1::Pose::set_qw, "p.qw"}}) {
    for (const double bad : {kNan, kInfinity, -kInfinity, 1e30}) {
      v1::Pose pose;
      pose.set_qw(1);
      (pose.*c.set)(bad);
      EXPECT_EQ(FieldAtFault(PoseFromProto(pose, root.Field("p")).status()), c.field) << bad;
    }
  }
}

TEST(WirePose, WithoutAnyFieldIsRefused) {
  EXPECT_THAT(TextOf(PoseFromProto(v1::Pose(), {}).status()), HasSubstr("has length 0, must be 1"));
}

TEST(PoseRows, SurviveARoundTripInDoublePrecision) {
  const auto poses = RandomPoses(50);
  const auto back = PosesFromProto(RowsOf(poses), kManyRows, {});
  ASSERT_TRUE(back.ok());
  ASSERT_EQ(back->size(), poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_TRUE((*back)[i].isApprox(poses[i], kRoundTrip));
  }
}

TEST(PoseRows, SurviveARoundTripInSinglePrecision) {
  const auto poses = RandomPoses(50);
  v1::PoseRows rows;
  rows.set_scalar(v1::SCALAR_F32);
  for (const Pose& pose : poses) {
    const auto row = RowOf(pose);
    rows.mutable_data()->append(BytesOf(std::vector<float>(row.begin(), row.end())));
  }
  const auto back = PosesFromProto(rows, kManyRows, {});
  ASSERT_TRUE(back.ok());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    // Each element of the matrix is affected by seven roundings of at most 2^-24.
    EXPECT_TRUE((*back)[i].isApprox(poses[i], 8 * std::ldexp(1.0, -24)));
  }
}

TEST(PoseRows, NameTheOneBadRowAmongThousands) {
  v1::PoseRows rows = RowsOf(std::vector<Pose>(4'096, Pose::Identity()));
  const double short_w = 0.9;
  rows.mutable_data()->replace((17 * 7 + 6) * sizeof(double), sizeof(double),
                               reinterpret_cast<const char*>(&short_w), sizeof(double));
  const FieldPath root;
  const FieldPath subject = root.Field("subject");
  const FieldPath shapes = subject.Field("shapes");
  const auto refused = PosesFromProto(rows, kManyRows, shapes.Field("x_world_body"));
  EXPECT_EQ(
      TextOf(refused.status()),
      "subject.shapes.x_world_body.data row 17: qx..qw has length 0.9, must be 1 within 1e-3");
}

TEST(PoseRows, RefuseAWidthThatDoesNotDivide) {
  v1::PoseRows rows = RowsOf(RandomPoses(2));
  rows.mutable_data()->pop_back();
  const FieldPath root;
  const auto refused = PosesFromProto(rows, kManyRows, root.Field("rows"));
  EXPECT_EQ(FieldAtFault(refused.status()), "rows.data");
  EXPECT_THAT(TextOf(refused.status()), HasSubstr("has 111 bytes, must be a multiple of 56"));
}

TEST(PoseRows, RefuseMoreRowsThanAllowed) {
  const v1::PoseRows rows = RowsOf(RandomPoses(5));
  EXPECT_TRUE(PosesFromProto(rows, 5, {}).ok());
  EXPECT_THAT(TextOf(PosesFromProto(rows, 4, {}).status()),
              HasSubstr("has 5 rows, must have at most 4"));
}

TEST(PoseRows, RefuseAnUnknownScalar) {
  v1::PoseRows rows;
  rows.set_scalar(static_cast<v1::Scalar>(7));
  EXPECT_EQ(FieldAtFault(PosesFromProto(rows, kManyRows, {}).status()), "scalar");
}

TEST(PointRows, AreReadAndTheirFaultsNamed) {
  v1::Subject::Points points;
  points.set_data(BytesOf<double>({1, 2, 3, 4, 5, 6}));
  const auto poses = PointPosesFromProto(points, kManyRows, {});
  ASSERT_TRUE(poses.ok());
  ASSERT_EQ(poses->size(), 2u);
  EXPECT_EQ((*poses)[1].translation(), Vector3(4, 5, 6));
  points.set_data(BytesOf<double>({1, 2, 3, 4, kNan, 6}));
  EXPECT_EQ(FieldAtFault(PointPosesFromProto(points, kManyRows, {}).status()), "data row 1");
}

TEST(RayRows, NormaliseDirectionsOfAnyLength) {
  v1::RayRows rays;
  rays.set_data(BytesOf<double>({0, 0, 1, 0, 0, -1e-200, 0, 0, 1, 3, 4, 0}));
  const auto rows = RaysFromProto(rays, kManyRows, {});
  ASSERT_TRUE(rows.ok());
  EXPECT_TRUE((*rows)[0].direction.isApprox(Vector3(0, 0, -1), kRoundTrip));
  EXPECT_TRUE((*rows)[1].direction.isApprox(Vector3(0.6, 0.8, 0), kRoundTrip));
}

TEST(RayRows, RefuseADirectionWithoutLength) {
  v1::RayRows rays;
  rays.set_data(BytesOf<double>({0, 0, 1, 0, 0, 0}));
  EXPECT_THAT(TextOf(RaysFromProto(rays, kManyRows, {}).status()),
              HasSubstr("data row 0: direction has length 0"));
}

}  // namespace
}  // namespace cwm::server
