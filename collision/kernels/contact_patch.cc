#include "collision/kernels/contact_patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "absl/container/inlined_vector.h"
#include "collision/geometry/signed_distance.h"
#include "collision/kernels/contact_feature.h"
#include "collision/kernels/exact_geometry.h"

namespace cwm::collision {
namespace {

// Share of the smaller feature's extent within which borders still meet, although rounding has
// moved them apart.
constexpr double kBorderShare = 1e-9;
// Share of the smaller feature's extent. A corner nearer than this to a contact, or to the line of
// two contacts, is left out.
constexpr double kSameShare = 1e-6;
// Relative difference below which two values count as equal and the first is taken, so that
// rounding does not choose.
constexpr double kTieShare = 1e-9;
// Largest number of triangle pairs that are tested, at some 0.2 us each, and number of candidates
// at which inner ones are dropped.
constexpr int kMaxFacetPairs = 65'536;
constexpr std::size_t kMaxCandidates = 4'096;
// A point of a plate's piece that is deeper than this in the plate lies on a cut between pieces.
constexpr double kOnSurface_m = 1e-7;

// A point of the plane across the normal, and the heights of both surfaces over it.
struct Candidate {
  Vector2 xy;
  double of_a_m = 0, of_b_m = 0;
  double gap_m() const { return of_b_m - of_a_m; }
};
using Candidates = absl::InlinedVector<Candidate, 64>;
using PatchCorners = absl::InlinedVector<Vector2, std::size_t{2} * ContactFeature::kMaxCorners>;

double Cross(const Vector2& u, const Vector2& v) { return u.x() * v.y() - u.y() * v.x(); }

// A foremost feature in frame P, whose origin is the deepest contact and whose z axis is the
// normal.
class Foreground {
 public:
  // The surface of a half-space: the plane z = height_m.
  explicit Foreground(double height_m) : height_m_(height_m) {}

  Foreground(const ContactFeature& feature, const Pose& X_PS)
      : feature_(feature), normal_(X_PS.linear() * feature.normal) {
    for (int i = 0; i < feature.count; ++i) {
      Vector3& corner = feature_.corners[static_cast<std::size_t>(i)];
      corner = X_PS * corner;
      shadow_.push_back(corner.head<2>());
      reach_m_ = std::max(reach_m_, (shadow_.back() - shadow_.front()).norm());
    }
  }

  bool IsEndless() const { return shadow_.empty(); }
  bool IsPoint() const { return shadow_.size() == 1; }
  bool IsLine() const { return shadow_.size() == 2; }
  const PatchCorners& shadow() const { return shadow_; }
  double reach_m() const {
    return IsEndless() ? std::numeric_limits<double>::infinity() : reach_m_;
  }

  double HeightAt(const Vector2& xy) const {
    if (IsEndless()) return height_m_;
    const Vector3& p = feature_.corners[0];
    if (!IsLine()) return p.z() - normal_.head<2>().dot(xy - p.head<2>()) / normal_.z();
    const Vector3 along = feature_.corners[1] - p;
    const double share = (xy - p.head<2>()).dot(along.head<2>()) / along.head<2>().squaredNorm();
    return p.z() + share * along.z();
  }

 private:
  ContactFeature feature_;
  Vector3 normal_ = Vector3::UnitZ();
  PatchCorners shadow_;  // projection onto the plane; empty for a half-space
  double height_m_ = 0;
  double reach_m_ = 0;
};

// The part of a segment or convex polygon on the left of the line through two points (Sutherland
// and Hodgman 1974).
PatchCorners LeftOf(const Vector2& from, const Vector2& to, const PatchCorners& subject,
                    double border_m) {
  const Vector2 along = (to - from).normalized();
  PatchCorners kept;
  for (std::size_t i = 0; i < subject.size(); ++i) {
    const Vector2 &p = subject[i], &q = subject[(i + 1) % subject.size()];
    const double of_p = Cross(along, p - from), of_q = Cross(along, q - from);
    if (of_p >= -border_m) kept.push_back(p);
    if ((of_p < -border_m && of_q > border_m) || (of_p > border_m && of_q < -border_m)) {
      kept.push_back(p + (q - p) * (of_p / (of_p - of_q)));
    }
  }
  return kept;
}

PatchCorners Within(const PatchCorners& polygon, PatchCorners subject, double border_m) {
  double twice_area_m2 = 0;
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
    twice_area_m2 += Cross(polygon[i] - polygon[0], polygon[i + 1] - polygon[0]);
  }
  for (std::size_t i = 0; i < polygon.size() && !subject.empty(); ++i) {
    const Vector2 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    if ((q - p).norm() <= border_m) continue;
    subject = twice_area_m2 > 0 ? LeftOf(p, q, subject, border_m) : LeftOf(q, p, subject, border_m);
  }
  return subject;
}

// The intersection of two collinear segments; empty for others.
PatchCorners CommonLine(const PatchCorners& a, const PatchCorners& b, double border_m) {
  const Vector2 along = (a[1] - a[0]).normalized();
  const auto at = [&](const Vector2& p) { return along.dot(p - a[0]); };
  const auto off_m = [&](const Vector2& p) { return std::abs(Cross(along, p - a[0])); };
  const double begin = std::max(0.0, std::min(at(b[0]), at(b[1])));
  const double end = std::min(at(a[1]), std::max(at(b[0]), at(b[1])));
  if (begin > end || std::max(off_m(b[0]), off_m(b[1])) > border_m) return {};
  return {a[0] + begin * along, a[0] + end * along};
}

// The point if a face lies opposite to it, else empty.
PatchCorners OnFace(const Foreground& point, const Foreground& face) {
  if (face.IsEndless()) return point.shadow();
  if (face.IsPoint() || face.IsLine()) return {};
  return Within(face.shadow(), point.shadow(), kBorderShare * face.reach_m());
}

PatchCorners Common(const Foreground& a, const Foreground& b) {
  if (a.IsPoint()) return OnFace(a, b);
  if (b.IsPoint()) return OnFace(b, a);
  if (a.IsEndless()) return b.shadow();
  if (b.IsEndless()) return a.shadow();
  const Foreground& smaller = b.reach_m() < a.reach_m() ? b : a;
  const Foreground& larger = b.reach_m() < a.reach_m() ? a : b;
  const double border_m = kBorderShare * smaller.reach_m();
  if (smaller.IsLine() && larger.IsLine()) {
    return CommonLine(smaller.shadow(), larger.shadow(), kSameShare * smaller.reach_m());
  }
  if (larger.IsLine()) return Within(smaller.shadow(), larger.shadow(), border_m);
  return Within(larger.shadow(), smaller.shadow(), border_m);
}

// The index of the candidate with the largest value, the first if rounding could exchange several;
// the number of candidates if no value is above `min`.
template <class Value>
std::size_t FirstLargest(const Candidates& candidates, double min, const Value& value) {
  std::size_t best = candidates.size();
  double max = min;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const double mine = value(candidates[i]);
    if (!(mine > max)) continue;
    max = mine + kTieShare * std::abs(mine);
    best = i;
  }
  return best;
}

// The candidates that ExactContacts returns: the deepest, the farthest from it, and one to either
// side.
absl::InlinedVector<Candidate, kMaxPatchPoints> Spanning(const Candidates& candidates,
                                                         double same_m) {
  absl::InlinedVector<Candidate, kMaxPatchPoints> chosen;
  const double min_gap_m =
      std::min_element(candidates.begin(), candidates.end(),
                       [](const Candidate& s, const Candidate& t) { return s.gap_m() < t.gap_m(); })
          ->gap_m();
  const auto deepest =
      std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& candidate) {
        return candidate.gap_m() <= min_gap_m + kTieShare * same_m / kSameShare;
      });
  const Vector2 from = deepest->xy;
  chosen.push_back(*deepest);
  const std::size_t far = FirstLargest(
      candidates, same_m, [&](const Candidate& candidate) { return (candidate.xy - from).norm(); });
  if (far == candidates.size()) return chosen;
  chosen.push_back(candidates[far]);
  const Vector2 along = (candidates[far].xy - from).normalized();
  for (const double side : {1.0, -1.0}) {
    const std::size_t found = FirstLargest(candidates, same_m, [&](const Candidate& candidate) {
      return side * Cross(along, candidate.xy - from);
    });
    if (found < candidates.size()) chosen.push_back(candidates[found]);
  }
  return chosen;
}

Pose InPlaneOf(const Matrix3& R_FP, const Vector3& origin, const Pose& X_FS) {
  Pose X_PS = Pose::Identity();
  X_PS.linear() = R_FP.transpose() * X_FS.linear();
  X_PS.translation() = R_FP.transpose() * (X_FS.translation() - origin);
  return X_PS;
}

class PatchSearch {
 public:
  PatchSearch(const PlacedExact& a, const PlacedExact& b, const ContactLimits& limits,
              const PairDistance& deepest)
      : a_(a.geometry),
        b_(b.geometry),
        R_FP_(BasisFromZ(deepest.normal)),
        X_PA_(InPlaneOf(R_FP_, deepest.point_a, a.X_FS)),
        X_PB_(InPlaneOf(R_FP_, deepest.point_a, b.X_FS)),
        max_distance_m_(limits.max_distance_m),
        work_(limits.work),
        deepest_(deepest),
        mesh_reach_m_(std::min(ReachOf(a.geometry), ReachOf(b.geometry))) {}

  void AppendTo(std::vector<PairDistance>& contacts, std::size_t max_count) {
    if (HasMesh()) {
      GatherFacets();
    } else {
      GatherAll();
    }
    if (candidates_.empty()) return;
    const double same_m = kSameShare * reach_m_;
    if (HasMesh()) {  // so that the deeper of two candidates one above the other comes first
      DropInner();
      std::stable_sort(
          candidates_.begin(), candidates_.end(),
          [](const Candidate& s, const Candidate& t) { return s.gap_m() < t.gap_m(); });
    }
    auto chosen = Spanning(candidates_, same_m);
    std::stable_sort(chosen.begin(), chosen.end(),
                     [](const Candidate& s, const Candidate& t) { return s.gap_m() < t.gap_m(); });
    for (const Candidate& candidate : chosen) {
      if (contacts.size() >= max_count) return;
      if (candidate.xy.norm() > same_m)
        contacts.push_back(ContactAt(candidate));  // else the first contact
    }
  }

 private:
  static bool IsEndless(const ExactGeometry& g) { return g.kind() == ShapeKind::kHalfSpace; }
  static std::size_t PieceCount(const ExactGeometry& g) {
    return IsEndless(g) ? 1 : g.pieces().size();
  }
  // A solid and its pose in frame P.
  struct Side {
    const ExactGeometry& geometry;
    const Pose& X_PS;
    double facing;  // 1 if it faces along the normal (A), -1 against it (B)
  };

  static Foreground Foremost(const Side& side, std::size_t piece) {
    if (IsEndless(side.geometry)) return Foreground(side.X_PS.translation().z());
    const Vector3 along_S = side.facing * side.X_PS.linear().row(2).transpose();
    return {SupportFeature(side.geometry, piece, along_S), side.X_PS};
  }

  static FreeSide FreeSideOf(const ExactGeometry& mesh) {
    return mesh.IsOpen() ? FreeSide::kBoth : FreeSide::kNormalSide;
  }
  // Half the extent of a mesh, used instead of its features' extents, since single corners have
  // none.
  static double ReachOf(const ExactGeometry& g) {
    return g.tree() != nullptr ? g.tree()->nodes().front().radius_m
                               : std::numeric_limits<double>::infinity();
  }
  bool HasMesh() const { return std::isfinite(mesh_reach_m_); }

  // Calls visit(foreground, bounds) for the triangles of the side that are near a box and face the
  // other side. Both boxes are in the frame of the side. Ends as soon as visit returns false.
  template <class Visit>
  void ForEachFacet(const Side& side, const Aabb& near, const Visit& visit) {
    const Vector3 along_S = side.facing * side.X_PS.linear().row(2).transpose();
    const FreeSide free_side = FreeSideOf(side.geometry);
    // In an overlap, features lie behind the other surface by up to the depth.
    const double reach_m = std::max({max_distance_m_, -deepest_.distance_m, 0.0});
    side.geometry.tree()->ForEachNear(
        near, reach_m,
        [&](const TriangleCorners& triangle, std::int32_t) {
          Aabb bounds;
          for (const Vector3& corner : triangle.corners) bounds.extend(corner);
          if (BoxDistance_m(bounds, near) > reach_m) return reach_m;
          const auto feature = SupportFeature(triangle, free_side, along_S);
          const bool goes_on = !feature || visit(Foreground(*feature, side.X_PS), bounds);
          return goes_on ? reach_m : TriangleTree::kEnd;
        },
        work_);
  }

  void GatherFacets() {
    const Side a{a_, X_PA_, 1}, b{b_, X_PB_, -1};
    const bool a_is_outer = a_.tree() != nullptr;
    const Side &outer = a_is_outer ? a : b, &inner = a_is_outer ? b : a;
    const Pose X_IO = inner.X_PS.inverse(Eigen::Isometry) * outer.X_PS;
    int pairs = 0;
    const auto gather = [&](const Foreground& of_outer, const Foreground& of_inner) {
      a_is_outer ? Gather(of_outer, of_inner) : Gather(of_inner, of_outer);
      if (candidates_.size() >= kMaxCandidates) DropInner();
      return ++pairs < kMaxFacetPairs && !MustEndNow(kStepsPerConvexPair);
    };
    if (inner.geometry.tree() != nullptr) {
      const Aabb near = inner.geometry.tree()->bounds().transformed(X_IO.inverse(Eigen::Isometry));
      ForEachFacet(outer, near, [&](const Foreground& of_outer, const Aabb& bounds) {
        ForEachFacet(inner, bounds.transformed(X_IO), [&](const Foreground& of_inner, const Aabb&) {
          return gather(of_outer, of_inner);
        });
        return pairs < kMaxFacetPairs && !MustEndNow(1);
      });
      return;
    }
    for (std::size_t k = 0; k < PieceCount(inner.geometry) && !MustEndNow(1); ++k) {
      const Foreground of_inner = Foremost(inner, k);
      const Aabb near =
          IsEndless(inner.geometry)
              ? outer.geometry.tree()->bounds()
              : inner.geometry.piece_bounds()[k].transformed(X_IO.inverse(Eigen::Isometry));
      ForEachFacet(outer, near, [&](const Foreground& of_outer, const Aabb&) {
        return gather(of_outer, of_inner);
      });
    }
  }

  // True once the work must end; `work_` is not called again then.
  bool MustEndNow(std::size_t steps) { return has_ended_ = has_ended_ || MustEnd(work_, steps); }

  // Keeps only the candidates that are outermost in one of 32 directions, and the deepest, in their
  // order. The deepest goes last if it is not one of the outermost.
  void DropInner() {
    constexpr int kDirections = 32;
    std::array<std::size_t, kDirections + 1> kept = {};
    for (std::size_t k = 0; k < kept.size(); ++k) {
      // The offset avoids directions across borders parallel to the axes, on which every candidate
      // would be outermost.
      const double angle = 2 * std::numbers::pi * (static_cast<double>(k) + 0.37) / kDirections;
      const Vector2 out(std::cos(angle), std::sin(angle));
      const auto rank = [&](const Candidate& s) {
        return k < kDirections ? out.dot(s.xy) : -s.gap_m();
      };
      for (std::size_t i = 1; i < candidates_.size(); ++i) {
        if (rank(candidates_[i]) > rank(candidates_[kept[k]])) kept[k] = i;
      }
    }
    const auto outer_end = kept.begin() + kDirections;
    std::sort(kept.begin(), outer_end);
    const auto end = std::unique(kept.begin(), outer_end);
    Candidates rest;
    for (auto at = kept.begin(); at != end; ++at) rest.push_back(candidates_[*at]);
    if (!std::binary_search(kept.begin(), end, kept.back()))
      rest.push_back(candidates_[kept.back()]);
    candidates_ = std::move(rest);
  }

  // Features of hulls are expensive, and a hull is one piece, so the outer loop runs over the solid
  // with fewer pieces.
  void GatherAll() {
    const Side a{a_, X_PA_, 1}, b{b_, X_PB_, -1};
    const bool a_is_outer = PieceCount(a_) <= PieceCount(b_);
    const Side &outer = a_is_outer ? a : b, &inner = a_is_outer ? b : a;
    const Pose X_IO = inner.X_PS.inverse(Eigen::Isometry) * outer.X_PS;
    for (std::size_t i = 0; i < PieceCount(outer.geometry); ++i) {
      if (MustEnd(work_, PieceCount(inner.geometry))) return;
      const Foreground of_outer = Foremost(outer, i);
      for (std::size_t k = 0; k < PieceCount(inner.geometry); ++k) {
        if (!AreNear(outer.geometry, i, inner.geometry, k, X_IO)) continue;
        if (MustEnd(work_, kStepsPerConvexPair)) return;
        const Foreground of_inner = Foremost(inner, k);
        a_is_outer ? Gather(of_outer, of_inner) : Gather(of_inner, of_outer);
      }
    }
  }

  bool AreNear(const ExactGeometry& outer, std::size_t i, const ExactGeometry& inner, std::size_t k,
               const Pose& X_IO) const {
    if (IsEndless(outer) || IsEndless(inner)) return true;
    if (outer.pieces().size() == 1 && inner.pieces().size() == 1) return true;
    return BoxDistance_m(outer.piece_bounds()[i].transformed(X_IO), inner.piece_bounds()[k]) <=
           std::max(max_distance_m_, 0.0);
  }

  void Gather(const Foreground& of_a, const Foreground& of_b) {
    const double reach_m = HasMesh() ? mesh_reach_m_ : std::min(of_a.reach_m(), of_b.reach_m());
    for (const Vector2& xy : Common(of_a, of_b)) {
      Candidate candidate{xy, of_a.HeightAt(xy), of_b.HeightAt(xy)};
      // A larger overlap than the deepest contact belongs to pieces with another normal.
      const double excess_m = candidate.gap_m() - deepest_.distance_m;
      if (!(candidate.gap_m() < max_distance_m_) || excess_m < -kSameShare * reach_m) continue;
      if (!IsOnSurface(a_, X_PA_, candidate, candidate.of_a_m)) continue;
      if (!IsOnSurface(b_, X_PB_, candidate, candidate.of_b_m)) continue;
      // A distance that differs from the deepest by rounding only is made equal to it.
      if (excess_m < kBorderShare * reach_m)
        candidate.of_b_m = candidate.of_a_m + deepest_.distance_m;
      candidates_.push_back(candidate);
      reach_m_ = std::max(reach_m_, reach_m);
    }
  }

  // False if the point lies on a cut between pieces of a plate. Only the sides of pieces may be
  // cuts, not their top and bottom.
  static bool IsOnSurface(const ExactGeometry& g, const Pose& X_PS, const Candidate& candidate,
                          double z_m) {
    if (g.pieces().size() <= 1) return true;
    if (X_PS.linear().row(2).head<2>().norm() <= kMaxTilt) return true;
    const Vector3 p_P(candidate.xy.x(), candidate.xy.y(), z_m);
    return std::abs(SignedDistance_m(g.shape(), X_PS.inverse(Eigen::Isometry) * p_P)) <=
           kOnSurface_m;
  }

  PairDistance ContactAt(const Candidate& candidate) const {
    PairDistance contact = deepest_;
    contact.distance_m = std::max(candidate.gap_m(), deepest_.distance_m);
    contact.point_a =
        deepest_.point_a + R_FP_ * Vector3(candidate.xy.x(), candidate.xy.y(), candidate.of_a_m);
    contact.point_b = contact.point_a + contact.distance_m * contact.normal;
    return contact;
  }

  const ExactGeometry& a_;
  const ExactGeometry& b_;
  const Matrix3 R_FP_;
  const Pose X_PA_, X_PB_;
  const double max_distance_m_;
  WorkCounter* const work_;
  const PairDistance deepest_;
  const double mesh_reach_m_;  // half the extent of the smaller mesh; infinite without a mesh
  Candidates candidates_;
  double reach_m_ = 0;
  bool has_ended_ = false;
};

bool HasFeatures(const ExactGeometry& a, const ExactGeometry& b) {
  return a.kind() != ShapeKind::kHalfSpace || b.kind() != ShapeKind::kHalfSpace;
}

}  // namespace

void ExactContacts(const PlacedExact& a, const PlacedExact& b, const ContactLimits& limits,
                   std::vector<PairDistance>& contacts) {
  if (limits.max_count < 1) return;
  // A negative limit would end the search before the depth of an overlap is known.
  const PairDistance deepest =
      ExactDistance(a, b, std::max(0.0, limits.max_distance_m), limits.work);
  if (!(deepest.distance_m < limits.max_distance_m)) return;
  const std::size_t max_count = contacts.size() + static_cast<std::size_t>(limits.max_count);
  contacts.push_back(deepest);
  if (limits.max_count == 1 || !HasFeatures(a.geometry, b.geometry)) return;
  PatchSearch(a, b, limits, deepest).AppendTo(contacts, max_count);
}

}  // namespace cwm::collision
