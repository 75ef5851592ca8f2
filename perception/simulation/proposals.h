// Proposes random places for objects and tests them by the rules of an arrangement. All functions
// return empty if the drawn place is not allowed; try again.
#pragma once

#include <optional>
#include <vector>

#include "perception/simulation/arrangement.h"
#include "perception/simulation/placement.h"
#include "perception/simulation/random_draws.h"

namespace cwm::perception {

// The placed object, and the hidden shares with it in the scene.
struct Placement {
  SimulatedObject object;
  std::vector<double> hidden_shares;  // of all objects after the furniture, this one last
};

// The object is placed evenly over a disc.
struct Disc {
  Vector2 middle_W = Vector2::Zero();
  double radius_m = 0;
};
std::optional<Placement> ProposeWithin(const Disc& disc, const Arrangement& arrangement,
                                       const RestingArea& area, const SimulatedObject& object,
                                       RandomDraws& draws);

// The object touches one of the objects that can hold it.
std::optional<Placement> ProposeLeaning(const Arrangement& arrangement, const RestingArea& area,
                                        const SimulatedObject& object, RandomDraws& draws);

// The object is beside one of the objects after the furniture: touching it half of the time, else
// up to 40 mm away.
std::optional<Placement> ProposeBeside(const Arrangement& arrangement, const RestingArea& area,
                                       const SimulatedObject& object, RandomDraws& draws);

// The object touches the given object of the scene.
std::optional<Placement> ProposeTouching(std::size_t neighbour, const Arrangement& arrangement,
                                         const RestingArea& area, const SimulatedObject& object,
                                         RandomDraws& draws);

// Adds the object; its name gets a number that no other object has.
void AddNumbered(Placement proposal, Arrangement& arrangement);

}  // namespace cwm::perception
