#include "perception/refinement/complete/complete_below.h"

#include <gtest/gtest.h>

#include "collision/geometry/aabb.h"
#include "tests/perception/model/tilted_vessels.h"
#include "tests/perception/table_scene.h"

namespace cwm::perception {
namespace {

constexpr double kSmallHeight_m = 0.1, kLargeHeight_m = 0.05;

// A large box on a small one. The camera sees neither where they touch nor the small one's upper
// end.
SceneInterpretation LargeOnSmall(double turned_deg) {
  const auto place = [](double middle_m, double yaw_deg) {
    Pose X_WO = MakeTranslation(0, 0, middle_m);
    X_WO.rotate(Eigen::AngleAxisd(yaw_deg * kDegree_rad, Vector3::UnitZ()));
    return X_WO;
  };
  return Interpreted(
      {{Table(),
        MakeObject("small", Box{{0.08, 0.08, kSmallHeight_m}}, place(0.5 * kSmallHeight_m, 10)),
        MakeObject("large", Box{{0.15, 0.16, kLargeHeight_m}},
                   place(kSmallHeight_m + 0.5 * kLargeHeight_m, 10 + turned_deg))}});
}

TEST(ABoxThatOverhangsASmallOne, RestsOnIt) {
  for (const double turned_deg : {0.0, 20.0, 45.0}) {
    const SceneInterpretation scene = LargeOnSmall(turned_deg);
    ASSERT_EQ(scene.objects.size(), 2u) << turned_deg;  // the upper one is the larger
    EXPECT_EQ(scene.objects[0].kind, DetectedKind::kObject) << turned_deg;
    EXPECT_EQ(scene.objects[0].rests_on, 1) << turned_deg;
  }
}

TEST(ABoxThatOverhangsASmallOne, IsReachedByItsHiddenTop) {
  constexpr double kWithin_m = 0.006;  // the height that creases take from a foot
  const SceneInterpretation scene = LargeOnSmall(0);
  ASSERT_EQ(scene.objects.size(), 2u);
  for (const std::size_t k : {0u, 1u}) {
    ASSERT_EQ(scene.objects[k].model->shapes.size(), 1u);
    const ShapePart& part = scene.objects[k].model->shapes.front();
    EXPECT_TRUE(std::holds_alternative<Box>(part.shape));
    const Aabb bounds = TightBounds(part.shape, scene.objects[k].X_WO * part.X_OS);
    EXPECT_NEAR(k == 0 ? bounds.min().z() : bounds.max().z(), kSmallHeight_m, kWithin_m) << k;
  }
}

}  // namespace
}  // namespace cwm::perception
