// Places for things, proposed at random and judged by the rules of an arrangement. All return
// nothing when the place drawn is not allowed: try again.
#pragma once

#include <optional>
#include <vector>

#include "perception/simulation/arrangement.h"
#include "perception/simulation/placement.h"
#include "perception/simulation/random_draws.h"

namespace cwm::perception {

// A thing as PutDown takes it, and as it would stand in the scene.
struct Placement {
  SimulatedObject object;
  std::vector<double> hidden_shares;  // of all objects after the furniture, this one last
};

// Evenly over a disc.
struct Disc {
  Vector2 middle_W = Vector2::Zero();
  double radius_m = 0;
};
std::optional<Placement> ProposeWithin(const Disc& disc, const Arrangement& arrangement,
                                       const RestingArea& area, const SimulatedObject& thing,
                                       RandomDraws& draws);

// Held by one of the objects that can hold it, touching it.
std::optional<Placement> ProposeLeaning(const Arrangement& arrangement, const RestingArea& area,
                                        const SimulatedObject& thing, RandomDraws& draws);

// Beside one of the objects after the furniture: touching it half of the time, else up to 40 mm
// away.
std::optional<Placement> ProposeBeside(const Arrangement& arrangement, const RestingArea& area,
                                       const SimulatedObject& thing, RandomDraws& draws);

// Touching that object of the scene.
std::optional<Placement> ProposeTouching(std::size_t neighbour, const Arrangement& arrangement,
                                         const RestingArea& area, const SimulatedObject& thing,
                                         RandomDraws& draws);

// Adds the object under its name and a number that no other object has.
void AddNumbered(Placement proposal, Arrangement& arrangement);

}  // namespace cwm::perception
