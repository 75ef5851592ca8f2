#include "collision/kernels/contact_patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "absl/container/inlined_vector.h"
#include "collision/geometry/signed_distance.h"
#include "collision/kernels/contact_feature.h"
#include "collision/kernels/exact_geometry.h"

namespace cwm::collision {
namespace {

// Shares of how far the smaller feature reaches. Borders that rounding has put apart still meet:
constexpr double kBorderShare = 1e-9;
// and what lies nearer than this to a contact, or to the line of two, adds nothing to them.
constexpr double kSameShare = 1e-6;
// Of two numbers that differ by less, rounding must not choose: the first is taken.
constexpr double kTieShare = 1e-9;
// A point of a plate's piece that is deeper in the plate is on a cut between pieces.
constexpr double kOnSurface_m = 1e-7;

// A place on the plane across the normal, and how high the two surfaces are over it.
struct Spot {
  Vector2 xy;
  double of_a_m = 0, of_b_m = 0;
  double gap_m() const { return of_b_m - of_a_m; }
};
using Spots = absl::InlinedVector<Spot, 64>;
using Corners = absl::InlinedVector<Vector2, std::size_t{2} * ContactFeature::kMostCorners>;

double Cross(const Vector2& u, const Vector2& v) { return u.x() * v.y() - u.y() * v.x(); }

// A foremost feature in frame P: its origin is the deepest contact, its z the normal.
class Foreground {
 public:
  // Of a half-space: the plane z = height_m.
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
  const Corners& shadow() const { return shadow_; }
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
  Corners shadow_;  // none: endless
  double height_m_ = 0;
  double reach_m_ = 0;
};

// What of a line or convex polygon lies on the left of one through two points (Sutherland and
// Hodgman 1974).
Corners LeftOf(const Vector2& from, const Vector2& to, const Corners& subject, double border_m) {
  const Vector2 along = (to - from).normalized();
  Corners kept;
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

Corners Within(const Corners& polygon, Corners subject, double border_m) {
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

// What two lines have in common that lie on each other; of others, one place at most.
Corners CommonLine(const Corners& a, const Corners& b, double border_m) {
  const Vector2 along = (a[1] - a[0]).normalized();
  const auto at = [&](const Vector2& p) { return along.dot(p - a[0]); };
  const auto off_m = [&](const Vector2& p) { return std::abs(Cross(along, p - a[0])); };
  const double begin = std::max(0.0, std::min(at(b[0]), at(b[1])));
  const double end = std::min(at(a[1]), std::max(at(b[0]), at(b[1])));
  if (begin > end || std::max(off_m(b[0]), off_m(b[1])) > border_m) return {};
  return {a[0] + begin * along, a[0] + end * along};
}

Corners Common(const Foreground& a, const Foreground& b) {
  if (a.IsPoint() || b.IsPoint()) return {};
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

// The index with the largest value, the first of those that a rounding could exchange; the count of
// `spots` where none is above `least`.
template <class Value>
std::size_t FirstLargest(const Spots& spots, double least, const Value& value) {
  std::size_t best = spots.size();
  double most = least;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const double mine = value(spots[i]);
    if (!(mine > most)) continue;
    most = mine + kTieShare * std::abs(mine);
    best = i;
  }
  return best;
}

// As the header says: the deepest, the farthest from it, and one to either side.
absl::InlinedVector<Spot, kMostPatchPoints> Spanning(const Spots& spots, double same_m) {
  absl::InlinedVector<Spot, kMostPatchPoints> chosen;
  const double least =
      std::min_element(spots.begin(), spots.end(), [](const Spot& s, const Spot& t) {
        return s.gap_m() < t.gap_m();
      })->gap_m();
  const auto deepest = std::find_if(spots.begin(), spots.end(), [&](const Spot& spot) {
    return spot.gap_m() <= least + kTieShare * same_m / kSameShare;
  });
  const Vector2 from = deepest->xy;
  chosen.push_back(*deepest);
  const std::size_t far =
      FirstLargest(spots, same_m, [&](const Spot& spot) { return (spot.xy - from).norm(); });
  if (far == spots.size()) return chosen;
  chosen.push_back(spots[far]);
  const Vector2 along = (spots[far].xy - from).normalized();
  for (const double side : {1.0, -1.0}) {
    const std::size_t found = FirstLargest(
        spots, same_m, [&](const Spot& spot) { return side * Cross(along, spot.xy - from); });
    if (found < spots.size()) chosen.push_back(spots[found]);
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
        deepest_(deepest) {}

  void AppendTo(std::vector<PairDistance>& contacts, std::size_t most) {
    GatherAll();
    if (spots_.empty()) return;
    const double same_m = kSameShare * reach_m_;
    auto chosen = Spanning(spots_, same_m);
    std::stable_sort(chosen.begin(), chosen.end(),
                     [](const Spot& s, const Spot& t) { return s.gap_m() < t.gap_m(); });
    for (const Spot& spot : chosen) {
      if (contacts.size() >= most) return;
      if (spot.xy.norm() > same_m) contacts.push_back(ContactAt(spot));  // else the first one
    }
  }

 private:
  static bool IsEndless(const ExactGeometry& g) { return g.kind() == ShapeKind::kHalfSpace; }
  static std::size_t PieceCount(const ExactGeometry& g) {
    return IsEndless(g) ? 1 : g.pieces().size();
  }
  // A solid and where it is.
  struct Side {
    const ExactGeometry& geometry;
    const Pose& X_PS;
    double facing;  // along the normal
  };

  static Foreground Foremost(const Side& side, std::size_t piece) {
    if (IsEndless(side.geometry)) return Foreground(side.X_PS.translation().z());
    const Vector3 along_S = side.facing * side.X_PS.linear().row(2).transpose();
    return {ForemostFeature(side.geometry, piece, along_S), side.X_PS};
  }

  // Features of hulls are dear, and a hull is one piece: the solid of fewer pieces is looked at once.
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
        if (MustEnd(work_, kStepsOfConvexPair)) return;
        const Foreground of_inner = Foremost(inner, k);
        a_is_outer ? Gather(of_outer, of_inner) : Gather(of_inner, of_outer);
      }
    }
  }

  bool AreNear(const ExactGeometry& outer, std::size_t i, const ExactGeometry& inner, std::size_t k,
               const Pose& X_IO) const {
    if (IsEndless(outer) || IsEndless(inner)) return true;
    if (outer.pieces().size() == 1 && inner.pieces().size() == 1) return true;
    return BoxGap_m(outer.piece_bounds()[i].transformed(X_IO), inner.piece_bounds()[k]) <=
           std::max(max_distance_m_, 0.0);
  }

  void Gather(const Foreground& of_a, const Foreground& of_b) {
    const double reach_m = std::min(of_a.reach_m(), of_b.reach_m());
    for (const Vector2& xy : Common(of_a, of_b)) {
      Spot spot{xy, of_a.HeightAt(xy), of_b.HeightAt(xy)};
      // Pieces that overlap more have another normal.
      const double excess_m = spot.gap_m() - deepest_.distance_m;
      if (!(spot.gap_m() < max_distance_m_) || excess_m < -kSameShare * reach_m) continue;
      if (!IsOnSurface(a_, X_PA_, spot, spot.of_a_m)) continue;
      if (!IsOnSurface(b_, X_PB_, spot, spot.of_b_m)) continue;
      // Equal but for rounding is equal.
      if (excess_m < kBorderShare * reach_m) spot.of_b_m = spot.of_a_m + deepest_.distance_m;
      spots_.push_back(spot);
      reach_m_ = std::max(reach_m_, reach_m);
    }
  }

  // Sides of a plate's pieces may be cuts through the plate; its top and bottom are not.
  static bool IsOnSurface(const ExactGeometry& g, const Pose& X_PS, const Spot& spot, double z_m) {
    if (IsEndless(g) || g.pieces().size() == 1) return true;
    if (X_PS.linear().row(2).head<2>().norm() <= kMostLean) return true;
    const Vector3 p_P(spot.xy.x(), spot.xy.y(), z_m);
    return std::abs(SignedDistance_m(g.shape(), X_PS.inverse(Eigen::Isometry) * p_P)) <=
           kOnSurface_m;
  }

  PairDistance ContactAt(const Spot& spot) const {
    PairDistance contact = deepest_;
    contact.distance_m = std::max(spot.gap_m(), deepest_.distance_m);
    contact.point_a = deepest_.point_a + R_FP_ * Vector3(spot.xy.x(), spot.xy.y(), spot.of_a_m);
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
  Spots spots_;
  double reach_m_ = 0;
};

bool HasFeatures(const ExactGeometry& a, const ExactGeometry& b) {
  const auto is_mesh = [](const ExactGeometry& g) { return g.kind() == ShapeKind::kMesh; };
  const auto is_endless = [](const ExactGeometry& g) { return g.kind() == ShapeKind::kHalfSpace; };
  return !is_mesh(a) && !is_mesh(b) && !(is_endless(a) && is_endless(b));
}

}  // namespace

void ExactContacts(const PlacedExact& a, const PlacedExact& b, const ContactLimits& limits,
                   std::vector<PairDistance>& contacts) {
  if (limits.max_count < 1) return;
  // Of what overlaps the depth is known only where the search is not ended by it.
  const PairDistance deepest =
      ExactDistance(a, b, std::max(0.0, limits.max_distance_m), limits.work);
  if (!(deepest.distance_m < limits.max_distance_m)) return;
  const std::size_t most = contacts.size() + static_cast<std::size_t>(limits.max_count);
  contacts.push_back(deepest);
  if (limits.max_count == 1 || !HasFeatures(a.geometry, b.geometry)) return;
  PatchSearch(a, b, limits, deepest).AppendTo(contacts, most);
}

}  // namespace cwm::collision
