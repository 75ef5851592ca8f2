// Where a thing may go on a table. A thing is an object that is z up, with its support at z = 0 and
// X_WO still identity.
#pragma once

#include <optional>

#include "perception/simulation/random_draws.h"
#include "perception/simulation/simulated_scene.h"

namespace cwm::perception {

// A level rectangle that carries objects.
struct RestingArea {
  Eigen::AlignedBox2d area_W;
  double top_m = 0;
};

struct Spot {
  Vector2 place_W = Vector2::Zero();
  double yaw_rad = 0;
};

// Evenly over a disc; any yaw.
Spot DrawSpot(const Vector2& middle_W, double radius_m, RandomDraws& draws);

// The thing turned and put down; nothing where it would stand out over the area's edge.
std::optional<SimulatedObject> PutDown(SimulatedObject thing, const RestingArea& area,
                                       const Spot& spot);

// The side from which a thing is pushed against its neighbour: the direction from the neighbour's
// middle to the thing, about z, and the yaw of the thing.
struct Side {
  double direction_rad = 0;
  double yaw_rad = 0;
};

// Any side; any yaw.
Side DrawSide(RandomDraws& draws);

// A side from which a leaning thing is held: its x axis towards the neighbour and, where that is a
// box, square to one of its faces.
Side DrawLeaningSide(const SimulatedObject& neighbour, RandomDraws& draws);

// The thing pushed along the area until it touches the neighbour. Nothing where it misses or would
// stand out over the edge.
std::optional<SimulatedObject> PushAgainst(SimulatedObject thing, const RestingArea& area,
                                           const SimulatedObject& neighbour, const Side& side);

// Whether the neighbour holds the leaning thing: it stands upright, is no ball, and reaches up to
// the middle of the thing at least.
bool Holds(const SimulatedObject& neighbour, const SimulatedObject& thing);

}  // namespace cwm::perception
