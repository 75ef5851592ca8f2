#include "perception/simulation/furniture.h"

#include <utility>

namespace cwm::perception {

SimulatedObject MakeTop(std::string name, const LevelTop& top) {
  const Vector2& a = top.area_W.min();
  const Vector2& b = top.area_W.max();
  Plate plate{.outline = {a, {b.x(), a.y()}, b, {a.x(), b.y()}},
              .holes = {},
              .thickness_m = top.thickness_m};
  return {.name = std::move(name),
          .parts = {{.X_FS = Pose::Identity(), .shape = std::move(plate)}},
          .X_WO = MakeTranslation(0, 0, top.top_m),
          .is_support = true};
}

SimulatedObject MakeBlock(std::string name, const Aabb& bounds_W) {
  return {.name = std::move(name),
          .parts = {{.X_FS = Pose::Identity(), .shape = Box{.size_m = bounds_W.sizes()}}},
          .X_WO = Pose(Eigen::Translation3d(bounds_W.center()))};
}

}  // namespace cwm::perception
