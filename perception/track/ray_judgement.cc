#include "perception/track/ray_judgement.h"

namespace cwm::perception {
namespace {

// chosen: where less of an object's samples is informed, as where kMinInformed are not, the object
// is out of view.
constexpr double kMinInformedShare = 0.05;
// chosen: an object of which less is visible could be anything: it is hidden.
constexpr double kMinVisibleShare = 0.15;
// chosen: rays pass through most of what is visible: there is nothing. Half would be a coin's toss
// between a removed object, of which some samples lie near what is behind it, and an object of
// which some supplied surface was never there.
constexpr double kGoneShare = 0.6;

}  // namespace

Association::What JudgeByRays(const SightCounts& sights) {
  const double all = sights.informed() + sights.unknown;
  const double informed = sights.informed();
  if (informed < kMinInformed || informed < kMinInformedShare * all) {
    return Association::What::kKeep;
  }
  if (sights.visible() < kMinVisibleShare * informed) return Association::What::kOcclude;
  if (sights.ThroughShare() > kGoneShare) return Association::What::kRemove;
  return Association::What::kKeep;
}

}  // namespace cwm::perception
