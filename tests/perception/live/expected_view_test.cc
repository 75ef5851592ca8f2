#include "perception/live/expected_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "perception/simulation/look_at.h"
#include "tests/perception/live/known_scene.h"
#include "tests/perception/live/still_sensor.h"

namespace cwm::perception {
namespace {

// The renderers round differently: floats of inverse depths have 6e-8 of the depth.
constexpr double kDepthTolerance_m = 1e-5;

KnownBody BodyOf(BodyId id, const Shape& shape, const Pose& X_WB) {
  auto model = std::make_shared<HybridModel>();
  model->shapes.push_back({.shape = shape});
  return {.id = id, .X_WB = X_WB, .model = std::move(model)};
}

bool IsBesideOutline(const RangeImage& image, int u, int v) {
  const Sighting& own = image.at(u, v);
  for (int dv = -1; dv <= 1; ++dv) {
    for (int du = -1; du <= 1; ++du) {
      if (!image.contains(u + du, v + dv)) continue;
      const Sighting& beside = image.at(u + du, v + dv);
      if (beside.object != own.object || beside.part != own.part) return true;
    }
  }
  return false;
}

// Compares with the ray caster of the virtual scanner, except at outlines, where rounding decides.
void ExpectAgreement(const SimulatedScene& scene, const PinholeCamera& camera) {
  ExpectedView view(CameraOf(camera));
  view.Update(KnownBodies(scene), camera.X_WC);
  const RangeImage truth = Render(scene, camera);
  int compared = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      if (IsBesideOutline(truth, u, v)) continue;
      const Sighting& pixel = truth.at(u, v);
      const std::size_t i = static_cast<std::size_t>(v) * camera.width + u;
      if (!pixel.seen()) {  // or too far for the scanner
        EXPECT_GT(view.depth_m()[i], kMaxCameraDepth_m);
        continue;
      }
      ASSERT_EQ(view.body()[i], pixel.object) << "pixel " << u << " " << v;
      ASSERT_NEAR(view.depth_m()[i], pixel.depth_m, kDepthTolerance_m) << "pixel " << u << " " << v;
      ++compared;
    }
  }
  EXPECT_GT(compared, camera.width * camera.height / 20);
}

TEST(ExpectedView, AgreesWithTheRayCasterOnRandomScenes) {
  for (const NamedFamily& family : kSceneFamilies) {
    for (const std::uint64_t seed : {21, 22}) {
      SCOPED_TRACE(std::string(family.name) + " " + std::to_string(seed));
      const SimulatedView view = RandomScene(family.family, seed);
      ExpectAgreement(view.scene, Halved(view.camera));
    }
  }
}

// One of each shape, all turned.
SimulatedScene OneOfEachShape() {
  const std::vector<Shape> shapes = {
      Sphere{0.08},
      Box{{0.1, 0.14, 0.06}},
      Cylinder{0.05, 0.2},
      Cone{0.07, 0.03, 0.15},
      Cone{0.06, 0, 0.15},
      Capsule{0.04, 0.15},
      Plate{.outline = {{-0.2, -0.1}, {0.2, -0.1}, {0.2, 0.1}, {0, 0.02}, {-0.2, 0.1}},
            .holes = {{{-0.1, -0.06}, {-0.02, -0.06}, {-0.02, 0}, {-0.1, 0}}},
            .thickness_m = 0.03},
      Convex{std::make_shared<TriangleMesh>(
          ConvexHull3({{0, 0, 0}, {0.15, 0, 0}, {0, 0.15, 0}, {0, 0, 0.15}, {0.1, 0.1, 0.1}}))}};
  SimulatedScene scene;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> draw(-1, 1);
  for (const Shape& shape : shapes) {
    for (int i = 0; i < 3; ++i) {
      const Quaternion turn =
          Quaternion(draw(random), draw(random), draw(random), draw(random)).normalized();
      const Vector3 place(0.5 * draw(random), 0.4 * draw(random), 1.4 + 0.6 * draw(random));
      scene.objects.push_back(
          {.name = "", .parts = {{.shape = shape}}, .X_WO = MakePose(place, turn)});
    }
  }
  return scene;
}

TEST(ExpectedView, AgreesWithTheRayCasterOnEveryShapeFromAllSides) {
  const SimulatedScene scene = OneOfEachShape();
  for (const double azimuth_rad : {0.0, 1.3, 2.9, 4.4}) {
    PinholeCamera camera = Halved({});
    camera.X_WC =
        LookAt(Vector3(0, 0, 1.4),
               ViewingDirection{.distance_m = 1.6, .down_rad = 0.3, .azimuth_rad = azimuth_rad});
    ExpectAgreement(scene, camera);
  }
}

TEST(ExpectedView, CutsWhatReachesBehindTheCamera) {
  // A floor and walls around a camera, a beam beside it, an object behind it.
  SimulatedScene scene;
  const auto add = [&](const Shape& shape, const Vector3& place) {
    scene.objects.push_back(
        {.name = "", .parts = {{.shape = shape}}, .X_WO = MakePose(place, Quaternion::Identity())});
  };
  add(Plate{.outline = {{-4, -4}, {4, -4}, {4, 4}, {-4, 4}}, .holes = {}, .thickness_m = 0.02},
      {0, 0, 0});
  add(Box{{8, 0.1, 2}}, {0, 3, 1});
  add(Box{{0.06, 6, 0.06}}, {0.3, 0, 0.4});
  add(Cylinder{0.1, 3}, {-0.4, 0, 0.5});
  add(Sphere{0.2}, {0, -2, 0.5});
  add(HalfSpace{}, {0, 0, -0.5});
  PinholeCamera camera = Halved({});
  for (const Vector3& target : {Vector3(0, 1, 0.2), Vector3(1, 1, 0), Vector3(-1, 0.3, 0.6)}) {
    camera.X_WC = LookAt({0, 0, 0.5}, target);
    ExpectAgreement(scene, camera);
  }
}

TEST(ExpectedView, ShowsWhatIsAroundACameraInsideOfASolid) {
  const PinholeCamera camera = Halved({});
  const std::vector<KnownBody> bodies = {
      BodyOf(0, Box{{0.5, 0.5, 0.5}}, Pose::Identity()), BodyOf(1, Sphere{0.5}, Pose::Identity()),
      BodyOf(2, HalfSpace{}, MakePose({0, 0, 0.5}, Quaternion::Identity())),
      BodyOf(3, Box{{9, 9, 0.1}}, MakePose({0, 0, 1.05}, Quaternion::Identity()))};
  ExpectedView view(CameraOf(camera));
  view.Update(bodies, Pose::Identity());
  for (const BodyId id : view.body()) EXPECT_EQ(id, 3);
  for (const float depth_m : view.depth_m()) EXPECT_NEAR(depth_m, 1, 1e-6);
}

TEST(ExpectedView, IsTheSameWhetherRenderedInPartsOrAsAWhole) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> draw(-1, 1);
  const auto index = [&](std::size_t size) { return random() % size; };
  for (const SceneFamily family :
       {SceneFamily::kClutter, SceneFamily::kVessels, SceneFamily::kKitchen}) {
    const SimulatedView simulated = RandomScene(family, 5);
    const PinholeCamera camera = Halved(Halved(simulated.camera));
    std::vector<KnownBody> bodies = KnownBodies(simulated.scene);
    std::vector<KnownBody> absent;
    ExpectedView view(CameraOf(camera));
    for (int step = 0; step < 60; ++step) {
      const auto action = random() % 4;
      if (action == 0 && bodies.size() > 1) {  // take some away
        absent.push_back(bodies[index(bodies.size())]);
        std::erase_if(bodies, [&](const KnownBody& body) { return body.id == absent.back().id; });
      } else if (action == 1 && !absent.empty()) {
        bodies.insert(bodies.begin() + static_cast<std::ptrdiff_t>(index(bodies.size())),
                      absent.back());
        absent.pop_back();
      } else {
        for (int moved = 0; moved < 2; ++moved) {
          Pose& X_WB = bodies[index(bodies.size())].X_WB;
          X_WB.translation() += 0.1 * Vector3(draw(random), draw(random), draw(random));
          X_WB.rotate(Eigen::AngleAxisd(draw(random), Vector3::UnitX()));
        }
      }
      view.Update(bodies, camera.X_WC);
      ExpectedView whole(CameraOf(camera));
      whole.Update(bodies, camera.X_WC);
      ASSERT_EQ(view.body(), whole.body()) << "step " << step;
      ASSERT_EQ(view.depth_m(), whole.depth_m()) << "step " << step;
    }
  }
}

TEST(ExpectedView, RendersOnlyTheTwoPlacesOfWhatMoved) {
  const SimulatedView simulated = RandomScene(SceneFamily::kClutter, 3);
  std::vector<KnownBody> bodies = KnownBodies(simulated.scene);
  ExpectedView view(CameraOf(simulated.camera));
  view.Update(bodies, simulated.camera.X_WC);
  ASSERT_EQ(view.changed().size(), 1U);
  EXPECT_EQ(view.changed().front().area(), 640 * 480);
  view.Update(bodies, simulated.camera.X_WC);
  EXPECT_TRUE(view.changed().empty());

  const std::int64_t before = view.BoundsOf(bodies.back().id).area();
  bodies.back().X_WB.translation().z() += 0.5;  // not over its old place
  view.Update(bodies, simulated.camera.X_WC);
  const std::int64_t after = view.BoundsOf(bodies.back().id).area();
  std::int64_t rendered = 0;
  for (const PixelRectangle& rectangle : view.changed()) rendered += rectangle.area();
  EXPECT_GT(before, 0);
  EXPECT_LE(rendered, before + after);
}

TEST(ExpectedView, LeavesMoversOutAndPrefersTheLeastIdOfEquals) {
  const PinholeCamera camera = Halved({});
  const Pose ahead = MakePose({0, 0, 1}, Quaternion::Identity());
  std::vector<KnownBody> bodies = {BodyOf(9, Box{{9, 9, 0.2}}, ahead),
                                   BodyOf(4, Box{{9, 9, 0.2}}, ahead),
                                   BodyOf(1, Box{{9, 9, 0.4}}, ahead)};
  bodies.back().kind = KnownBody::Kind::kMover;
  ExpectedView view(CameraOf(camera));
  view.Update(bodies, Pose::Identity());
  for (const BodyId id : view.body()) EXPECT_EQ(id, 4);
}

TEST(ExpectedView, RendersImagesOfAnySize) {
  for (const auto& [width, height] : {std::pair(1, 1), {7, 5}, {641, 3}}) {
    PinholeCamera camera;
    camera.width = width;
    camera.height = height;
    camera.center_x_px = 0.5 * (width - 1);
    camera.center_y_px = 0.5 * (height - 1);
    ExpectedView view(CameraOf(camera));
    view.Update(
        std::vector<KnownBody>{BodyOf(2, Sphere{0.3}, MakePose({0, 0, 1}, Quaternion::Identity()))},
        Pose::Identity());
    const std::size_t center = static_cast<std::size_t>(height / 2) * width + width / 2;
    EXPECT_EQ(view.body()[center], 2);
    EXPECT_NEAR(view.depth_m()[center], 0.7, 1e-4);
  }
}

}  // namespace
}  // namespace cwm::perception
