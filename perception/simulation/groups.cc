#include "perception/simulation/groups.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "perception/simulation/angles.h"
#include "perception/simulation/hull_distance.h"
#include "perception/simulation/vessel_meshes.h"

namespace cwm::perception {
namespace {

Pose TurnedAt(const Vector3& place, double yaw_rad) {
  return MakePose(place, Quaternion(Eigen::AngleAxisd(yaw_rad, Vector3::UnitZ())));
}

// A solid with its frame at its centre, placed with its foot at z = 0 of the object's frame.
SimulatedObject Standing(std::string name, Shape shape, double height_m) {
  return {.name = std::move(name),
          .parts = {{.X_FS = MakeTranslation(0, 0, 0.5 * height_m), .shape = std::move(shape)}}};
}

// One member of a stack: a solid of revolution with its widths at the foot and the top.
struct Storey {
  SimulatedObject object;
  double foot_m = 0, head_m = 0, height_m = 0;
};

// A tin with narrower ends: a groove runs around where two of them meet.
Storey DrawCan(double radius_m, double height_m, RandomDraws& draws) {
  const double rim_m = draws.Uniform(0.002, 0.0035);
  const double low_m = 0.5 * rim_m, high_m = height_m - low_m;
  SimulatedObject can{
      .name = "can",
      .parts = {
          {.X_FS = MakeTranslation(0, 0, 0.5 * height_m),
           .shape = Cylinder{.radius_m = radius_m, .length_m = height_m - 2 * rim_m}},
          {.X_FS = MakeTranslation(0, 0, low_m),
           .shape = Cone{.radius_bottom_m = radius_m - rim_m,
                         .radius_top_m = radius_m,
                         .length_m = rim_m}},
          {.X_FS = MakeTranslation(0, 0, high_m),
           .shape = Cone{
               .radius_bottom_m = radius_m, .radius_top_m = radius_m - rim_m, .length_m = rim_m}}}};
  return {std::move(can), radius_m - rim_m, radius_m - rim_m, height_m};
}

// A closed cup or bowl.
Storey DrawTapered(const char* name, double narrow_m, double wide_m, double height_m,
                   bool is_over) {
  const double foot_m = is_over ? wide_m : narrow_m, head_m = is_over ? narrow_m : wide_m;
  return {
      Standing(name, Cone{.radius_bottom_m = foot_m, .radius_top_m = head_m, .length_m = height_m},
               height_m),
      foot_m, head_m, height_m};
}

Storey DrawStorey(RandomDraws& draws) {
  const double share = draws.Uniform();
  if (share < 0.6) {
    const bool is_tall = share < 0.3;
    const double radius_m = is_tall ? draws.Uniform(0.025, 0.05) : draws.Uniform(0.035, 0.07);
    const double height_m = is_tall ? draws.Uniform(0.06, 0.14) : draws.Uniform(0.025, 0.06);
    return DrawCan(radius_m, height_m, draws);
  }
  const bool is_over = draws.Uniform() < 0.5;
  if (share < 0.8) {
    const double narrow_m = draws.Uniform(0.022, 0.035);
    return DrawTapered("cup", narrow_m, narrow_m + draws.Uniform(0.006, 0.020),
                       draws.Uniform(0.06, 0.12), is_over);
  }
  const double narrow_m = draws.Uniform(0.03, 0.045);
  return DrawTapered("bowl", narrow_m, narrow_m + draws.Uniform(0.025, 0.045),
                     draws.Uniform(0.035, 0.07), is_over);
}

// True if the upper one's foot is not much wider than the lower one's top, as in real stacks.
bool Stands(const Storey& upper, const Storey& lower) {
  constexpr double kMaxWider = 1.25;
  return upper.foot_m <= kMaxWider * lower.head_m;
}

Group StackOf(std::vector<Storey> storeys, RandomDraws& draws) {
  constexpr double kMaxOffAxis_m = 0.002;
  Group group;
  double foot_m = 0;
  for (Storey& storey : storeys) {
    const bool is_lowest = group.members.empty();
    const double off_m = is_lowest ? 0 : kMaxOffAxis_m * draws.Uniform();
    const double angle_rad = draws.Uniform(0, 2 * std::numbers::pi);
    storey.object.X_WO =
        TurnedAt({off_m * std::cos(angle_rad), off_m * std::sin(angle_rad), foot_m}, angle_rad);
    foot_m += storey.height_m;
    group.members.push_back(std::move(storey.object));
  }
  return group;
}

// Each cup is lifted slightly above where its wall touches the one below: by more than the wall's
// thickness over the sine of the half angle.
Group DrawNested(RandomDraws& draws) {
  const double half_angle_rad = Radians(draws.Uniform(6, 14));
  const double foot_m = draws.Uniform(0.022, 0.032);
  const double height_m = draws.Uniform(0.07, 0.12);
  const VesselWall wall{
      .outer = {{foot_m, 0}, {foot_m + height_m * std::tan(half_angle_rad), height_m}},
      .wall_m = draws.Uniform(0.0015, 0.0025),
      .floor_m = 0.003};
  const double wall_room_m = wall.wall_m / std::tan(half_angle_rad);  // wall_m is across the axis
  const double lift_m = std::max(wall_room_m, wall.floor_m) + draws.Uniform(0.001, 0.006);
  Group group;
  const int count = 2 + draws.Below(3);
  for (int k = 0; k < count; ++k) {
    SimulatedObject cup{.name = "nested", .parts = {{.shape = MakeMesh(MakeVessel(wall))}}};
    cup.X_WO = TurnedAt({0, 0, k * lift_m}, 0);
    group.members.push_back(std::move(cup));
  }
  return group;
}

// Books and flat packets.
Vector3 DrawFlat_m(RandomDraws& draws) {
  if (draws.Uniform() < 0.5) {
    return {draws.Uniform(0.15, 0.24), draws.Uniform(0.10, 0.17), draws.Uniform(0.010, 0.040)};
  }
  return {draws.Uniform(0.08, 0.18), draws.Uniform(0.05, 0.13), draws.Uniform(0.015, 0.070)};
}

SimulatedObject Flat(const Vector3& size_m) {
  return Standing("flat", Box{.size_m = size_m}, size_m.z());
}

const Vector3& SizeOf(const SimulatedObject& flat) {
  return std::get<Box>(flat.parts.front().shape).size_m;
}

bool IsLevel(const SimulatedObject& flat) { return flat.X_WO.linear()(2, 2) > 1 - 1e-12; }

// True if the object is clear of all others except those that it rests on.
bool KeepsClear(const Group& heap, const SimulatedObject& flat,
                const std::vector<std::size_t>& resting_on) {
  constexpr double kMinGap_m = 0.001;
  for (std::size_t k = 0; k < heap.members.size(); ++k) {
    if (std::ranges::count(resting_on, k) > 0) continue;
    if (Clearance_m(heap.members[k], flat) < kMinGap_m) return false;
  }
  return true;
}

// Places its middle over the middle part of the lower one.
std::optional<SimulatedObject> LayOn(const Group& heap, std::size_t lower, RandomDraws& draws) {
  constexpr double kSquare = 0.4;  // share of square ones; the others lie at any angle
  const SimulatedObject& below = heap.members[lower];
  if (!IsLevel(below)) return std::nullopt;
  SimulatedObject flat = Flat(DrawFlat_m(draws));
  const Vector3& size_m = SizeOf(below);
  const double turn_rad =
      draws.Uniform() < kSquare ? 0 : draws.Uniform(-std::numbers::pi, std::numbers::pi);
  const Vector3 place{draws.Uniform(-0.3, 0.3) * size_m.x(), draws.Uniform(-0.3, 0.3) * size_m.y(),
                      size_m.z()};
  flat.X_WO = below.X_WO * TurnedAt(place, turn_rad);
  if (!KeepsClear(heap, flat, {lower})) return std::nullopt;
  return flat;
}

// Places a long edge on the table and the lower face on an upper edge of the holder.
std::optional<SimulatedObject> LeanOn(const Group& heap, std::size_t lower, RandomDraws& draws) {
  const SimulatedObject& below = heap.members[lower];
  const Vector3& held_by_m = SizeOf(below);
  if (!IsLevel(below) || below.X_WO.translation().z() > 0) return std::nullopt;
  SimulatedObject flat = Flat(DrawFlat_m(draws));
  const Vector3& size_m = SizeOf(flat);
  const double out_m = held_by_m.z() * draws.Uniform(0.6, 2.0);
  if (std::hypot(out_m, held_by_m.z()) > 0.85 * size_m.x()) return std::nullopt;
  const double rise_rad = std::atan2(held_by_m.z(), out_m);
  const int side = draws.Below(4);
  const double half_m = 0.5 * (side % 2 == 0 ? held_by_m.x() : held_by_m.y());
  const double half_width_m = 0.5 * (side % 2 == 0 ? held_by_m.y() : held_by_m.x());
  // The frame's x axis points out of that side: up along the slab is -x and z.
  const Vector3 up_along(-std::cos(rise_rad), 0, std::sin(rise_rad));
  const Vector3 normal(std::sin(rise_rad), 0, std::cos(rise_rad));
  Pose X_SideFlat = Pose::Identity();
  X_SideFlat.linear().col(0) = up_along;
  X_SideFlat.linear().col(1) = normal.cross(up_along);
  X_SideFlat.linear().col(2) = normal;
  X_SideFlat.translation() = Vector3(half_m + out_m, draws.Uniform(-0.6, 0.6) * half_width_m, 0) +
                             0.5 * size_m.x() * up_along;
  flat.X_WO = below.X_WO * TurnedAt(Vector3::Zero(), side * std::numbers::pi / 2) * X_SideFlat;
  if (!KeepsClear(heap, flat, {lower})) return std::nullopt;
  return flat;
}

// Places it on the table, beside one that stands there.
std::optional<SimulatedObject> LayBeside(const Group& heap, std::size_t other, RandomDraws& draws) {
  SimulatedObject flat = Flat(DrawFlat_m(draws));
  const Vector3 middle = heap.members[other].X_WO.translation();
  const double angle_rad = draws.Uniform(0, 2 * std::numbers::pi);
  const Vector3 away(std::cos(angle_rad), std::sin(angle_rad), 0);
  constexpr double kStart_m = 0.4;  // clear of the two largest
  flat.X_WO = TurnedAt(Vector3(middle.x(), middle.y(), 0) + kStart_m * away,
                       draws.Uniform(0, 2 * std::numbers::pi));
  if (!SlideUntilTouching(-away, heap.members[other], flat)) return std::nullopt;
  if (!KeepsClear(heap, flat, {other})) return std::nullopt;
  return flat;
}

// The radius of a lid, nearly that of the body.
double NearlyAsWide_m(double radius_m, RandomDraws& draws) {
  return radius_m + draws.Uniform(-0.003, 0.003);
}

}  // namespace

SimulatedObject MergedObject(const Group& group) {
  SimulatedObject one{.name = "group"};
  for (const SimulatedObject& member : group.members) {
    for (std::size_t k = 0; k < member.parts.size(); ++k) {
      one.parts.push_back(
          {.X_FS = member.X_WO * member.parts[k].X_FS, .shape = member.parts[k].shape});
      one.part_roles.push_back(member.RoleOf(k));
    }
  }
  return one;
}

std::vector<SimulatedObject> MembersOf(const Group& group, const SimulatedObject& placed) {
  std::vector<SimulatedObject> members = group.members;
  for (SimulatedObject& member : members) member.X_WO = placed.X_WO * member.X_WO;
  return members;
}

Group DrawStack(RandomDraws& draws) {
  constexpr double kNested = 0.2, kAlike = 0.3;
  const double share = draws.Uniform();
  if (share < kNested) return DrawNested(draws);
  const int count = 2 + draws.Below(3);
  std::vector<Storey> storeys;
  const auto is_whole = [&] { return static_cast<int>(storeys.size()) == count; };
  if (share < kNested + kAlike) {  // cans or tins of one kind, as in shops
    const double radius_m = draws.Uniform(0.03, 0.055), height_m = draws.Uniform(0.03, 0.11);
    while (!is_whole()) storeys.push_back(DrawCan(radius_m, height_m, draws));
    return StackOf(std::move(storeys), draws);
  }
  while (!is_whole()) {
    Storey storey = DrawStorey(draws);
    if (storeys.empty() || Stands(storey, storeys.back())) storeys.push_back(std::move(storey));
  }
  return StackOf(std::move(storeys), draws);
}

Group DrawHeap(int max_members, RandomDraws& draws) {
  constexpr int kMinMembers = 3, kAttempts = 200;
  const int wanted = kMinMembers + draws.Below(max_members - kMinMembers + 1);
  Group heap;
  heap.members.push_back(Flat(DrawFlat_m(draws)));
  for (int i = 0; i < kAttempts && static_cast<int>(heap.members.size()) < wanted; ++i) {
    const auto other = static_cast<std::size_t>(draws.Below(static_cast<int>(heap.members.size())));
    const double share = draws.Uniform();
    auto flat = share < 0.5    ? LayOn(heap, other, draws)
                : share < 0.75 ? LeanOn(heap, other, draws)
                               : LayBeside(heap, other, draws);
    if (flat) heap.members.push_back(*std::move(flat));
  }
  return heap;
}

Group DrawRow(RandomDraws& draws) {
  constexpr double kSameHeight_m = 0.0005, kMaxGap_m = 0.004, kFlush_m = 0.010;
  const double kind = draws.Uniform();
  const double height_m = kind < 0.3   ? draws.Uniform(0.025, 0.07)
                          : kind < 0.7 ? draws.Uniform(0.12, 0.24)
                                       : draws.Uniform(0.07, 0.14);
  const double depth_m = draws.Uniform(0.07, 0.16), radius_m = draws.Uniform(0.025, 0.045);
  const int count = 3 + draws.Below(4);
  Group row;
  double at_m = 0;
  for (int k = 0; k < count; ++k) {
    const double own_height_m = height_m + draws.Uniform(-kSameHeight_m, kSameHeight_m);
    const double gap_m = draws.Uniform() < 0.5 ? 1e-4 : draws.Uniform(0, kMaxGap_m);
    SimulatedObject object;
    double width_m = 2 * radius_m;
    if (kind < 0.7) {  // flat packets side by side, or standing books and packets
      width_m = kind < 0.3 ? draws.Uniform(0.05, 0.12) : draws.Uniform(0.02, 0.07);
      object = Standing("packet",
                        Box{.size_m = {width_m, depth_m * draws.Uniform(0.9, 1), own_height_m}},
                        own_height_m);
    } else {
      object =
          Standing("can", Cylinder{.radius_m = radius_m, .length_m = own_height_m}, own_height_m);
    }
    object.X_WO = TurnedAt({at_m + 0.5 * width_m, draws.Uniform(-kFlush_m, kFlush_m), 0}, 0);
    at_m += width_m + gap_m;
    row.members.push_back(std::move(object));
  }
  for (SimulatedObject& object : row.members) object.X_WO.translation().x() -= 0.5 * at_m;
  return row;
}

SimulatedObject DrawLiddedObject(RandomDraws& draws) {
  const double lid_m = draws.Uniform(0.002, 0.015);
  const double height_m = draws.Uniform(0.05, 0.16);
  const Pose X_OBody = MakeTranslation(0, 0, 0.5 * height_m);
  const Pose X_OLid = MakeTranslation(0, 0, height_m + 0.5 * lid_m);
  if (draws.Uniform() < 0.3) {
    const Vector3 size_m{draws.Uniform(0.07, 0.18), draws.Uniform(0.06, 0.14), height_m};
    const double wider_m = draws.Uniform(-0.003, 0.003);
    return {
        .name = "carton",
        .parts = {
            {.X_FS = X_OBody, .shape = Box{.size_m = size_m}},
            {.X_FS = X_OLid,
             .shape = Box{.size_m = {size_m.x() + 2 * wider_m, size_m.y() + 2 * wider_m, lid_m}}}}};
  }
  const double radius_m = draws.Uniform(0.025, 0.06);
  return {.name = "jar",
          .parts = {
              {.X_FS = X_OBody, .shape = Cylinder{.radius_m = radius_m, .length_m = height_m}},
              {.X_FS = X_OLid,
               .shape = Cylinder{.radius_m = NearlyAsWide_m(radius_m, draws), .length_m = lid_m}}}};
}

}  // namespace cwm::perception
