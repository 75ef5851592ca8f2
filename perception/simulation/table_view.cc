#include "perception/simulation/table_view.h"

#include <utility>

#include "perception/simulation/angles.h"
#include "perception/simulation/furniture.h"
#include "perception/simulation/look_at.h"

namespace cwm::perception {
namespace {

Eigen::AlignedBox2d Centred(const Vector2& middle, const Vector2& size_m) {
  return {middle - 0.5 * size_m, middle + 0.5 * size_m};
}

// From the middle of a table to a place near the middle of one of its edges.
Vector2 ToEdge(const Vector2& size_m, RandomDraws& draws) {
  constexpr double kInside_m = 0.08;
  const int side = draws.Below(4);
  const double sign = side < 2 ? 1 : -1;
  return side % 2 == 0 ? Vector2(sign * (0.5 * size_m.x() - kInside_m), 0)
                       : Vector2(0, sign * (0.5 * size_m.y() - kInside_m));
}

// The middle of the objects is on the world's z axis, which the camera's axis intersects.
Table DrawTable(const ArrangementRules& rules, TableMiddle seen, RandomDraws& draws) {
  const double top_m = draws.Uniform(0.65, 0.95);  // dining tables to counters
  const Vector2 size_m{draws.Uniform(1.1, 1.7), draws.Uniform(0.8, 1.1)};
  Vector2 middle{draws.Uniform(-0.15, 0.15), draws.Uniform(-0.10, 0.10)};
  if (seen == TableMiddle::kEdgeInView) middle += ToEdge(size_m, draws);
  const RestingArea area{.area_W = Centred(middle, size_m), .top_m = top_m};
  SimulatedScene scene;
  scene.objects.push_back(MakeTop(
      "table", {.area_W = area.area_W, .top_m = top_m, .thickness_m = draws.Uniform(0.02, 0.04)}));
  if (draws.Uniform() < 0.5) {
    const Eigen::AlignedBox2d floor = Centred(Vector2::Zero(), {3, 3});
    scene.objects.push_back(MakeTop("floor", {.area_W = floor, .top_m = 0, .thickness_m = 0.1}));
  }
  const ViewingDirection view{.distance_m = draws.Uniform(0.6, 1.2),
                              .down_rad = Radians(draws.Uniform(20, 70)),
                              .azimuth_rad = Radians(draws.Uniform(0, 360))};
  PinholeCamera camera;
  camera.X_WC = LookAt(Vector3(0, 0, top_m + 0.05), view);  // half the height of a usual object
  // Nearly to the border of the image, which is at 0.46 (down) to 0.61 (across) of the distance.
  return {.area = area,
          .spread = {.radius_m = 0.42 * view.distance_m},
          .arrangement = Arrangement(std::move(scene), camera, rules)};
}

}  // namespace

SimulatedView DrawTableView(SceneFamily family, std::uint64_t seed, const ObjectCountRange& count,
                            const ArrangementRules& rules, const TableFiller& fill,
                            TableMiddle middle) {
  constexpr std::uint64_t kFamilies = 16;  // more than there are, so that each has its own streams
  for (auto stream = static_cast<std::uint64_t>(family);; stream += kFamilies) {
    RandomDraws draws(seed, stream);
    const int wanted = count.min + draws.Below(count.max - count.min + 1);
    Table table = DrawTable(rules, middle, draws);
    fill(wanted, table, draws);
    if (table.object_count() < static_cast<std::size_t>(count.min)) continue;
    return {.scene = table.arrangement.scene(), .camera = table.arrangement.camera()};
  }
}

}  // namespace cwm::perception
