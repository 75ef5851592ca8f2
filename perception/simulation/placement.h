// Places for an object on a table. The object is z up, with z = 0 on its support, and X_WO is still
// the identity.
#pragma once

#include <optional>

#include "perception/simulation/random_draws.h"
#include "perception/simulation/simulated_scene.h"

namespace cwm::perception {

// A level rectangle that objects are put on.
struct RestingArea {
  Eigen::AlignedBox2d area_W;
  double top_m = 0;
};

struct PlanarPose {
  Vector2 place_W = Vector2::Zero();
  double yaw_rad = 0;
};

// Evenly over a disc, with any yaw.
PlanarPose DrawPlanarPose(const Vector2& middle_W, double radius_m, RandomDraws& draws);

// The object rotated and put down; empty if it would extend beyond the area's edge.
std::optional<SimulatedObject> PlaceOnArea(SimulatedObject object, const RestingArea& area,
                                           const PlanarPose& pose);

// The side from which an object is pushed against its neighbour: the direction from the neighbour's
// middle to the object, about z, and the object's yaw.
struct Side {
  double direction_rad = 0;
  double yaw_rad = 0;
};

// Any side, with any yaw.
Side DrawSide(RandomDraws& draws);

// A side from which a leaning object is held: its x axis points to the neighbour and, if that is a
// box, is square to one of its faces.
Side DrawLeaningSide(const SimulatedObject& neighbour, RandomDraws& draws);

// The object pushed along the area until it touches the neighbour. Empty if it misses it or would
// extend beyond the edge.
std::optional<SimulatedObject> PushAgainst(SimulatedObject object, const RestingArea& area,
                                           const SimulatedObject& neighbour, const Side& side);

// True if the neighbour can hold the leaning object: it stands upright, is not a sphere, and
// reaches at least up to the middle of the object.
bool CanHold(const SimulatedObject& neighbour, const SimulatedObject& object);

}  // namespace cwm::perception
