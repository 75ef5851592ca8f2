#include "perception/track/ray_judgement.h"

namespace cwm::perception {
namespace {

// Fewer informed samples than these, of some hundred, are chance: the object is out of view.
constexpr int kFewestInformed = 8;
constexpr double kSmallestInformedShare = 0.05;
// An object of which less is visible could be anything: it is hidden.
constexpr double kSmallestVisibleShare = 0.15;
// Rays pass through most of what is visible: there is nothing. Half would be a coin's toss between
// a removed object, of which some samples lie near what is behind it, and an object of which some
// supplied surface was never there.
constexpr double kGoneShare = 0.6;

}  // namespace

Association::What JudgeByRays(const SightCounts& sights) {
  const double all = sights.informed() + sights.unknown;
  const double informed = sights.informed();
  if (informed < kFewestInformed || informed < kSmallestInformedShare * all) {
    return Association::What::kKeep;
  }
  if (sights.visible() < kSmallestVisibleShare * informed) return Association::What::kOcclude;
  if (sights.ThroughShare() > kGoneShare) return Association::What::kRemove;
  return Association::What::kKeep;
}

}  // namespace cwm::perception
