#include "perception/track/ray_classification.h"

namespace cwm::perception {
namespace {

// chosen: the least share of informed samples; an object with less, or with fewer than
// kMinInformed, is out of view.
constexpr double kMinInformedShare = 0.05;
// chosen: the share of visible samples that rays pass through if the object is gone. Half would not
// separate a removed object, of which some samples lie near the surface behind it, from an object
// with completed surface that never existed.
constexpr double kRemovedShare = 0.6;

}  // namespace

Association::Outcome ClassifyByRays(const SightCounts& sights) {
  const double all = sights.informed() + sights.unknown;
  const double informed = sights.informed();
  if (informed < kMinInformed || informed < kMinInformedShare * all) {
    return Association::Outcome::kKeep;
  }
  if (sights.visible() < kMinVisibleShare * informed) return Association::Outcome::kOcclude;
  if (sights.ThroughShare() > kRemovedShare) return Association::Outcome::kRemove;
  return Association::Outcome::kKeep;
}

}  // namespace cwm::perception
