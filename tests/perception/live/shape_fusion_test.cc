// A can on a table before three ideal cameras: which points are its own, and which bodies are parts
// of it.
#include "perception/live/shape_fusion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>

#include "perception/simulation/furniture.h"
#include "perception/simulation/look_at.h"
#include "perception/simulation/range_image.h"
#include "tests/perception/live/known_scene.h"

namespace cwm::perception {
namespace {

constexpr double kTop_m = 0.75;
constexpr double kRadius_m = 0.045, kHeight_m = 0.11;
const Vector3 kFoot(0.6, 0, kTop_m);

SimulatedObject Standing(const char* name, Shape shape, double height_m, const Vector3& foot) {
  return {.name = name,
          .parts = {{.X_FS = MakeTranslation(0, 0, 0.5 * height_m), .shape = std::move(shape)}},
          .X_WO = MakeTranslation(foot.x(), foot.y(), foot.z())};
}

SimulatedScene TableWithCan() {
  SimulatedScene scene;
  scene.objects = {
      MakeTop("table", {.area_W = {Vector2(0, -1), Vector2(1.4, 1)}, .top_m = kTop_m}),
      Standing("can", Cylinder{.radius_m = kRadius_m, .length_m = kHeight_m}, kHeight_m, kFoot)};
  return scene;
}

// Exact depths, too large by these offsets along the rays.
std::vector<MeanView> ViewsOf(const SimulatedScene& scene,
                              const std::vector<double>& offsets_m = {0, 0, 0}) {
  std::vector<MeanView> views;
  for (const Vector3& eye :
       {Vector3(0.15, 0, 1.45), Vector3(0.7, -0.6, 1.4), Vector3(0.7, 0.6, 1.4)}) {
    PinholeCamera camera;
    camera.X_WC = LookAt(eye, kFoot);
    const RangeImage image = Render(scene, camera);
    MeanView& view = views.emplace_back();
    view = {.sensor = std::to_string(views.size()),
            .X_WC = camera.X_WC,
            .camera = CameraOf(camera),
            .depth_m = std::vector<float>(image.pixels.size(), 0)};
    const double offset_m = offsets_m[views.size() - 1];
    for (int v = 0; v < image.height; ++v) {
      for (int u = 0; u < image.width; ++u) {
        if (!image.at(u, v).seen()) continue;
        const double per_range = 1 / RayDirection(camera, u, v).norm();
        view.depth_m[static_cast<std::size_t>(v) * image.width + u] =
            static_cast<float>(image.at(u, v).depth_m + offset_m * per_range);
      }
    }
  }
  return views;
}

// The published bodies: those of the scene, and further ones.
std::vector<KnownBody> Published(const SimulatedScene& scene,
                                 const std::vector<SimulatedObject>& further) {
  SimulatedScene all = scene;
  all.objects.insert(all.objects.end(), further.begin(), further.end());
  return KnownBodies(all);
}

std::vector<BodyId> PartsOfTheCan(const SimulatedScene& scene,
                                  const std::vector<SimulatedObject>& further) {
  const std::vector<KnownBody> bodies = Published(scene, further);
  return PartsOf(ViewsOf(scene), bodies[1], bodies);
}

TEST(PartsOfTest, ABodyInsideWhosePointsLieOnTheSurfaceIsAPart) {
  // The front of the can below its lid, as a slab that a single view takes for a thing.
  const SimulatedObject slab = Standing("slab", Box{.size_m = {0.02, 0.03, 0.09}}, 0.09,
                                        kFoot - Vector3(kRadius_m - 0.0125, 0, 0));
  EXPECT_THAT(PartsOfTheCan(TableWithCan(), {slab}), testing::ElementsAre(2));
}

TEST(PartsOfTest, ABodyBesideOrOnTopIsNone) {
  const Shape carton = Box{.size_m = {0.05, 0.04, 0.08}};
  SimulatedScene scene = TableWithCan();
  scene.objects.push_back(
      Standing("beside", carton, 0.08, kFoot + Vector3(0, kRadius_m + 0.02, 0)));
  scene.objects.push_back(Standing("on top", carton, 0.08, kFoot + Vector3(0, 0, kHeight_m)));
  EXPECT_THAT(PartsOfTheCan(scene, {}), testing::IsEmpty());
}

// Its points are within the noise of the lid, but it takes up no space of the can.
TEST(PartsOfTest, AFlatBodyOnTopIsNone) {
  const SimulatedObject coaster = Standing("coaster", Cylinder{.radius_m = 0.03, .length_m = 0.004},
                                           0.004, kFoot + Vector3(0, 0, kHeight_m));
  SimulatedScene scene = TableWithCan();
  scene.objects.push_back(coaster);
  EXPECT_THAT(PartsOfTheCan(scene, {}), testing::IsEmpty());
}

// The published can is wrong if a thing inside it is seen.
TEST(PartsOfTest, ABodyInsideThatIsSeenAwayFromTheSurfaceIsNone) {
  SimulatedScene seen = TableWithCan();
  seen.objects[1] = Standing("thin", Cylinder{.radius_m = 0.015, .length_m = 0.08}, 0.08, kFoot);
  std::vector<KnownBody> bodies = KnownBodies(TableWithCan());
  bodies.push_back(KnownBodies(seen)[1]);
  bodies.back().id = 2;
  EXPECT_THAT(PartsOf(ViewsOf(seen), bodies[1], bodies), testing::IsEmpty());
}

TEST(PartsOfTest, ABodyOfAUserOrOneThatNoViewShowsIsNone) {
  const SimulatedObject slab = Standing("slab", Box{.size_m = {0.02, 0.03, 0.09}}, 0.09,
                                        kFoot - Vector3(kRadius_m - 0.0125, 0, 0));
  const SimulatedObject hidden =
      Standing("hidden", Box{.size_m = {0.02, 0.02, 0.02}}, 0.02, kFoot + Vector3(0, 0, 0.04));
  std::vector<KnownBody> bodies = Published(TableWithCan(), {slab, hidden});
  bodies[2].kind = KnownBody::Kind::kUser;
  EXPECT_THAT(PartsOf(ViewsOf(TableWithCan()), bodies[1], bodies), testing::IsEmpty());
}

TEST(CloudOfBodyTest, TheOffsetOfEachViewIsTakenOffItsPoints) {
  const SimulatedScene scene = TableWithCan();
  const std::vector<double> offsets_m = {0.0015, -0.0012, 0.0009};
  const std::vector<KnownBody> bodies = KnownBodies(scene);
  const FusionCloud fused = CloudOfBody(ViewsOf(scene, offsets_m), bodies[1], bodies);
  ASSERT_EQ(fused.own_C.size(), 3U);
  for (const BodyView& view : fused.own_C) {
    ASSERT_GT(view.points.size(), 1000U);
    double beyond_m = 0;
    int count = 0;
    for (const Eigen::Vector3f& p_C : view.points) {
      const Vector3 p_W = fused.X_WC * p_C.cast<double>();
      if (p_W.z() > kTop_m + kHeight_m - 0.01) continue;  // the lid, and the rim
      beyond_m += (p_W - kFoot).head<2>().norm() - kRadius_m;
      ++count;
    }
    EXPECT_NEAR(beyond_m / count, 0, 0.1 * offsets_m[0]);
  }
}

// A square of two triangles, level.
SurfacePart LevelSquare(const Vector3& center, double edge_m) {
  TriangleMesh mesh;
  for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) {
    mesh.vertices.push_back(center + 0.5 * edge_m * Vector3(x, y, 0));
  }
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return {.surface = MakeMesh(std::move(mesh)), .point_count = 50};
}

TEST(FusedObjectTest, SurfacesOnTheSupportAreLeftOutAndOthersStay) {
  const SimulatedScene table = TableWithCan();
  const std::vector<KnownBody> bodies = KnownBodies(table);
  const FusionCloud fused = CloudOfBody(ViewsOf(table), bodies[1], bodies);
  auto model = std::make_shared<HybridModel>(*bodies[1].model);
  model->surfaces = {LevelSquare(Vector3(kRadius_m + 0.015, 0, 0.002), 0.01),
                     LevelSquare(Vector3(kRadius_m + 0.015, 0, 0.05), 0.01)};
  SceneInterpretation scene;
  scene.X_WC = fused.X_WC;
  DetectedObject& found = scene.objects.emplace_back();
  found.X_WO = bodies[1].X_WB;
  found.model = model;
  for (const BodyView& view : fused.own_C) {
    found.points_L.insert(found.points_L.end(), view.points.begin(), view.points.end());
  }
  const auto object = FusedObject(fused, scene, bodies[1], bodies, {});
  ASSERT_TRUE(object.has_value());
  EXPECT_EQ(object->model->shapes.size(), 1U);
  ASSERT_EQ(object->model->surfaces.size(), 1U);
  EXPECT_GT(object->model->surfaces[0].surface.mesh->vertices[0].z(), 0.04);
  // A model that explains less of the points does not take its place.
  auto smaller = std::make_shared<HybridModel>(*bodies[1].model);
  smaller->shapes[0].shape = Cylinder{.radius_m = 0.5 * kRadius_m, .length_m = kHeight_m};
  found.model = smaller;
  EXPECT_FALSE(FusedObject(fused, scene, bodies[1], bodies, {}).has_value());
}

}  // namespace
}  // namespace cwm::perception
