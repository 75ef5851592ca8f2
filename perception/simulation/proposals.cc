#include "perception/simulation/proposals.h"

#include <cmath>
#include <string>
#include <utility>

namespace cwm::perception {
namespace {

std::optional<Placement> Judged(const Arrangement& arrangement,
                                std::optional<SimulatedObject> object, Touching touching) {
  if (!object) return std::nullopt;
  auto shares = arrangement.HiddenSharesWith(*object, touching);
  if (!shares) return std::nullopt;
  return Placement{.object = *std::move(object), .hidden_shares = *std::move(shares)};
}

std::size_t Below(std::size_t count, RandomDraws& draws) {
  return static_cast<std::size_t>(draws.Below(static_cast<int>(count)));
}

}  // namespace

std::optional<Placement> ProposeWithin(const Disc& disc, const Arrangement& arrangement,
                                       const RestingArea& area, const SimulatedObject& object,
                                       RandomDraws& draws) {
  const PlanarPose pose = DrawPlanarPose(disc.middle_W, disc.radius_m, draws);
  return Judged(arrangement, PlaceOnArea(object, area, pose), std::nullopt);
}

std::optional<Placement> ProposeLeaning(const Arrangement& arrangement, const RestingArea& area,
                                        const SimulatedObject& object, RandomDraws& draws) {
  const std::size_t index = Below(arrangement.scene().objects.size(), draws);
  const SimulatedObject& neighbour = arrangement.object(index);
  if (!CanHold(neighbour, object)) return std::nullopt;
  const Side side = DrawLeaningSide(neighbour, draws);
  return Judged(arrangement, PushAgainst(object, area, neighbour, side), index);
}

std::optional<Placement> ProposeBeside(const Arrangement& arrangement, const RestingArea& area,
                                       const SimulatedObject& object, RandomDraws& draws) {
  const std::size_t first = arrangement.furniture_count();
  const std::size_t count = arrangement.scene().objects.size() - first;
  if (count == 0) return std::nullopt;
  const std::size_t index = first + Below(count, draws);
  const Side side = DrawSide(draws);
  const double back_m = draws.Uniform(-0.04, 0.04);
  auto pushed = PushAgainst(object, area, arrangement.object(index), side);
  if (!pushed || back_m <= 0) return Judged(arrangement, std::move(pushed), index);
  pushed->X_WO.pretranslate(
      Vector3(back_m * std::cos(side.direction_rad), back_m * std::sin(side.direction_rad), 0));
  return Judged(arrangement, std::move(pushed), std::nullopt);
}

std::optional<Placement> ProposeTouching(std::size_t neighbour, const Arrangement& arrangement,
                                         const RestingArea& area, const SimulatedObject& object,
                                         RandomDraws& draws) {
  const Side side = DrawSide(draws);
  return Judged(arrangement, PushAgainst(object, area, arrangement.object(neighbour), side),
                neighbour);
}

void AddNumbered(Placement proposal, Arrangement& arrangement) {
  const std::size_t number = arrangement.scene().objects.size() + 1 - arrangement.furniture_count();
  proposal.object.name += "_" + std::to_string(number);
  arrangement.Add(std::move(proposal.object));
}

}  // namespace cwm::perception
