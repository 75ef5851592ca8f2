#include "perception/segmentation/join_hidden.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "perception/cloud/decompositions.h"
#include "perception/cloud/tolerances.h"
#include "perception/segmentation/long_planes.h"
#include "perception/segmentation/plane_fit.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {
namespace {

// chosen: the largest share of places between two parts that are seen through (mixed pixels at
// edges), and the least share that is hidden; the other places lie on the parts themselves.
constexpr double kMaxThroughBetween = 0.06, kMinHiddenBetween = 0.25;
// chosen: the least share of the members of each part that lie on one cylinder.
constexpr double kMinOnCylinder = 0.85;

using Eigen::Vector3f;
using Members = std::vector<std::uint32_t>;

// chosen: a box shows three faces.
constexpr std::size_t kMaxFacets = 3;
// derived: under Kinect noise the normal of a face of 3 x 3 cm adds two standard deviations of 1.5
// degrees, as much as flat surfaces may turn.
constexpr double kSamePlane_rad = kFlat_rad * 2;

struct Facet {
  Plane plane;
  Members members;
};

Members NormalInliers(const Plane& plane, const OrientedPoints& nodes, const Members& members) {
  Members out;
  const Vector3f n = plane.normal.cast<float>();
  for (std::uint32_t i : Inliers(plane, nodes, members)) {
    if (nodes.normals[i].dot(n) > kFacing_cos) out.push_back(i);
  }
  return out;
}

std::vector<Facet> FacetsOf(const OrientedPoints& nodes, const PieceSummary& piece) {
  std::vector<Facet> facets;
  Members rest = piece.sample;
  const std::size_t min_count = std::max(
      kTwoSamples,
      static_cast<std::size_t>(kMinSignificantShare * static_cast<double>(piece.sample.size())));
  while (facets.size() < kMaxFacets && rest.size() >= min_count) {
    const std::optional<Plane> plane = FitPlane(nodes, rest, rest[0]);
    if (!plane) break;
    Members members = NormalInliers(*plane, nodes, rest);
    if (members.size() < min_count) break;
    Members remaining;
    std::set_difference(rest.begin(), rest.end(), members.begin(), members.end(),
                        std::back_inserter(remaining));
    rest = std::move(remaining);
    facets.push_back({*plane, std::move(members)});
  }
  return facets;
}

// Mean height of the members over a plane in units of their sigma; less than one if they lie on it.
double MeanOffset_sigma(const OrientedPoints& nodes, const Plane& plane, const Members& members) {
  double sum = 0;
  for (std::uint32_t i : members) sum += plane.Height_m(nodes.points[i]) / nodes.sigma_m[i];
  return std::abs(sum) / static_cast<double>(members.size());
}

bool SharePlane(const OrientedPoints& nodes, const Facet& a, const Facet& b) {
  if (a.plane.normal.dot(b.plane.normal) < std::cos(kSamePlane_rad)) return false;
  Members both = a.members;
  both.insert(both.end(), b.members.begin(), b.members.end());
  const Facet& larger = a.members.size() >= b.members.size() ? a : b;
  const std::optional<Plane> common = RefinePlane(larger.plane, nodes, both);
  if (!common) return false;
  const double max_turn_cos = std::cos(kSamePlane_rad);
  return common->normal.dot(a.plane.normal) > max_turn_cos &&
         common->normal.dot(b.plane.normal) > max_turn_cos &&
         MeanOffset_sigma(nodes, *common, a.members) < 1 &&
         MeanOffset_sigma(nodes, *common, b.members) < 1;
}

// A cylinder fitted to both parts. Its axis is the direction that no normal points along; its
// section is a circle whose centre is where the normals meet.
class CommonCylinder {
 public:
  CommonCylinder(const OrientedPoints& nodes, const Members& a, const Members& b) : nodes_(nodes) {
    Matrix3 sum = Matrix3::Zero();
    for (const Members* members : {&a, &b}) {
      for (std::uint32_t i : *members) {
        const Vector3 n = nodes.normals[i].cast<double>();
        sum += n * n.transpose() / static_cast<double>(members->size());
      }
    }
    const SymmetricEigen<3> eigen = EigenOfSymmetric(Matrix3(sum / 2));
    // derived: the normals of a visible arc of +-35 degrees have these second moments; noise of 5
    // degrees along the axis has 0.008.
    curved_ = eigen.values(0) < 0.03 && eigen.values(1) > 0.08;
    basis_ << eigen.vectors.col(1), eigen.vectors.col(2), eigen.vectors.col(0);
    if (curved_) FitCircle(a, b);
  }

  bool Explains(const Members& members) const {
    // chosen: the least and the largest radius of a cylinder, in metres.
    if (!curved_ || radius_m_ < 0.01 || radius_m_ > 0.15) return false;
    double within = 0;
    for (std::uint32_t i : members) {
      const double r = (Across(nodes_.points[i]) - center_).norm() - radius_m_;
      within += std::abs(r) <= kGate_sigma * nodes_.sigma_m[i];
    }
    return within >= kMinOnCylinder * static_cast<double>(members.size());
  }

 private:
  Vector2 Across(const Vector3f& v) const {
    return (basis_.transpose() * v.cast<double>()).head<2>();
  }

  // Algebraic least squares of (p - c)^2 = r^2 over both parts (Kasa 1976): linear, with a bias
  // that is small for arcs as wide as curved_ requires.
  void FitCircle(const Members& a, const Members& b) {
    Matrix3 sum = Matrix3::Zero();
    Vector3 right = Vector3::Zero();
    const Vector2 origin = Across(nodes_.points[a[0]]);
    for (const Members* members : {&a, &b}) {
      for (std::uint32_t i : *members) {
        const Vector2 p = Across(nodes_.points[i]) - origin;
        const Vector3 row(2 * p.x(), 2 * p.y(), 1);
        const double weight = 1 / static_cast<double>(members->size());
        sum += weight * row * row.transpose();
        right += weight * row * p.squaredNorm();
      }
    }
    const Vector3 solution = SolveSymmetric(sum, right);
    center_ = origin + solution.head<2>();
    radius_m_ = std::sqrt(std::max(0.0, solution.z() + solution.head<2>().squaredNorm()));
  }

  const OrientedPoints& nodes_;
  Matrix3 basis_;
  Vector2 center_ = Vector2::Zero();
  double radius_m_ = 0;
  bool curved_ = false;
};

Members EvenlySpread(const Members& members, std::size_t count) {
  Members some;
  for (std::size_t k = 0; k < count; ++k) some.push_back(members[k * members.size() / count]);
  return some;
}

// True if two coplanar faces reach too far to belong to one object. Boxes of the same height have
// coplanar tops, and boxes in a row coplanar fronts. Longer faces belong to structures, whose
// pieces are found by their plane.
bool AreOfTwo(const OrientedPoints& nodes, const Facet& a, const Facet& b) {
  const Members some_a = EvenlySpread(a.members, kLinesOfSight);
  const Members some_b = EvenlySpread(b.members, kLinesOfSight);
  return std::ranges::any_of(some_a, [&](std::uint32_t i) {
    return std::ranges::any_of(some_b, [&](std::uint32_t j) {
      return (nodes.points[i] - nodes.points[j]).norm() > float{kMaxObjectLength_m};
    });
  });
}

// Looks at places on straight lines between members of two parts. The gap is hidden if no more
// places are seen through than mixed pixels at edges make, and more are hidden than chance makes.
// The other places lie on the parts.
class BetweenParts {
 public:
  BetweenParts(const OrientedPoints& nodes, const SightMap& sight) : nodes_(nodes), sight_(sight) {}

  bool IsHidden(const Members& a, const Members& b) const {
    const auto [through, hidden, seen] = CountBetween(sight_, nodes_, a, b);
    return through <= kMaxThroughBetween * seen && hidden >= kMinHiddenBetween * seen;
  }

 private:
  const OrientedPoints& nodes_;
  const SightMap& sight_;
};

}  // namespace

void JoinAcrossOccluders(const OrientedPoints& nodes, const PieceSummaries& views,
                         const SightMap& sight, DisjointSets& objects) {
  std::vector<std::size_t> parts;
  std::vector<std::vector<Facet>> facets(views.pieces.size());
  for (std::size_t p = 0; p < views.pieces.size(); ++p) {
    const PieceSummary& piece = views.pieces[p];
    if (piece.area_m2 < kMinFace_m2 || piece.sample.size() < 3 || piece.is_patch) continue;
    parts.push_back(p);
    facets[p] = FacetsOf(nodes, piece);
  }
  const BetweenParts between(nodes, sight);
  auto touch = [&](std::size_t a, std::size_t b) {
    return views.borders.contains({static_cast<std::int32_t>(a), static_cast<std::int32_t>(b)});
  };
  auto same_object = [&](std::size_t a, std::size_t b) {
    for (const Facet& fa : facets[a]) {
      for (const Facet& fb : facets[b]) {
        if (!SharePlane(nodes, fa, fb)) continue;
        // Noise leaves a few links across a step, as between two tops of about the same height.
        if (AreInContact(views, a, b)) return true;
        if (!AreOfTwo(nodes, fa, fb) && between.IsHidden(fa.members, fb.members)) return true;
      }
    }
    const Members& sa = views.pieces[a].sample;
    const Members& sb = views.pieces[b].sample;
    if (touch(a, b)) return false;  // a concave crease is the end of a cylinder
    const CommonCylinder cylinder(nodes, sa, sb);
    return cylinder.Explains(sa) && cylinder.Explains(sb) && between.IsHidden(sa, sb);
  };
  std::vector<char> is_whole(views.pieces.size(), 0);  // per root: the set has several pieces
  for (std::size_t p = 0; p < is_whole.size(); ++p)
    is_whole[objects.Root(p)] |= objects.Root(p) != p;
  // Sorted by their left ends, so that only parts near each other are compared.
  std::sort(parts.begin(), parts.end(), [&](std::size_t a, std::size_t b) {
    return views.pieces[a].bounds.min().x() < views.pieces[b].bounds.min().x();
  });
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const auto& bounds = views.pieces[parts[k]].bounds;
    for (std::size_t l = k + 1; l < parts.size(); ++l) {
      const auto& other = views.pieces[parts[l]].bounds;
      if (other.min().x() > bounds.max().x() + kMaxHiddenGap_m) break;
      if (bounds.exteriorDistance(other) > kMaxHiddenGap_m) continue;
      const std::size_t a = objects.Root(parts[k]), b = objects.Root(parts[l]);
      if (a == b || (is_whole[a] && is_whole[b])) continue;
      if (!same_object(parts[k], parts[l])) continue;
      objects.Join(a, b);
      is_whole[objects.Root(a)] = is_whole[a] || is_whole[b];
    }
  }
}

}  // namespace cwm::perception
