#include "perception/solids/extent_from_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "collision/geometry/distance_to_shape.h"
#include "perception/cloud/tolerances.h"
#include "perception/solids/extended_distance.h"
#include "perception/solids/extended_solid.h"
#include "perception/solids/free_space.h"
#include "perception/solids/solid_assembly.h"

namespace cwm::perception {
namespace {

// chosen: as a share of the rays that passed the object; noise lets as many run through an
// extension.
constexpr double kMaxNewlyPassed = 0.01;

constexpr std::array<SolidEnd, 6> kEnds = {{{0, -1}, {0, 1}, {1, -1}, {1, 1}, {2, -1}, {2, 1}}};

// The extension of a solid's wall beyond one end. Has is true if the point lies on it and its
// normal agrees.
class ExtendedWall {
 public:
  ExtendedWall(const Shape& shape, const SolidEnd& end) : shape_(shape), end_(end) {}

  bool Has(const Vector3& p, const Vector3& n, double gate_m, double min_cos) const {
    if (const auto* box = std::get_if<Box>(&shape_)) return IsOnFace(*box, p, n, gate_m, min_cos);
    const Vector3 outward(p.x(), p.y(), 0);
    return std::abs(ExtendedDistance_m(shape_, p)) <= gate_m &&
           outward.dot(n) >= min_cos * outward.norm();
  }

 private:
  bool IsOnFace(const Box& box, const Vector3& p, const Vector3& n, double gate_m,
                double min_cos) const {
    for (Eigen::Index across = 0; across < 3; ++across) {
      if (across == end_.axis) continue;
      const Eigen::Index along = 3 - across - end_.axis;
      if (std::abs(std::abs(p[across]) - 0.5 * box.size_m[across]) <= gate_m &&
          std::abs(p[along]) <= 0.5 * box.size_m[along] + gate_m &&
          n[across] * (p[across] > 0 ? 1 : -1) >= min_cos) {
        return true;
      }
    }
    return false;
  }

  const Shape& shape_;
  const SolidEnd end_;
};

class ExtentFromPoints {
 public:
  ExtentFromPoints(const FitContext& context, std::vector<Solid>& solids)
      : c_(context), solids_(solids), on_solid_(context.points.size(), kOnNone) {
    for (std::size_t k = 0; k < solids.size(); ++k) Claim(k);
  }

  void ExtendToPoints(std::size_t k) {
    // Extending one axis may bring points into reach of the other axes' ends.
    for (int round = 0; round < Vector3::SizeAtCompileTime; ++round) {
      bool reached = false;
      for (const SolidEnd& end : kEnds) reached = ExtendEnd(k, end) || reached;
      if (!reached) return;
    }
  }

 private:
  static constexpr std::size_t kOnNone = static_cast<std::size_t>(-1);

  void Claim(std::size_t k) {
    const Pose X_SM = solids_[k].X_MS.inverse(Eigen::Isometry);
    const DistanceToShape distance_m(solids_[k].shape);
    for (std::uint32_t i = 0; i < c_.points.size(); ++i) {
      if (std::abs(distance_m(X_SM * c_.points.p[i])) <= c_.points.gate_m[i]) on_solid_[i] = k;
    }
  }

  std::vector<std::uint32_t> PointsBeyond(std::size_t k, const SolidEnd& end,
                                          double length_m) const {
    const Pose X_SM = solids_[k].X_MS.inverse(Eigen::Isometry);
    const ExtendedWall wall(solids_[k].shape, end);
    std::vector<std::uint32_t> beyond;
    for (std::uint32_t i = 0; i < c_.points.size(); ++i) {
      if (on_solid_[i] != kOnNone) continue;
      const Vector3 p = X_SM * c_.points.p[i];
      const double gate_m = c_.points.gate_m[i];
      if (end.sign * p[end.axis] > 0.5 * length_m + gate_m &&
          wall.Has(p, X_SM.linear() * c_.points.n[i], gate_m, c_.points.min_cos[i])) {
        beyond.push_back(i);
      }
    }
    return c_.connectivity.LargestComponent(beyond);
  }

  bool ExtendEnd(std::size_t k, const SolidEnd& end) {
    Solid& solid = solids_[k];
    const std::optional<double> length_m = LengthAlong_m(solid.shape, end.axis);
    if (!length_m) return false;
    const std::vector<std::uint32_t> beyond = PointsBeyond(k, end, *length_m);
    if (static_cast<double>(beyond.size()) * c_.points.weight < kTwoSamples) return false;
    const Vector3 outward = end.sign * solid.X_MS.linear().col(end.axis);
    const double by_m = ExtentAlong(outward, c_.points, beyond).high_m -
                        outward.dot(solid.X_MS.translation()) - 0.5 * *length_m;
    if (!(by_m > 0)) return false;
    if (!(by_m < MaxExtension_m(solid.shape, end))) return false;
    Placed<> placed = Extended({solid.X_MS, solid.shape}, end, by_m);
    Solid longer = solid;
    longer.X_MS = placed.X_FS;
    longer.shape = std::move(placed.shape);
    longer.inliers.insert(longer.inliers.end(), beyond.begin(), beyond.end());
    if (IsContradicted(longer, solid)) return false;
    solid = std::move(longer);
    Claim(k);
    return true;
  }

  bool IsContradicted(const Solid& longer, const Solid& solid) const {
    if (c_.ground.known && LowestHeight_m(longer, c_.ground) <
                               std::min(-kGroundNoise_m, LowestHeight_m(solid, c_.ground))) {
      return true;
    }
    return CrossingRayShare(longer, c_.free) > CrossingRayShare(solid, c_.free) + kMaxNewlyPassed ||
           IsCrossed(longer, c_);
  }

  const FitContext& c_;
  std::vector<Solid>& solids_;
  std::vector<std::size_t> on_solid_;  // index of the solid per point
};

}  // namespace

void SetExtentFromPoints(const FitContext& context, std::vector<Solid>& solids) {
  ExtentFromPoints ends(context, solids);
  for (std::size_t k = 0; k < solids.size(); ++k) {
    context.work.Poll();
    if (!solids[k].vessel) ends.ExtendToPoints(k);
  }
}

}  // namespace cwm::perception
