#include "perception/solids/solid_assembly.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "perception/cloud/tolerances.h"
#include "perception/solids/box_solid.h"
#include "perception/solids/free_space.h"
#include "perception/solids/observed.h"
#include "perception/solids/plane_solid.h"
#include "perception/solids/round_solid.h"

namespace cwm::perception {
namespace {

// chosen: a single face explains at least this share of an object; smaller ones are bumps of a
// surface that is better meshed as a whole.
constexpr double kMinLoneShare = 0.08;

// The constants below judge solids without rays, which would tell whether they are filled.
// chosen: the least share of its surface that points show.
constexpr double kMinObserved = 0.4;
// chosen: the least share of the top of a box. Sensors look down on things: a box whose sides they
// saw, but not its top, has none.
constexpr double kMinTopObserved = 0.5;
// chosen: deeper points are inside. The walls of bins and shelves are thinner.
constexpr double kInside_m = 0.02;

// The share of the box's top that points show.
double ObservedTop(const Box& box, const Vector3& up_S, std::span<const Eigen::Vector3f> on_S,
                   double cell_m) {
  Eigen::Index axis = 2;
  up_S.cwiseAbs().maxCoeff(&axis);
  const Eigen::Index across = (axis + 1) % 3, beside = (axis + 2) % 3;
  const double top_m = 0.5 * box.size_m[axis], sign = up_S[axis] > 0 ? 1 : -1;
  std::set<std::pair<long, long>> cells;
  for (const Eigen::Vector3f& p : on_S) {
    if (std::abs(sign * double{p[axis]} - top_m) > cell_m) continue;
    cells.emplace(std::lround(p[across] / cell_m), std::lround(p[beside] / cell_m));
  }
  const double area_m2 = box.size_m[across] * box.size_m[beside];
  return static_cast<double>(cells.size()) * cell_m * cell_m / std::max(area_m2, cell_m * cell_m);
}

// True if too little of the surface was seen to call its inside filled, or if there are points in
// it.
bool IsUnproven(const Solid& solid, const FitContext& c) {
  if (IsLoneFace(solid.shape) || std::holds_alternative<Plate>(solid.shape)) return false;
  const ModelPoints& points = c.points;
  const Pose X_SM = solid.X_MS.inverse(Eigen::Isometry);
  std::vector<Eigen::Vector3f> on_S;
  std::size_t inside = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3 p_S = X_SM * points.p[i];
    const double distance_m = SignedDistance_m(solid, p_S);
    if (std::abs(distance_m) <= points.gate_m[i]) on_S.push_back(p_S.cast<float>());
    inside += distance_m < -std::max(kInside_m, points.gate_m[i]);
  }
  if (static_cast<double>(inside) > kMaxPassing * static_cast<double>(on_S.size())) return true;
  const double cell_m = CoverCell_m(points.spacing_m);
  const auto* box = std::get_if<Box>(&solid.shape);
  if (box != nullptr && c.ground.known) {
    const Vector3 up_S = X_SM.linear() * c.ground.up;
    const bool stands = up_S.cwiseAbs().maxCoeff() > std::cos(kSameDirection_rad);
    if (stands && ObservedTop(*box, up_S, on_S, cell_m) < kMinTopObserved) return true;
  }
  return ObservedFraction(solid.shape, on_S, cell_m) < kMinObserved;
}

}  // namespace

bool IsCrossed(const Solid& solid, const FitContext& context) {
  context.work.Poll();
  if (!context.options.from_viewpoint) return IsUnproven(solid, context);
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
