#include "perception/mesh_hypothesis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numeric>
#include <stop_token>
#include <vector>

namespace cwm::perception {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr int kAlongSquare = 41;
constexpr std::size_t kOfSquare = std::size_t{kAlongSquare} * kAlongSquare;
constexpr float kLow_m = 0.5f, kHigh_m = 0.7f;

// Points of a level square of 8 cm around (1, 2) at this height, 2 mm apart.
void AddSquare(float height_m, OrientedPoints& points) {
  for (int row = 0; row < kAlongSquare; ++row) {
    for (int column = 0; column < kAlongSquare; ++column) {
      points.points.emplace_back(0.96f + 0.002f * static_cast<float>(column),
                                 1.96f + 0.002f * static_cast<float>(row), height_m);
      points.normals.push_back(Eigen::Vector3f::UnitZ());
      points.sigma_m.push_back(0.001f);
      points.normal_sigma_rad.push_back(0.05f);
      points.cloud_index.push_back(static_cast<std::uint32_t>(points.cloud_index.size()));
    }
  }
}

// One square is the top of a box; the other is 20 cm above it.
OrientedPoints TwoSquares() {
  OrientedPoints points;
  points.viewpoint = Vector3(1, 2, 2);
  AddSquare(kLow_m, points);
  AddSquare(kHigh_m, points);
  return points;
}

// The box below the lower square, with the part numbers to which the points of the two squares
// belong.
HypothesisModel BoxModel(std::int32_t part_of_low, std::int32_t part_of_high) {
  HypothesisModel model;
  model.object.shapes.push_back(
      {.X_OS = MakeTranslation(1, 2, kLow_m - 0.05),
       .shape = Box{{0.1, 0.1, 0.1}},
       .fit = FitQuality{.inlier_count = kOfSquare, .parameter_sigma = {}}});
  model.object.part_of_point.assign(kOfSquare, part_of_low);
  model.object.part_of_point.insert(model.object.part_of_point.end(), kOfSquare, part_of_high);
  return model;
}

MeshedObject MeshedOf(const OrientedPoints& points, const HypothesisModel& model,
                      std::size_t node_count, const Work& work = {}) {
  ObjectHypothesis hypothesis;
  hypothesis.points.resize(points.size());
  std::iota(hypothesis.points.begin(), hypothesis.points.end(), 0u);
  hypothesis.node_count = node_count;
  hypothesis.model = std::make_shared<const HypothesisModel>(model);
  return MeshHypothesis(hypothesis, points, {}, work);
}

MeshedObject MeshedOf(const HypothesisModel& model) {
  return MeshedOf(TwoSquares(), model, 2 * kOfSquare);
}

// Expects a mesh of the upper square, in the object's frame, whose origin is half-way between the
// squares.
void ExpectUpperSquare(const Mesh& surface) {
  ASSERT_NE(surface.mesh, nullptr);
  EXPECT_THAT(surface.mesh->triangles, ::testing::Not(IsEmpty()));
  for (const Vector3& v : surface.mesh->vertices) {
    EXPECT_NEAR(v.z(), 0.1, kThinningSpacing_m);
    EXPECT_LT(v.head<2>().cwiseAbs().maxCoeff(), 0.04 + kThinningSpacing_m);
  }
}

TEST(MeshHypothesis, MeshesWhatNoShapeReachesWhateverItsLabelsSay) {
  for (const std::int32_t label : {kUnexplained, 0}) {
    HypothesisModel model = BoxModel(label, label);
    const MeshedObject object = MeshedOf(model);
    EXPECT_LT((object.X_LO.translation() - Vector3(1, 2, 0.6)).norm(), 1e-5);
    EXPECT_TRUE(object.X_LO.linear().isIdentity());
    EXPECT_EQ(object.explained, 2 * kOfSquare);
    EXPECT_EQ(object.model->point_count, static_cast<int>(2 * kOfSquare));
    ASSERT_THAT(object.model->shapes, SizeIs(1));
    const Vector3 middle = object.model->shapes[0].X_OS.translation();
    EXPECT_LT((middle - Vector3(0, 0, -0.15)).norm(), 1e-5);
    EXPECT_EQ(object.model->shapes[0].fit->inlier_count, static_cast<int>(kOfSquare));
    ASSERT_THAT(object.model->surfaces, SizeIs(1));
    EXPECT_EQ(object.model->surfaces[0].point_count, static_cast<int>(kOfSquare));
    ExpectUpperSquare(object.model->surfaces[0].surface);
    // Twice the spacing makes a quarter of the triangles.
    model.is_reduced_effort = true;
    const MeshedObject coarse = MeshedOf(model);
    ASSERT_THAT(coarse.model->surfaces, SizeIs(1));
    EXPECT_LT(2 * coarse.model->surfaces[0].surface.mesh->triangles.size(),
              object.model->surfaces[0].surface.mesh->triangles.size());
  }
}

// Adds points above the box's top, beyond the tolerance, this far apart along x.
OrientedPoints SquareAndPoints(int count, float step_m) {
  OrientedPoints points;
  points.viewpoint = Vector3(1, 2, 2);
  AddSquare(kLow_m, points);
  for (int k = 0; k < count; ++k) {
    points.points.emplace_back(0.99f + step_m * static_cast<float>(k), 2.f, kLow_m + 0.015f);
    points.normals.push_back(Eigen::Vector3f::UnitZ());
    points.sigma_m.push_back(0.001f);
    points.normal_sigma_rad.push_back(0.05f);
    points.cloud_index.push_back(static_cast<std::uint32_t>(points.cloud_index.size()));
  }
  return points;
}

MeshedObject MeshedBesideTop(int count, float step_m) {
  HypothesisModel model = BoxModel(0, 0);
  model.object.part_of_point.assign(kOfSquare + static_cast<std::size_t>(count), 0);
  const OrientedPoints points = SquareAndPoints(count, step_m);
  return MeshedOf(points, model, points.size());
}

TEST(MeshHypothesis, MakesNoMeshOfRemnantsAndCountsTheirPointsAsUnexplained) {
  for (const auto& [count, step_m] : std::vector<std::pair<int, float>>{
           {1, 0.f}, {3, 0.002f}, {5, 0.03f}}) {  // alone, together, each alone
    const MeshedObject object = MeshedBesideTop(count, step_m);
    EXPECT_THAT(object.model->surfaces, IsEmpty()) << count;
    EXPECT_EQ(object.explained, kOfSquare) << count;
    EXPECT_EQ(object.model->point_count, static_cast<int>(kOfSquare) + count) << "none is lost";
  }
}

TEST(MeshHypothesis, MeshesFewPointsThatAreWiderThanTheToleranceAndManyThatAreNot) {
  for (const auto& [count, step_m] :
       std::vector<std::pair<int, float>>{{6, 0.004f}, {30, 0.0003f}}) {  // 20 mm long; 9 mm, dense
    const MeshedObject object = MeshedBesideTop(count, step_m);
    ASSERT_THAT(object.model->surfaces, SizeIs(1)) << count;
    EXPECT_EQ(object.explained, kOfSquare + static_cast<std::size_t>(count));
  }
}

TEST(MeshHypothesis, MeshesAnObjectWithoutShapesHoweverFewItsPoints) {
  HypothesisModel model;
  model.object.part_of_point.assign(3, kUnexplained);
  OrientedPoints points = SquareAndPoints(3, 0.002f);
  const OrientedPoints few =
      Subset(points, std::vector<std::uint32_t>{kOfSquare, kOfSquare + 1, kOfSquare + 2});
  const MeshedObject object = MeshedOf(few, model, 3);
  EXPECT_THAT(object.model->surfaces, SizeIs(1));
  EXPECT_EQ(object.explained, 3u);
}

TEST(MeshHypothesis, MeshesTheHandlesThatHavePoints) {
  HypothesisModel model = BoxModel(0, 1);  // one shape: 1 is the first handle
  Handle handle{.point_count = kOfSquare, .axis_O = Vector3::UnitX(), .bounds = {}, .surface = {}};
  handle.bounds = {MakeTranslation(1, 2, kHigh_m), Box{{0.08, 0.08, 0.01}}};
  model.object.handles = {handle, handle};
  const MeshedObject object = MeshedOf(model);
  ASSERT_THAT(object.model->handles, SizeIs(2));
  ExpectUpperSquare(object.model->handles[0].surface);
  EXPECT_EQ(object.model->handles[0].point_count, static_cast<int>(kOfSquare));
  EXPECT_TRUE(object.model->handles[0].axis_O.isApprox(Vector3::UnitX()));
  const Vector3 middle = object.model->handles[0].bounds.X_FS.translation();
  EXPECT_LT((middle - Vector3(0, 0, 0.1)).norm(), 1e-5);
  EXPECT_EQ(object.model->handles[1].surface.mesh, nullptr);
  EXPECT_THAT(object.model->surfaces, IsEmpty());  // the handle's mesh explains its points
  EXPECT_EQ(object.explained, 2 * kOfSquare);
}

// 130 000 points of a box's top in few graph nodes: every second point is examined.
TEST(MeshHypothesis, CountsAllPointsOfWhatIsModelledOnASample) {
  constexpr std::size_t kCount = 130'000;
  OrientedPoints square, points;
  AddSquare(kLow_m, square);
  std::vector<std::uint32_t> again(kCount);
  for (std::size_t k = 0; k < kCount; ++k) again[k] = static_cast<std::uint32_t>(k % kOfSquare);
  points = Subset(square, again);
  HypothesisModel model = BoxModel(0, 0);
  model.object.part_of_point.assign(kCount, 0);
  model.object.shapes[0].fit->inlier_count = 60'000;  // inliers of the sample
  const MeshedObject object = MeshedOf(points, model, 10);
  EXPECT_EQ(object.explained, kCount);
  EXPECT_EQ(object.model->point_count, static_cast<int>(kCount));
  EXPECT_EQ(object.model->shapes[0].fit->inlier_count, 120'000);
  EXPECT_THAT(object.model->surfaces, IsEmpty());
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(MeshedOf(points, model, 10, {.stop = stop.get_token()}), Stopped);
}

}  // namespace
}  // namespace cwm::perception
