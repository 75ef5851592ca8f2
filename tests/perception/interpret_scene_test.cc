// The whole pipeline: clouds of the virtual scanner compared with its ground truth, and clouds that
// no scene makes.
#include "perception/interpret_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "perception/simulation/random_scenes.h"
#include "perception/simulation/unorganised.h"
#include "perception/simulation/virtual_scanner.h"
#include "tests/perception/steep_camera.h"

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

PointCloud Unorganised(std::vector<Vector3f> points) {
  PointCloud cloud;
  cloud.width = static_cast<int>(points.size());
  cloud.points = std::move(points);
  return cloud;
}

std::uint64_t Unlabelled(const SceneInterpretation& scene, const PointCloud& cloud) {
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    count += cloud.points[i].allFinite() && scene.labels[i] == 0;
  }
  return count;
}

// A table of 1.2 x 1 m at z = 0, with a can of 66 mm diameter on it.
SimulatedScene TableWithCan() {
  SimulatedObject table{.name = "table",
                        .parts = {{MakeTranslation(0, 0, -0.015), Box{{1.2, 1.0, 0.03}}}},
                        .X_WO = Pose::Identity(),
                        .is_support = true};
  SimulatedObject can{.name = "can",
                      .parts = {{Pose::Identity(), Cylinder{0.033, 0.115}}},
                      .X_WO = MakeTranslation(0.05, 0.1, 0.0575),
                      .is_support = false};
  return {{table, can}};
}

TEST(InterpretScene, FindsTheTableAndTheCanWithItsRadius) {
  const SimulatedCloud truth = Scan(TableWithCan(), SteepCamera(), {});
  InterpretOptions options;
  options.X_WC = SteepCamera().X_WC;
  const auto scene = InterpretScene(truth.cloud, options);
  ASSERT_TRUE(scene.ok()) << scene.status();
  ASSERT_EQ(scene->supports.size(), 1u);
  EXPECT_NEAR(scene->supports[0].X_WO.translation().z(), 0, 0.005);  // warp of 1.3 mm rms
  EXPECT_EQ(scene->supports[0].reachable, false);                    // its top is the floor
  ASSERT_GE(scene->objects.size(), 1u);
  const DetectedObject& can = scene->objects[0];
  EXPECT_EQ(can.kind, DetectedKind::kObject);
  EXPECT_EQ(can.supported_by, 0);
  const auto cylinder = std::find_if(
      can.model->shapes.begin(), can.model->shapes.end(),
      [](const ShapePart& part) { return KindOf(part.shape) == ShapeKind::kCylinder; });
  ASSERT_NE(cylinder, can.model->shapes.end());
  // The accuracy that cylinder fits under Kinect noise are known to reach (95th percentile of the
  // bias of orthogonal residuals, 1.6 mm), doubled for the warp.
  EXPECT_NEAR(std::get<Cylinder>(cylinder->shape).radius_m, 0.033, 0.0032);
}

TEST(InterpretScene, FindsThatABoxOnABoxRestsOnItAndEndsThere) {
  SimulatedScene stack = TableWithCan();
  stack.objects[1] = {.name = "below",
                      .parts = {{.shape = Box{{0.2, 0.25, 0.08}}}},
                      .X_WO = MakeTranslation(0, 0, 0.04)};
  stack.objects.push_back({.name = "above",
                           .parts = {{.shape = Box{{0.08, 0.1, 0.1}}}},
                           .X_WO = MakeTranslation(0.02, 0, 0.13)});
  const SimulatedCloud truth = Scan(stack, SteepCamera(), {});
  InterpretOptions options;
  options.X_WC = SteepCamera().X_WC;
  const auto scene = InterpretScene(truth.cloud, options);
  ASSERT_TRUE(scene.ok()) << scene.status();
  ASSERT_EQ(scene->objects.size(), 2u);
  const int above = scene->objects[0].X_WO.translation().z() > 0.1 ? 0 : 1;
  EXPECT_EQ(scene->objects[above].supported_by, 0);
  EXPECT_EQ(scene->objects[above].rests_on, 1 - above);
  EXPECT_EQ(scene->objects[1 - above].supported_by, 0);
  EXPECT_EQ(scene->objects[1 - above].rests_on, -1);
  const Aabb bounds = TightBounds(*scene->objects[above].model, scene->objects[above].X_WO);
  EXPECT_NEAR(bounds.min().z(), 0.08, 0.003);  // error of a face's height by noise and warp
}

// The visible part of the table is not much larger than the carton's lid.
TEST(InterpretScene, FindsACartonAboutAsLargeAsItsTable) {
  SimulatedScene scene = TableWithCan();
  scene.objects[0].parts = {{MakeTranslation(0, 0, -0.015), Box{{0.6, 0.6, 0.03}}}};
  scene.objects[1] = {
      .name = "carton",
      .parts = {{.shape = Box{{0.38, 0.3, 0.22}}}},
      .X_WO = MakePose({0, 0, 0.11}, Quaternion(Eigen::AngleAxisd(0.2, Vector3::UnitZ())))};
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const SimulatedCloud truth = Scan(scene, SteepCamera(), {.seed = seed});
    InterpretOptions options;
    options.X_WC = SteepCamera().X_WC;
    const auto found = InterpretScene(truth.cloud, options);
    ASSERT_TRUE(found.ok()) << found.status();
    EXPECT_EQ(found->supports.size(), 1u);
    const DetectedObject& carton =
        found->objects[0];  // the largest; the table's edges are residuals
    EXPECT_EQ(std::ranges::count(found->objects, DetectedKind::kObject, &DetectedObject::kind), 1);
    ASSERT_EQ(carton.model->shapes.size(), 1u);
    const auto* box = std::get_if<Box>(&carton.model->shapes[0].shape);
    ASSERT_NE(box, nullptr);
    Vector3 size_m = box->size_m;
    std::sort(size_m.begin(), size_m.end());
    EXPECT_LT((size_m - Vector3(0.22, 0.3, 0.38)).cwiseAbs().maxCoeff(), 0.01);
  }
}

// Some drivers write zeros for pixels without a return.
TEST(InterpretScene, TakesZerosForNoReturnsAndSaysSo) {
  const PointCloud cloud = Scan(TableWithCan(), SteepCamera(), {}).cloud;
  PointCloud zeros = cloud;
  std::size_t count = 0;
  for (Vector3f& p : zeros.points) {
    if (p.allFinite()) continue;
    p.setZero();
    ++count;
  }
  ASSERT_GT(count, 100u);
  const auto expected = InterpretScene(cloud, {});
  const auto found = InterpretScene(zeros, {});
  ASSERT_TRUE(expected.ok() && found.ok()) << found.status();
  EXPECT_EQ(found->labels, expected->labels);
  EXPECT_EQ(found->report.points_finite, expected->report.points_finite);
  EXPECT_THAT(found->report.warnings,
              ::testing::Contains(::testing::HasSubstr("taken for no returns")));
}

// A can of a mug's size hangs 0.3 m above the table, as on a shelf that is no support of its own,
// in front of a wall.
TEST(InterpretScene, ExtendsNothingThroughSpaceThatRaysCrossed) {
  SimulatedScene hung = TableWithCan();
  hung.objects[1].parts = {{.shape = Cylinder{0.045, 0.1}}};
  hung.objects[1].X_WO = MakeTranslation(0.1, 0, 0.35);
  hung.objects.push_back({.name = "wall",
                          .parts = {{.shape = Box{{0.02, 1.0, 1.0}}}},
                          .X_WO = MakeTranslation(0.6, 0, 0.5)});
  const SimulatedCloud truth = Scan(hung, SteepCamera(), {});
  InterpretOptions options;
  options.X_WC = SteepCamera().X_WC;
  const auto scene = InterpretScene(truth.cloud, options);
  ASSERT_TRUE(scene.ok()) << scene.status();
  int found = 0;
  for (const DetectedObject& object : scene->objects) {
    const Aabb bounds = TightBounds(*object.model, object.X_WO);
    if (bounds.sizes().head<2>().maxCoeff() > 0.5 || bounds.max().z() < 0.3) continue;
    ++found;
    EXPECT_GT(bounds.min().z(), 0.25);
  }
  EXPECT_GE(found, 1);
}

TEST(InterpretScene, MarksTheBodyOfASupportAsCompletedAndItsTopAsMeasured) {
  const SimulatedCloud truth = Scan(TableWithCan(), SteepCamera(), {});
  const auto scene = InterpretScene(truth.cloud, {});
  ASSERT_TRUE(scene.ok()) << scene.status();
  ASSERT_EQ(scene->supports.size(), 1u);
  ASSERT_EQ(scene->supports[0].model->shapes.size(), 1u);
  const ShapePart& part = scene->supports[0].model->shapes[0];
  EXPECT_EQ(part.role, PartRole::kCompleted);
  ASSERT_TRUE(part.fit.has_value());
  EXPECT_EQ(part.fit->inlier_count, scene->supports[0].point_count);
  EXPECT_LT(part.fit->rms_m, 0.005);  // noise of 1.5 mm and warp of 1.3 mm
}

TEST(InterpretScene, LabelsEveryFinitePointAndCountsTheRest) {
  const SimulatedCloud truth = Scan(KitchenCounter(), KitchenCamera(), {});
  const auto scene = InterpretScene(truth.cloud, {});
  ASSERT_TRUE(scene.ok()) << scene.status();
  const InterpretReport& report = scene->report;
  EXPECT_EQ(report.points_in, truth.cloud.size());
  EXPECT_EQ(Unlabelled(*scene, truth.cloud), report.points_rejected);
  EXPECT_LE(report.points_rejected, report.points_finite / 200);
  EXPECT_LE(report.points_explained, report.points_finite);
  EXPECT_GT(report.points_explained, report.points_finite * 95 / 100);
}

void ExpectSame(const HybridModel& a, const HybridModel& b) {
  EXPECT_EQ(a.point_count, b.point_count);
  ASSERT_EQ(a.shapes.size(), b.shapes.size());
  for (std::size_t s = 0; s < a.shapes.size(); ++s) {
    EXPECT_EQ(a.shapes[s].shape, b.shapes[s].shape);
    EXPECT_EQ(a.shapes[s].X_OS.matrix(), b.shapes[s].X_OS.matrix());
    EXPECT_EQ(a.shapes[s].role, b.shapes[s].role);
    EXPECT_EQ(a.shapes[s].fit, b.shapes[s].fit);
  }
  ASSERT_EQ(a.surfaces.size(), b.surfaces.size());
  for (std::size_t s = 0; s < a.surfaces.size(); ++s) {
    EXPECT_EQ(a.surfaces[s].surface, b.surfaces[s].surface);
    EXPECT_EQ(a.surfaces[s].point_count, b.surfaces[s].point_count);
  }
  ASSERT_EQ(a.handles.size(), b.handles.size());
  for (std::size_t h = 0; h < a.handles.size(); ++h) {
    EXPECT_EQ(a.handles[h].bounds.shape, b.handles[h].bounds.shape);
    EXPECT_EQ(a.handles[h].bounds.X_FS.matrix(), b.handles[h].bounds.X_FS.matrix());
    EXPECT_EQ(a.handles[h].surface, b.handles[h].surface);
  }
}

void ExpectSame(const SceneInterpretation& a, const SceneInterpretation& b) {
  EXPECT_EQ(a.X_WC.matrix(), b.X_WC.matrix());
  EXPECT_EQ(a.labels, b.labels);
  EXPECT_EQ(a.report.points_explained, b.report.points_explained);
  EXPECT_EQ(a.report.points_rejected, b.report.points_rejected);
  EXPECT_EQ(a.report.warnings, b.report.warnings);
  ASSERT_EQ(a.supports.size(), b.supports.size());
  for (std::size_t k = 0; k < a.supports.size(); ++k) {
    EXPECT_EQ(a.supports[k].X_WO.matrix(), b.supports[k].X_WO.matrix());
    ExpectSame(*a.supports[k].model, *b.supports[k].model);
  }
  ASSERT_EQ(a.objects.size(), b.objects.size());
  for (std::size_t k = 0; k < a.objects.size(); ++k) {
    EXPECT_EQ(a.objects[k].X_WO.matrix(), b.objects[k].X_WO.matrix());
    EXPECT_EQ(a.objects[k].supported_by, b.objects[k].supported_by);
    EXPECT_EQ(a.objects[k].points_L, b.objects[k].points_L);
    ExpectSame(*a.objects[k].model, *b.objects[k].model);
  }
}

TEST(InterpretScene, GivesTheSameBytesOnAnyNumberOfThreads) {
  const SimulatedCloud counter = Scan(KitchenCounter(), KitchenCamera(), {});
  const SimulatedView vessels = RandomScene(SceneFamily::kVessels, 3);
  const SimulatedCloud mugs = Scan(vessels.scene, vessels.camera, {.seed = 3});
  for (const PointCloud& cloud :
       {counter.cloud, mugs.cloud, Shuffled(counter, 1).cloud, Shuffled(mugs, 1).cloud}) {
    InterpretOptions options;
    options.max_threads = 1;
    const auto alone = InterpretScene(cloud, options);
    ASSERT_TRUE(alone.ok()) << alone.status();
    ASSERT_GE(alone->objects.size(), 3u);
    for (const int threads : {2, 5}) {
      options.max_threads = threads;
      const auto together = InterpretScene(cloud, options);
      ASSERT_TRUE(together.ok()) << together.status();
      ExpectSame(*alone, *together);
    }
  }
}

TEST(InterpretScene, DegenerateCloudsBecomeResidualsAndSaySo) {
  std::vector<Vector3f> line;
  for (int i = 0; i < 500; ++i) line.push_back({0.002f * static_cast<float>(i), 0, 1});
  for (const auto& points : {std::vector<Vector3f>{{0.1f, 0.2f, 1}},
                             std::vector<Vector3f>(1000, Vector3f(0, 0.1f, 1)), line}) {
    const PointCloud cloud = Unorganised(points);
    const auto scene = InterpretScene(cloud, {});
    ASSERT_TRUE(scene.ok()) << scene.status();
    EXPECT_TRUE(scene->supports.empty());
    EXPECT_FALSE(scene->report.warnings.empty());
    EXPECT_EQ(Unlabelled(*scene, cloud), scene->report.points_rejected);
    ASSERT_FALSE(scene->objects.empty());
    for (const DetectedObject& object : scene->objects) {
      EXPECT_EQ(object.kind, DetectedKind::kResidual);
    }
  }
}

TEST(InterpretScene, AnImageOfOneRepeatedPointIsOneResidual) {
  PointCloud cloud{
      .points = std::vector<Vector3f>(std::size_t{640} * 480, Vector3f(0.1f, -0.2f, 0.9f)),
      .normals = {},
      .width = 640,
      .height = 480};
  const auto scene = InterpretScene(cloud, {});
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_TRUE(scene->supports.empty());
  EXPECT_LE(scene->objects.size(), 1u);
  EXPECT_TRUE(scene->pose_is_guess);
  EXPECT_EQ(Unlabelled(*scene, cloud), scene->report.points_rejected);
}

TEST(InterpretScene, SaysThatUpIsUpsideDownAndTurnsAVectorButNoPose) {
  const PointCloud cloud = Scan(TableWithCan(), SteepCamera(), {}).cloud;
  InterpretOptions options;
  options.up_C = -SteepCamera().X_WC.linear().row(2).transpose();
  const auto turned = InterpretScene(cloud, options);
  ASSERT_TRUE(turned.ok()) << turned.status();
  EXPECT_THAT(turned->report.warnings,
              ::testing::Contains(::testing::MatchesRegex(
                  "up \\(.*\\) of the sensor's frame seems to be upside down.*other way round")));
  EXPECT_EQ(turned->supports.size(), 1u);
  options.up_C.reset();
  options.X_WC = Pose(Matrix3(Vector3(1, -1, -1).asDiagonal())) * SteepCamera().X_WC;
  const auto kept = InterpretScene(cloud, options);
  ASSERT_TRUE(kept.ok()) << kept.status();
  EXPECT_THAT(kept->report.warnings,
              ::testing::Contains(::testing::MatchesRegex(
                  "x_world_sensor with up along .* seems to be upside down.*taken as it is")));
  EXPECT_EQ(kept->X_WC.matrix(), options.X_WC->matrix());
}

bool DoubtsTheUnit(const SceneInterpretation& scene) {
  return std::ranges::any_of(scene.report.warnings, [](const std::string& warning) {
    return warning.find("millimetres") != std::string::npos;
  });
}

TEST(InterpretScene, DoubtsTheUnitOfATableInMillimetresAndNotOfASingleWildPoint) {
  PointCloud cloud = Scan(TableWithCan(), SteepCamera(), {}).cloud;
  auto lit = std::ranges::find_if(cloud.points, [](const Vector3f& p) { return p.allFinite(); });
  ASSERT_NE(lit, cloud.points.end());
  *lit *= 1000;
  auto scene = InterpretScene(cloud, {});
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_FALSE(DoubtsTheUnit(*scene));
  *lit /= 1000;
  for (Vector3f& p : cloud.points) p *= 1000;
  scene = InterpretScene(cloud, {});
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_TRUE(DoubtsTheUnit(*scene));
}

TEST(InterpretScene, RefusesWhatCannotBeInterpreted) {
  const float nan = std::nanf("");
  for (const auto& points : {std::vector<Vector3f>{}, std::vector<Vector3f>(9, {nan, nan, nan}),
                             std::vector<Vector3f>{{0, 0, 1}, {1e30f, 0, 1}}}) {
    EXPECT_EQ(InterpretScene(Unorganised(points), {}).status().code(),
              absl::StatusCode::kInvalidArgument);
  }
  InterpretOptions options;
  options.up_C = Vector3::Zero();
  EXPECT_EQ(InterpretScene(Unorganised({{0, 0, 1}}), options).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(InterpretScene, StopsWhenAsked) {
  std::stop_source source;
  source.request_stop();
  EXPECT_EQ(InterpretScene(Unorganised({{0, 0, 1}}), {}, source.get_token()).status().code(),
            absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace cwm::perception
