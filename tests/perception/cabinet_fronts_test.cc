// Doors that stand out from the face of their cabinet, seen by the virtual scanner: both are faces
// of it.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/perception/table_scene.h"

namespace cwm::perception {
namespace {

constexpr double kCabinet_m = 0.25;  // x of the cabinet's face

// The share of the residuals' points that belong to no shape.
double Unexplained(const SceneInterpretation& scene) {
  std::int64_t points = 0, unexplained = 0;
  for (std::uint32_t label : scene.labels) {
    if (label < 20) continue;
    const DetectedObject& object = scene.objects[label / 10 - 2];
    if (object.kind != DetectedKind::kResidual) continue;
    ++points;
    unexplained += label % 10 == 0;
  }
  EXPECT_GT(points, 0);
  return static_cast<double>(unexplained) / static_cast<double>(std::max<std::int64_t>(points, 1));
}

class CabinetFront : public ::testing::TestWithParam<double> {};

TEST_P(CabinetFront, AndDoorBesideItAreFaces) {
  const double out_m = GetParam();
  const SceneInterpretation scene = Interpreted(
      {{Table(),
        MakeObject("cabinet", Box{{0.1, 3, 2}}, MakeTranslation(kCabinet_m + 0.05, 0, 0.5)),
        MakeObject("door", Box{{0.1, 1.5, 2}},
                   MakeTranslation(kCabinet_m + 0.05 - out_m, 0.75, 0.5))}});
  EXPECT_LT(Unexplained(scene), 0.03);
}

INSTANTIATE_TEST_SUITE_P(Out_m, CabinetFront, ::testing::Values(0.012, 0.018, 0.03));

}  // namespace
}  // namespace cwm::perception
