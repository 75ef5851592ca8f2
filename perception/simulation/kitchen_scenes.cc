#include "perception/simulation/kitchen_scenes.h"

#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "perception/simulation/angles.h"
#include "perception/simulation/furniture.h"
#include "perception/simulation/household_goods.h"
#include "perception/simulation/look_at.h"
#include "perception/simulation/proposals.h"
#include "perception/simulation/vessels.h"

namespace cwm::perception {
namespace {

// The counter's front edge is at x = 0 and the wall at x = kDepth_m. The counter runs along y from
// -kHalfLength_m to the side table.
constexpr double kDepth_m = 0.6;  // of usual kitchens
constexpr double kHalfLength_m = 1.0;
constexpr double kFrontStandsBack_m = 0.03;
constexpr double kFront_m = 0.018;     // thickness of the doors
constexpr double kFrontGap_m = 0.004;  // between doors
constexpr double kWallHeight_m = 2.3;

struct Kitchen {
  RestingArea counter, shelf, side_table;
  double counter_end_y_m = 0;
};

Eigen::AlignedBox2d Rectangle(double x0, double y0, double x1, double y1) {
  return {Vector2(x0, y0), Vector2(x1, y1)};
}

Kitchen DrawKitchen(RandomDraws& draws) {
  const double end_y_m = draws.Uniform(0.15, 0.4);
  const double shelf_begin_y_m = draws.Uniform(-0.6, -0.35);
  const double shelf_depth_m = draws.Uniform(0.20, 0.28);
  return {.counter = {.area_W = Rectangle(0, -kHalfLength_m, kDepth_m, end_y_m),
                      .top_m = draws.Uniform(0.86, 0.94)},
          .shelf = {.area_W = Rectangle(kDepth_m - shelf_depth_m, shelf_begin_y_m, kDepth_m,
                                        shelf_begin_y_m + draws.Uniform(0.7, 1.0)),
                    .top_m = draws.Uniform(1.28, 1.40)},
          .side_table = {.area_W = Rectangle(draws.Uniform(0, 0.1), end_y_m + 0.02, kDepth_m - 0.02,
                                             kHalfLength_m),
                         .top_m = draws.Uniform(0.68, 0.78)},
          .counter_end_y_m = end_y_m};
}

void AddFronts(const Kitchen& kitchen, SimulatedScene& scene) {
  constexpr double kWidth_m = 0.45;
  const double top_m = kitchen.counter.top_m - 0.05;
  double left_m = kitchen.counter.area_W.min().y();
  for (int number = 1; left_m < kitchen.counter_end_y_m - kWidth_m; ++number) {
    scene.objects.push_back(
        MakeBlock("front_" + std::to_string(number),
                  Aabb(Vector3(kFrontStandsBack_m, left_m, 0.1),
                       Vector3(kFrontStandsBack_m + kFront_m, left_m + kWidth_m, top_m))));
    left_m += kWidth_m + kFrontGap_m;
  }
}

SimulatedScene Furnish(const Kitchen& kitchen) {
  constexpr double kTop_m = 0.04;
  const auto top = [](const char* name, const RestingArea& area, double thickness_m) {
    return MakeTop(name, {.area_W = area.area_W, .top_m = area.top_m, .thickness_m = thickness_m});
  };
  SimulatedScene scene;
  scene.objects = {
      top("counter", kitchen.counter, kTop_m),
      top("shelf", kitchen.shelf, 0.02),
      top("side_table", kitchen.side_table, 0.025),
      top("floor", {.area_W = Rectangle(-2, -1.5, kDepth_m, 1.5), .top_m = 0}, 0.1),
      MakeBlock("wall",
                Aabb(Vector3(kDepth_m, -1.5, 0), Vector3(kDepth_m + 0.1, 1.5, kWallHeight_m))),
      MakeBlock("cabinet",
                Aabb(Vector3(kFrontStandsBack_m + kFront_m, -kHalfLength_m, 0),
                     Vector3(kDepth_m, kitchen.counter_end_y_m, kitchen.counter.top_m - kTop_m)))};
  AddFronts(kitchen, scene);
  return scene;
}

PinholeCamera DrawCamera(RandomDraws& draws) {
  const Vector3 target_W{0.35, draws.Uniform(-0.05, 0.2), draws.Uniform(1.0, 1.08)};
  const ViewingDirection view{.distance_m = draws.Uniform(1.1, 1.4),
                              .down_rad = Radians(draws.Uniform(24, 36)),
                              .azimuth_rad = Radians(draws.Uniform(-25, 25))};
  PinholeCamera camera;
  camera.X_WC = LookAt(target_W, view);
  return camera;
}

SimulatedObject DrawKitchenObject(RandomDraws& draws) {
  constexpr double kVessels = 0.5;
  if (draws.Uniform() < kVessels) {
    return DrawVessel(DrawVesselKind(draws), draws);
  }
  constexpr double kLying = 0.2;
  const auto kind = static_cast<GoodsKind>(draws.Below(kGoodsKindCount));
  const bool lies = kind != GoodsKind::kBox && draws.Uniform() < kLying;
  return DrawGoods(kind, lies ? RestPose::kLying : RestPose::kStanding, draws);
}

int Fill(int wanted, const RestingArea& area, Arrangement& arrangement, RandomDraws& draws) {
  constexpr int kAttempts = 40;
  const Disc over{.middle_W = area.area_W.center(),
                  .radius_m = 0.5 * area.area_W.diagonal().norm()};
  int added = 0;
  for (int i = 0; i < 4 * wanted && added < wanted; ++i) {
    const SimulatedObject object = DrawKitchenObject(draws);
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      auto proposal = ProposeWithin(over, arrangement, area, object, draws);
      if (!proposal) continue;
      AddNumbered(*std::move(proposal), arrangement);
      ++added;
      break;
    }
  }
  return added;
}

}  // namespace

SimulatedView RandomKitchenView(std::uint64_t seed) {
  for (std::uint64_t stream = 0;; ++stream) {
    RandomDraws draws(seed, stream);
    const Kitchen kitchen = DrawKitchen(draws);
    Arrangement arrangement(Furnish(kitchen), DrawCamera(draws),
                            {.min_gap_m = 0.015, .max_hidden = 0.5});
    // The shelf is filled first: it is the smallest, and objects before it hide it.
    const std::array<std::pair<RestingArea, int>, 3> areas = {
        {{kitchen.shelf, 2 + draws.Below(3)},
         {kitchen.side_table, 2 + draws.Below(3)},
         {kitchen.counter, 4 + draws.Below(4)}}};
    bool all_carry = true;
    for (const auto& [area, wanted] : areas) {
      all_carry = Fill(wanted, area, arrangement, draws) >= 2 && all_carry;
    }
    if (all_carry) return {.scene = arrangement.scene(), .camera = arrangement.camera()};
  }
}

}  // namespace cwm::perception
