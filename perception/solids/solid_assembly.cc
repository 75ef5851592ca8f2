#include "perception/solids/solid_assembly.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "perception/cloud/tolerances.h"
#include "perception/solids/box_solid.h"
#include "perception/solids/free_space.h"
#include "perception/solids/plane_solid.h"
#include "perception/solids/round_solid.h"

namespace cwm::perception {
namespace {

// chosen: a single face explains at least this share of an object; smaller ones are bumps of a
// surface that is better meshed as a whole.
constexpr double kMinLoneShare = 0.08;

}  // namespace

bool IsCrossed(const Solid& solid, const FitContext& context) {
  context.work.Poll();
  if (!context.options.from_viewpoint) return false;
  const Contradiction found = FindContradiction(solid, context.points);
  // The limit is relative to the solid's own points, so that a small solid in a large object counts
  // too.
  const double own = static_cast<double>(solid.inliers.size()) /
                     static_cast<double>(context.points.size()) *
                     static_cast<double>(found.examined);
  // chosen: three rays more than the share allows.
  if (static_cast<double>(found.rays) > kMaxPassing * own + 3) return true;
  const double measured = static_cast<double>(solid.inliers.size()) * context.points.weight;
  return IsPassedThrough(solid, measured, context.free);
}

namespace {

struct SingleFace {
  ShapeFit fit;
  Solid solid;

  bool is_thin() const {
    return std::holds_alternative<Plate>(solid.shape) || IsLoneFace(solid.shape);
  }
};

void AppendSingle(const ShapeFit& fit, const FitContext& c, const Ground& ground,
                  std::vector<SingleFace>& faces) {
  std::optional<Solid> solid = MakePlaneSolid(fit, c, ground);
  if (solid && !IsCrossed(*solid, c)) faces.push_back({fit, *std::move(solid)});
}

// The points of a face that lie on no other face whose depth is known.
std::vector<std::uint32_t> OwnOf(const SingleFace& face, const std::vector<SingleFace>& faces,
                                 const ModelPoints& points) {
  std::vector<std::uint32_t> own;
  for (std::uint32_t i : face.fit.inliers) {
    const bool is_shared = std::ranges::any_of(faces, [&](const SingleFace& other) {
      if (other.is_thin()) return false;
      const Vector3 p_S = other.solid.X_MS.inverse(Eigen::Isometry) * points.p[i];
      return std::abs(SignedDistance_m(other.solid, p_S)) <= ExplainedWithin_m(points.sigma_m[i]);
    });
    if (!is_shared) own.push_back(i);
  }
  return own;
}

// Objects in a row may share one front face but not their tops. Once the top of an object has given
// its depth, points on its side are no face of their own, and the rest of the shared face belongs
// to the other objects.
std::vector<SingleFace> LeaveSidesToOthers(std::vector<SingleFace> faces, const FitContext& c,
                                           const Ground& ground) {
  std::vector<SingleFace> out;
  // The depth of each of a box's two faces may come from the other one; then the larger part of one
  // lies on the other.
  for (const SingleFace& face : faces) {
    const double own = static_cast<double>(OwnOf(face, out, c.points).size());
    const double all = static_cast<double>(face.fit.inliers.size());
    if (!face.is_thin() && own >= kMajority * all) out.push_back(face);
  }
  for (const SingleFace& face : faces) {
    if (!face.is_thin()) continue;
    std::vector<std::uint32_t> own = OwnOf(face, out, c.points);
    const auto all = static_cast<double>(face.fit.inliers.size());
    // Faces of other objects share no more points with this one than their edges hold.
    if (static_cast<double>(own.size()) >= kNearlyAll * all) {
      out.push_back(face);
      continue;
    }
    ShapeFit rest = face.fit;
    for (std::size_t k = 0; k < kMaxParts; ++k) {
      rest.inliers = rest.covered = c.connectivity.LargestComponent(own);
      const double measured = static_cast<double>(rest.inliers.size()) * c.points.weight;
      if (measured < c.options.min_inliers) break;
      AppendSingle(rest, c, ground, out);
      std::vector<std::uint32_t> others;
      std::ranges::set_difference(own, rest.inliers, std::back_inserter(others));
      own = std::move(others);
    }
  }
  return out;
}

}  // namespace

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
  std::vector<SingleFace> singles;
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
        singles.push_back({fits[k], *std::move(solid)});
      }
    }
  }
  for (std::size_t k = 0; k < fits.size(); ++k) {
    if (used[k] || !IsPlane(fits[k].model)) continue;
    const bool is_small = static_cast<double>(fits[k].inliers.size()) <
                          kMinLoneShare * static_cast<double>(context.points.size());
    AppendSingle(fits[k], context, ground, singles);
    if (is_small && !singles.empty() && singles.back().fit.inliers == fits[k].inliers &&
        singles.back().is_thin()) {
      singles.pop_back();
    }
  }
  for (SingleFace& face : LeaveSidesToOthers(std::move(singles), context, ground)) {
    out.solids.push_back(std::move(face.solid));
  }
  return out;
}

}  // namespace cwm::perception
