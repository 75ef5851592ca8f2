// The floor of a pan lies on the plane of the pan's support, within noise.
#include <gtest/gtest.h>

#include <cstdint>
#include <map>
#include <string>

#include "perception/interpret_scene.h"
#include "perception/simulation/random_scenes.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {
namespace {

struct View {
  SceneFamily family;
  std::uint64_t seed;
};

class FloorOfAPan : public ::testing::TestWithParam<View> {};

// The pan's rim is a line of pixels; the floor and the table are linked across it at corners.
TEST_P(FloorOfAPan, IsNoPartOfTheSupport) {
  const SimulatedView view = RandomScene(GetParam().family, GetParam().seed);
  const SimulatedCloud scan = Scan(view.scene, view.camera, {.seed = GetParam().seed});
  InterpretOptions options;
  options.X_WC = view.camera.X_WC;
  const auto found = InterpretScene(scan.cloud, options);
  ASSERT_TRUE(found.ok()) << found.status();
  struct Points {
    int all = 0, in_support = 0;
  };
  std::map<std::int32_t, Points> of_pan;
  for (std::size_t i = 0; i < scan.object.size(); ++i) {
    const std::int32_t object = scan.object[i];
    if (object < 0) continue;
    if (!view.scene.objects[static_cast<std::size_t>(object)].name.starts_with("pan")) continue;
    ++of_pan[object].all;
    of_pan[object].in_support += found->labels[i] >= 1 && found->labels[i] <= 9;
  }
  EXPECT_FALSE(of_pan.empty());
  for (const auto& [pan, points] : of_pan) {
    EXPECT_LT(points.in_support, points.all / 20)
        << view.scene.objects[static_cast<std::size_t>(pan)].name;
  }
}

INSTANTIATE_TEST_SUITE_P(Views, FloorOfAPan,
                         ::testing::Values(View{SceneFamily::kKitchen, 1023},
                                           View{SceneFamily::kKitchen, 1042},
                                           View{SceneFamily::kVessels, 1009},
                                           View{SceneFamily::kVessels, 1032},
                                           View{SceneFamily::kVessels, 1044}));

}  // namespace
}  // namespace cwm::perception
