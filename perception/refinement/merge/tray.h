// Trays: open-topped boxes, including cartons and crates, found by their walls only: upright faces
// on the sides of a rectangle, each too thin to stand by itself.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "collision/geometry/hybrid_model.h"

namespace cwm::perception {

// Frame P is that of the support: z up, z = 0 its top.

// chosen: the least visible share of a wall or a mouth with objects before it.
inline constexpr double kMinInSight = 0.25;

// An upright face without a known solid behind it: the shape is at most 10 mm thick.
struct LoneWall {
  Vector2 normal = Vector2::UnitX();  // unit, towards the sensor
  std::array<Vector2, 2> ends;        // of its visible part
  double rim_m = 0;                   // its upper end
};

struct Tray {
  struct Side {
    bool is_seen = false;
    bool in_pieces = false;     // several of the given walls make up this side
    bool from_outside = false;  // the sensor sees its outside: its body lies within the rectangle
    double rim_m = 0;           // of its visible part; else the box's
  };

  Pose X_PB = Pose::Identity();  // z up, the origin on the support in the middle of the rectangle
  // Size of the rectangle between the visible faces.
  Vector2 size_m = Vector2::Zero();
  double rim_m = 0;
  std::array<Side, 4> sides;       // at +x, -x, +y, -y
  std::vector<std::size_t> walls;  // indices of given walls
  double seen_m = 0;               // total length of its walls, one per side

  std::size_t seen_sides() const;
  // Horizontal distance of a place from the rectangle's border, in metres: inside, from the nearest
  // side; outside, from the rectangle. Never negative.
  double ToSides_m(const Vector3& p_B) const;
  bool IsOver(const Vector3& p_B) const;
};

// Finds pairs of opposite walls of equal height that face each other, or that both face the sensor,
// which then sees the inside of one and the outside of the other. Walls between their ends are the
// other sides; no wall divides the rectangle. Sorted by the number of sides, then by visible
// length. A wall may be in several trays.
std::vector<Tray> FindTrays(const std::vector<LoneWall>& walls, const Vector3& sensor_P);

// The part of an object at `X_PO`, the pose of its frame, as a wall; empty unless it is a thin,
// upright face.
std::optional<LoneWall> AsLoneWall(const ShapePart& part, const Pose& X_PO,
                                   const Vector3& sensor_P);

enum class PartOrigin { kNone, kMeasured, kCompleted };

// The sides and the floor as boxes, in frame P, except those of PartOrigin::kNone. Seen faces are
// where they were measured. Sides reach up to their rims and over the whole length, the floor from
// the ground to `floor_m`.
std::vector<ShapePart> PartsOf(const Tray& box, const std::array<PartOrigin, 4>& sides,
                               double floor_m, PartOrigin floor);

}  // namespace cwm::perception
