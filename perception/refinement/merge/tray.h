// Trays: open-topped boxes, as cartons and crates are too, told by their walls alone: upright faces on
// the sides of a rectangle, each too thin to stand by itself.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "collision/geometry/hybrid_model.h"

namespace cwm::perception {

// Frame P is that of what it stands on: z up, z = 0 its top.

// chosen: of a wall or of a mouth, what things before it leave in sight.
inline constexpr double kMinInSight = 0.25;

// An upright face that no solid is known behind.
struct LoneWall {
  Vector2 normal = Vector2::UnitX();  // unit, towards the sensor
  std::array<Vector2, 2> ends;        // of what was seen of it
  double rim_m = 0;                   // its upper end
};

struct Tray {
  struct Side {
    bool is_seen = false;
    bool in_pieces = false;     // several of the walls are the one seen
    bool from_outside = false;  // the sensor is, so that the face's body lies within the rectangle
    double rim_m = 0;           // of what was seen of it; else the box's
  };

  Pose X_PB = Pose::Identity();  // z up, the origin on the support in the middle of the rectangle
  // Of the rectangle, between the faces that were or would be seen.
  Vector2 size_m = Vector2::Zero();
  double rim_m = 0;
  std::array<Side, 4> sides;       // at +x, -x, +y, -y
  std::vector<std::size_t> walls;  // of those that were given
  double seen_m = 0;               // the length of its walls, one for each side

  std::size_t seen_sides() const;
  // Distance of a place over the rectangle or beside it to the nearest of its four planes.
  double ToSides_m(const Vector3& p_B) const;
  bool IsOver(const Vector3& p_B) const;
};

// Where walls stand opposite each other, reach equally high, and face each other or the sensor, which is
// in sight of one's inside and the other's outside; walls between them at their ends are others of its
// sides, but no wall divides it. Those with most sides first, then those of which most was seen; each wall
// may be in several.
std::vector<Tray> FindTrays(const std::vector<LoneWall>& walls, const Vector3& sensor_P);

// The part of an object at `X_PO`, a pose of its frame, as a wall, where it is a thin and upright face.
std::optional<LoneWall> AsLoneWall(const ShapePart& part, const Pose& X_PO,
                                   const Vector3& sensor_P);

enum class Made { kNot, kSeen, kCompleted };

// The sides and the floor as boxes, in frame P: sides where measured, up to their rims and over the
// whole length; the floor from the ground to `floor_m`.
std::vector<ShapePart> PartsOf(const Tray& box, const std::array<Made, 4>& sides, double floor_m,
                               Made floor);

}  // namespace cwm::perception
