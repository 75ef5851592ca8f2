#include "perception/simulation/vessels.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "perception/simulation/angles.h"
#include "perception/simulation/vessel_meshes.h"

namespace cwm::perception {
namespace {

constexpr int kBowPoints = 25;

// Handles and spouts are thin where they leave the wall, as if welded on: a thick end would come
// out on the other side of a thin, round or slanted wall.
constexpr double kRootThickness = 0.3;  // of the full thickness
constexpr double kRootLength_m = 0.006;

double Thickness(double way_m) {
  return std::min(1.0, std::lerp(kRootThickness, 1.0, way_m / kRootLength_m));
}

// Half the thickness and half the width of a handle.
struct Grip {
  double half_thickness_m = 0;
  double half_width_m = 0;
};

Grip DrawGrip(RandomDraws& draws) {
  const double half_thickness_m = 0.5 * draws.Uniform(0.005, 0.015);
  const double flatness = draws.Uniform(1, 1.5);  // round wire to a band
  return {.half_thickness_m = half_thickness_m,
          .half_width_m = std::min(flatness * half_thickness_m, 0.009)};
}

struct Bow {
  double low_m = 0;
  double high_m = 0;
  double reach_m = 0;  // of the centre line, out of the wall
};

// A bow leaves the wall at the upper height and returns to it at the lower one. Its ends lie within
// the wall: they are not visible inside the vessel, and leave no gap outside.
TriangleMesh MakeBow(const VesselWall& wall, const Bow& bow, const Grip& grip) {
  std::vector<TubePoint> points;
  for (int i = 0; i < kBowPoints; ++i) {
    const double angle_rad = std::numbers::pi * (0.5 - static_cast<double>(i) / (kBowPoints - 1));
    const double height_m = std::lerp(bow.low_m, bow.high_m, 0.5 * (1 + std::sin(angle_rad)));
    const double root_m = OuterRadius_m(wall, height_m) - 0.5 * wall.wall_m;
    const double out_m = bow.reach_m * std::cos(angle_rad);
    points.push_back({.place_xz = {root_m + out_m, height_m},
                      .half_thickness_m = Thickness(out_m) * grip.half_thickness_m,
                      .half_width_m = Thickness(out_m) * grip.half_width_m});
  }
  return MakeTube(points);
}

// A bar from the wall outwards, rising by an angle.
struct Bar {
  double root_height_m = 0;
  double length_m = 0;
  double rise_rad = 0;
};

TriangleMesh MakeBar(const VesselWall& wall, const Bar& bar, const Grip& grip) {
  const Vector2 root(OuterRadius_m(wall, bar.root_height_m) - 0.5 * wall.wall_m, bar.root_height_m);
  const Vector2 along(std::cos(bar.rise_rad), std::sin(bar.rise_rad));
  std::vector<TubePoint> points;
  for (const double way_m : {0.0, kRootLength_m, 0.5 * bar.length_m, bar.length_m}) {
    points.push_back({.place_xz = root + way_m * along,
                      .half_thickness_m = Thickness(way_m) * grip.half_thickness_m,
                      .half_width_m = Thickness(way_m) * grip.half_width_m});
  }
  return MakeTube(points);
}

// A tapering tube on the other side (towards -x), from half height to about the height of the rim.
TriangleMesh MakeSpout(const VesselWall& wall, RandomDraws& draws) {
  const double height_m = wall.outer.back().height_m;
  const double root_height_m = draws.Uniform(0.45, 0.6) * height_m;
  const double root_m = OuterRadius_m(wall, root_height_m) - 0.5 * wall.wall_m;
  const double reach_m = draws.Uniform(0.05, 0.08);
  const double rise_m = draws.Uniform(0.95, 1.1) * height_m - root_height_m;
  const double root_radius_m = draws.Uniform(0.013, 0.018);
  const double tip_radius_m = draws.Uniform(0.006, 0.009);
  std::vector<TubePoint> points;
  constexpr int kPoints = 13;
  for (int i = 0; i < kPoints; ++i) {
    const double share = static_cast<double>(i) / (kPoints - 1);
    const double out_m = reach_m * std::sin(0.5 * std::numbers::pi * share);
    const double radius_m = Thickness(out_m) * std::lerp(root_radius_m, tip_radius_m, share);
    // First straight out of the wall, then upwards.
    const Vector2 place(-root_m - out_m,
                        root_height_m + rise_m * (1 - std::cos(0.5 * std::numbers::pi * share)));
    points.push_back({.place_xz = place, .half_thickness_m = radius_m, .half_width_m = radius_m});
  }
  return MakeTube(points);
}

struct Piece {
  PieceRole role = PieceRole::kBody;
  TriangleMesh mesh;
};

SimulatedObject Assembled(std::string name, std::vector<Piece> pieces) {
  SimulatedObject object{.name = std::move(name)};
  for (Piece& piece : pieces) {
    object.parts.push_back({.shape = MakeMesh(std::move(piece.mesh))});
    object.part_roles.push_back(piece.role);
  }
  return object;
}

SimulatedObject DrawMug(RandomDraws& draws) {
  const double foot_m = draws.Uniform(0.032, 0.042);
  const double height_m = draws.Uniform(0.08, 0.11);
  const double flare_m = draws.Uniform(0, 0.008);
  const VesselWall wall{.outer = {{foot_m, 0}, {foot_m + flare_m, height_m}},
                        .wall_m = draws.Uniform(0.003, 0.005),
                        .floor_m = draws.Uniform(0.004, 0.008)};
  const Grip grip = DrawGrip(draws);
  const Bow bow{.low_m = draws.Uniform(0.15, 0.25) * height_m,
                .high_m = draws.Uniform(0.75, 0.88) * height_m,
                .reach_m = draws.Uniform(0.022, 0.040)};
  return Assembled("mug", {{PieceRole::kBody, MakeVessel(wall)},
                           {PieceRole::kHandle, MakeBow(wall, bow, grip)}});
}

SimulatedObject DrawPan(RandomDraws& draws) {
  const double foot_m = draws.Uniform(0.08, 0.12);
  const double height_m = draws.Uniform(0.04, 0.09);
  const double flare_m = draws.Uniform(0, 0.025);
  const VesselWall wall{.outer = {{foot_m, 0}, {foot_m + flare_m, height_m}},
                        .wall_m = draws.Uniform(0.002, 0.004),
                        .floor_m = draws.Uniform(0.003, 0.006)};
  const Grip grip = DrawGrip(draws);
  const Bar bar{.root_height_m = height_m - grip.half_thickness_m - draws.Uniform(0.002, 0.012),
                .length_m = draws.Uniform(0.12, 0.20),
                .rise_rad = Radians(draws.Uniform(0, 18))};
  return Assembled("pan", {{PieceRole::kBody, MakeVessel(wall)},
                           {PieceRole::kHandle, MakeBar(wall, bar, grip)}});
}

// A foot, a belly and a neck with smooth transitions.
VesselWall DrawJugWall(RandomDraws& draws) {
  const double foot_m = draws.Uniform(0.040, 0.055);
  const double belly_m = foot_m + draws.Uniform(0.005, 0.020);
  const double neck_m = foot_m - draws.Uniform(0, 0.008);
  const double height_m = draws.Uniform(0.15, 0.23);
  const auto smooth = [](double share) { return 0.5 * (1 - std::cos(std::numbers::pi * share)); };
  VesselWall wall{.outer = {}, .wall_m = draws.Uniform(0.003, 0.005), .floor_m = 0.006};
  constexpr int kPoints = 25;
  constexpr double kBelly = 0.4;  // of the height
  for (int i = 0; i < kPoints; ++i) {
    const double share = static_cast<double>(i) / (kPoints - 1);
    const double radius_m =
        share < kBelly ? std::lerp(foot_m, belly_m, smooth(share / kBelly))
                       : std::lerp(belly_m, neck_m, smooth((share - kBelly) / (1 - kBelly)));
    wall.outer.push_back({.radius_m = radius_m, .height_m = share * height_m});
  }
  return wall;
}

SimulatedObject DrawJug(RandomDraws& draws) {
  const VesselWall wall = DrawJugWall(draws);
  const double height_m = wall.outer.back().height_m;
  const Grip grip = DrawGrip(draws);
  const Bow bow{.low_m = draws.Uniform(0.2, 0.35) * height_m,
                .high_m = draws.Uniform(0.8, 0.92) * height_m,
                .reach_m = draws.Uniform(0.030, 0.055)};
  std::vector<Piece> pieces;
  pieces.push_back({PieceRole::kBody, MakeVessel(wall)});
  pieces.push_back({PieceRole::kHandle, MakeBow(wall, bow, grip)});
  pieces.push_back({PieceRole::kSpout, MakeSpout(wall, draws)});
  return Assembled("jug", std::move(pieces));
}

}  // namespace

VesselKind DrawVesselKind(RandomDraws& draws) {
  const double share = draws.Uniform();
  if (share < 0.5) return VesselKind::kMug;
  return share < 0.75 ? VesselKind::kPan : VesselKind::kJug;
}

SimulatedObject DrawVessel(VesselKind kind, RandomDraws& draws) {
  switch (kind) {
    case VesselKind::kMug:
      return DrawMug(draws);
    case VesselKind::kPan:
      return DrawPan(draws);
    case VesselKind::kJug:
      return DrawJug(draws);
  }
  return DrawMug(draws);
}

}  // namespace cwm::perception
