#include "perception/fit/extraction.h"

#include <cmath>

#include "perception/fit/disc_wall.h"
#include "perception/fit/model_selection.h"
#include "perception/search/candidate_list.h"
#include "perception/search/shape_search.h"

namespace cwm::perception {
namespace {

// chosen: bounds the work for shapes and for rejected candidates, which cost as much. A cluttered
// table of a dozen boxes has 36 faces.
constexpr int kMaxShapes = 64, kMaxRejections = 48;
// measured: successive rejections that end the search. In 45 real scans and 112 simulated ones no
// shape was found after more than 12; an object without shapes has one rejected candidate after
// another.
constexpr int kMaxConsecutiveRejections = 13;
// chosen: a third of them at reduced effort; a thousand simulated balls then cost a quarter less.
constexpr int kMaxRejectionsAtReducedEffort = kMaxConsecutiveRejections / 3;

std::vector<std::uint32_t> OnAndBeside(const ShapeFit& fit, const FitContext& c,
                                       const std::vector<char>& available) {
  std::vector<std::uint32_t> taken = fit.inliers;
  for (std::uint32_t i : c.connectivity.Beside(fit.inliers)) {
    if (available[i] && std::abs(Distance_m(fit.model, c.points.p[i])) <= c.points.gate_m[i]) {
      taken.push_back(i);
    }
  }
  return taken;
}

}  // namespace

Extraction ExtractShapes(const FitContext& context) {
  const int max_in_row =
      context.options.reduced_effort ? kMaxRejectionsAtReducedEffort : kMaxConsecutiveRejections;
  Extraction out;
  CandidateList candidates(context.points, context.connectivity, context.options.seed,
                           context.work);
  ShapeSearch search(context.points, context.octree, candidates, context.options, context.work);
  const auto take = [&](ShapeFit fit) {
    fit.covered = OnAndBeside(fit, context, candidates.available());
    candidates.Remove(fit.covered);
    out.fits.push_back(std::move(fit));
  };
  int rejections = 0, in_row = 0;
  while (true) {
    const std::optional<Candidate> leader = search.Next();
    if (!leader) break;
    if (std::optional<ShapeFit> fit = SelectModel(*leader, candidates, context)) {
      in_row = 0;
      take(*std::move(fit));
      if (auto wall = FindWallBehindDisc(out.fits.back(), context, candidates.available())) {
        take(*std::move(wall));
      }
    } else {
      candidates.Reject(*leader);
      ++rejections;
      ++in_row;
    }
    if (static_cast<int>(out.fits.size()) < kMaxShapes && rejections < kMaxRejections &&
        in_row < max_in_row) {
      continue;
    }
    out.notes.push_back("shape search ended at its cap of shapes; the rest becomes surfaces");
    break;
  }
  if (search.is_exhausted()) {
    out.notes.push_back("shape search ended at its cap of draws; small shapes may be missed");
  }
  return out;
}

}  // namespace cwm::perception
