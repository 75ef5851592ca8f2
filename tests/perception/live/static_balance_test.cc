// Things that stand, and things that something else must hold.
#include "perception/live/static_balance.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "perception/live/expected_view.h"
#include "perception/live/pixel_rays.h"
#include "perception/simulation/look_at.h"

namespace cwm::perception {
namespace {

constexpr double kTable_m = 0.75;

HybridModel ModelOf(std::vector<ShapePart> parts) {
  HybridModel model;
  model.shapes = std::move(parts);
  return model;
}

// True if the thing may rest above a table, seen by a camera from the front and above. `others` are
// seen as well.
bool MayRestOnTable(std::vector<ShapePart> thing, std::vector<ShapePart> others = {}) {
  const DepthCamera camera{
      .pinhole = {.focal_u_px = 525, .focal_v_px = 525, .center_u_px = 319.5, .center_v_px = 239.5},
      .width = 640,
      .height = 480};
  const Pose X_WC = LookAt(Vector3(-0.75, 0, 1.45), Vector3(0, 0, kTable_m));
  const Pose X_WS = MakeTranslation(0, 0, kTable_m);
  others.push_back({.X_OS = MakeTranslation(0, 0, kTable_m - 0.01), .shape = Box{{1, 1.2, 0.02}}});
  others.push_back({.X_OS = MakeTranslation(0, 0, -0.05), .shape = Box{{8, 8, 0.1}}});
  const auto model = [](std::vector<ShapePart> parts) {
    return std::make_shared<const HybridModel>(ModelOf(std::move(parts)));
  };
  const std::vector<KnownBody> bodies = {{.id = 0, .model = model(std::move(others))},
                                         {.id = 1, .model = model(std::move(thing))}};
  ExpectedView view(camera);
  view.Update(bodies, X_WC);
  auto image = std::make_shared<DepthImage>();
  image->width = camera.width;
  image->height = camera.height;
  const PixelRays rays(camera, X_WC);
  std::vector<Eigen::Vector3f> points_L;
  for (std::size_t i = 0; i < camera.pixel_count(); ++i) {
    const float depth_m = view.depth_m()[i];
    image->depth_m.push_back(depth_m < camera.greatest_range_m ? depth_m : 0);
    if (view.body()[i] != 1) continue;
    const auto pixel = static_cast<int>(i);
    points_L.push_back(rays.Point(pixel % camera.width, pixel / camera.width, depth_m));
  }
  EXPECT_GT(points_L.size(), 300U);
  FrameEvidence frame;
  frame.X_WC = X_WC;
  frame.camera = camera;
  frame.image = std::move(image);
  return MayRest(points_L, X_WS, frame);
}

ShapePart BoxAt(const Vector3& size, double x_m, double y_m, double foot_m) {
  return {.X_OS = MakeTranslation(x_m, y_m, kTable_m + foot_m + size.z() / 2), .shape = Box{size}};
}

TEST(StaticBalance, ThingsOnASupportMayRest) {
  for (const double x_m : {-0.25, 0.0, 0.3}) {
    for (const double y_m : {-0.25, 0.0, 0.3}) {
      const auto at = [&](double z_m) { return MakeTranslation(x_m, y_m, kTable_m + z_m); };
      EXPECT_TRUE(MayRestOnTable({BoxAt({0.06, 0.15, 0.22}, x_m, y_m, 0)}));
      EXPECT_TRUE(MayRestOnTable({BoxAt({0.1, 0.1, 0.02}, x_m, y_m, 0)}));
      EXPECT_TRUE(MayRestOnTable({{.X_OS = at(0.045), .shape = Sphere{0.045}}}));
      EXPECT_TRUE(MayRestOnTable({{.X_OS = at(0.06), .shape = Cylinder{0.033, 0.12}}}));
      // A plate on a foot.
      EXPECT_TRUE(MayRestOnTable(
          {BoxAt({0.06, 0.06, 0.1}, x_m, y_m, 0), BoxAt({0.2, 0.2, 0.01}, x_m, y_m, 0.1)}));
    }
  }
}

TEST(StaticBalance, AThingThatOverhangsMayRestWhileItsMiddleIsBorne) {
  EXPECT_TRUE(MayRestOnTable({BoxAt({0.1, 0.3, 0.03}, 0, 0.05, 0.15)},
                             {BoxAt({0.1, 0.1, 0.15}, 0, -0.02, 0)}));
  EXPECT_FALSE(
      MayRestOnTable({BoxAt({0.1, 0.3, 0.03}, 0, 0.2, 0.15)}, {BoxAt({0.1, 0.1, 0.15}, 0, 0, 0)}));
}

TEST(StaticBalance, AThingInTheAirIsHeld) {
  for (const double y_m : {-0.4, 0.0, 0.3}) {
    EXPECT_FALSE(MayRestOnTable({BoxAt({0.1, 0.08, 0.05}, 0, y_m, 0.2)}));
    EXPECT_FALSE(MayRestOnTable({BoxAt({0.06, 0.06, 0.12}, -0.2, y_m, 0.12)}));
  }
}

TEST(StaticBalance, AnArmThatTouchesTheTableIsHeld) {
  // From the fingers on the table obliquely up to the elbow, across the view.
  const Vector3 tips(-0.1, -0.1, kTable_m + 0.03), elbow(0.05, 0.3, kTable_m + 0.25);
  const Pose X_WA =
      MakePose((tips + elbow) / 2, Quaternion::FromTwoVectors(Vector3::UnitZ(), elbow - tips));
  EXPECT_FALSE(MayRestOnTable({{.X_OS = X_WA, .shape = Capsule{0.03, (elbow - tips).norm()}}}));
}

}  // namespace
}  // namespace cwm::perception
