#include "perception/model/solid_assembly.h"

#include "perception/model/box_solid.h"
#include "perception/model/free_space.h"
#include "perception/model/plane_solid.h"
#include "perception/model/round_solid.h"

namespace cwm::perception {
namespace {

// Rays that cross a solid: more than mixed pixels and a few outliers explain.
constexpr double kCrossedShare = 0.05;
// A lone face explains at least this share of an object; smaller ones are bumps of a surface that
// is better meshed as a whole.
constexpr double kLeastLoneShare = 0.08;

}  // namespace

bool IsCrossed(const Solid& solid, const FitContext& context) {
  context.work.Poll();
  const Contradiction found = FindContradiction(solid, context.points);
  // In proportion to the solid's own points: a small one in a large object counts too.
  const double own = static_cast<double>(solid.inliers.size()) /
                     static_cast<double>(context.points.size()) * static_cast<double>(found.looked);
  if (static_cast<double>(found.rays) > kCrossedShare * own + 3) return true;
  const double measured = static_cast<double>(solid.inliers.size()) * context.points.weight;
  return IsPassedThrough(solid, measured, context.free);
}

Assembly AssembleSolids(const Extraction& extraction, const FitContext& context,
                        const Ground& ground) {
  const std::vector<ShapeFit>& fits = extraction.fits;
  Assembly out{{}, extraction.notes};
  std::vector<char> used(fits.size(), 0);
  for (std::size_t k = 0; k < fits.size(); ++k) {
    if (IsPlane(fits[k].model)) continue;
    context.work.Poll();
    std::vector<char> with_caps = used;
    std::optional<Solid> solid = MakeRoundSolid(fits[k], fits, context, ground, with_caps);
    if (!solid) continue;
    if (IsCrossed(*solid, context)) {
      out.notes.emplace_back(kSeenFromBothSides);
      continue;
    }
    used = with_caps;
    used[k] = 1;
    out.solids.push_back(*std::move(solid));
  }
  while (const std::optional<BoxFaces> faces = FindBoxFaces(fits, used, context)) {
    for (std::size_t k : *faces) used[k] = 1;
    Solid box = MakeBox(*faces, fits, context, ground);
    if (!IsCrossed(box, context)) {
      out.solids.push_back(std::move(box));
      continue;
    }
    out.notes.push_back("faces of a box that rays run through: kept as single faces");
    for (std::size_t k : *faces) {
      if (std::optional<Solid> solid = MakePlaneSolid(fits[k], context, ground)) {
        out.solids.push_back(*std::move(solid));
      }
    }
  }
  for (std::size_t k = 0; k < fits.size(); ++k) {
    if (used[k] || !IsPlane(fits[k].model)) continue;
    if (static_cast<double>(fits[k].inliers.size()) <
        kLeastLoneShare * static_cast<double>(context.points.size())) {
      continue;
    }
    std::optional<Solid> solid = MakePlaneSolid(fits[k], context, ground);
    if (solid && !IsCrossed(*solid, context)) out.solids.push_back(*std::move(solid));
  }
  return out;
}

}  // namespace cwm::perception
