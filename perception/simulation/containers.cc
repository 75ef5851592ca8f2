#include "perception/simulation/containers.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "perception/simulation/household_goods.h"
#include "perception/simulation/hull_distance.h"
#include "perception/simulation/vessels.h"

namespace cwm::perception {
namespace {

struct OpenBox {
  Vector3 size_m = Vector3::Zero();
  double wall_m = 0;
};

OpenBox DrawSizes(RandomDraws& draws) {
  const bool is_tray = draws.Uniform() < 0.5;
  const double length_m = draws.Uniform(0.15, 0.40);
  const double width_m = length_m * draws.Uniform(0.6, 1.0);
  const double height_m = is_tray ? draws.Uniform(0.03, 0.06) : draws.Uniform(0.08, 0.16);
  return {.size_m = {length_m, width_m, height_m}, .wall_m = draws.Uniform(0.002, 0.006)};
}

SimulatedObject Built(const OpenBox& box) {
  const Vector3& size_m = box.size_m;
  const double wall_m = box.wall_m;
  SimulatedObject object{.name = "open box"};
  object.parts.push_back({.X_FS = MakeTranslation(0, 0, 0.5 * wall_m),
                          .shape = Box{.size_m = {size_m.x(), size_m.y(), wall_m}}});
  for (const double side : {-0.5, 0.5}) {
    object.parts.push_back(
        {.X_FS = MakeTranslation(side * (size_m.x() - wall_m), 0, 0.5 * size_m.z()),
         .shape = Box{.size_m = {wall_m, size_m.y(), size_m.z()}}});
    object.parts.push_back(
        {.X_FS = MakeTranslation(0, side * (size_m.y() - wall_m), 0.5 * size_m.z()),
         .shape = Box{.size_m = {size_m.x(), wall_m, size_m.z()}}});
  }
  return object;
}

// Puts the goods anywhere on the floor, clear of the walls and of what stands there already.
std::optional<SimulatedObject> PutInto(const OpenBox& box, const Group& filled,
                                       SimulatedObject goods, RandomDraws& draws) {
  constexpr double kMinGap_m = 0.008;
  const double yaw_rad = draws.Uniform(0, 2 * std::numbers::pi);
  goods.X_WO =
      MakePose({0, 0, box.wall_m}, Quaternion(Eigen::AngleAxisd(yaw_rad, Vector3::UnitZ())));
  const Aabb bounds = BoundsInWorld(goods);
  const Vector3 inner_m = box.size_m.array() - 2 * (box.wall_m + kMinGap_m);
  const Vector3 room_m = inner_m - bounds.sizes();
  if (room_m.head<2>().minCoeff() < 0) return std::nullopt;
  for (const Eigen::Index axis : {0, 1}) {
    goods.X_WO.translation()[axis] =
        draws.Uniform(-0.5, 0.5) * room_m[axis] - bounds.center()[axis];
  }
  for (std::size_t k = 1; k < filled.members.size(); ++k) {
    if (Clearance_m(filled.members[k], goods) < kMinGap_m) return std::nullopt;
  }
  return goods;
}

// The angle about x by which a vessel comes to lie on the line from its foot to its rim.
double LyingTilt_rad(const TriangleMesh& body) {
  double height_m = 0, foot_m = 0, rim_m = 0;
  for (const Vector3& vertex : body.vertices) height_m = std::max(height_m, vertex.z());
  for (const Vector3& vertex : body.vertices) {
    const double radius_m = std::hypot(vertex.x(), vertex.y());
    double& widest_m = vertex.z() < 0.5 * height_m ? foot_m : rim_m;
    widest_m = std::max(widest_m, radius_m);
  }
  return std::atan2(height_m, rim_m - foot_m);
}

}  // namespace

Group DrawOpenBox(RandomDraws& draws) {
  constexpr int kMaxGoods = 3, kAttempts = 40;
  const OpenBox box = DrawSizes(draws);
  Group group;
  group.members.push_back(Built(box));
  const int wanted = 1 + draws.Below(kMaxGoods + 1);
  for (int i = 0; i < kAttempts && static_cast<int>(group.members.size()) < wanted; ++i) {
    const auto kind = static_cast<GoodsKind>(draws.Below(kGoodsKindCount));
    SimulatedObject goods = DrawGoods(kind, RestPose::kStanding, draws);
    if (auto put = PutInto(box, group, std::move(goods), draws)) {
      group.members.push_back(*std::move(put));
    }
  }
  return group;
}

SimulatedObject DrawLyingVessel(RandomDraws& draws) {
  SimulatedObject vessel = DrawVessel(DrawVesselKind(draws), draws);
  const TriangleMesh& body = *std::get<Mesh>(vessel.parts.front().shape).mesh;
  const Pose X_OStanding = MakePose(
      Vector3::Zero(), Quaternion(Eigen::AngleAxisd(LyingTilt_rad(body), Vector3::UnitX())));
  for (Placed<>& part : vessel.parts) part.X_FS = X_OStanding * part.X_FS;
  const Aabb bounds = BoundsInWorld(vessel);
  const Pose X_OLying = MakeTranslation(0, -bounds.center().y(), -bounds.min().z());
  for (Placed<>& part : vessel.parts) part.X_FS = X_OLying * part.X_FS;
  return vessel;
}

}  // namespace cwm::perception
