#include "collision/kernels/gjk.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "collision/kernels/simplex.h"

namespace cwm::collision {
namespace {

// A budget, not measured: round cores converge linearly, and what is left open then is answered by
// the best point found so far.
constexpr int kMaxIterations = 128;

// Upper and lower bound of the distance agree to this share of it: a few roundings of double.
constexpr double kRelativeGap = 1e-14;

// Where a gap is below this share of the extent, a plane across it must part the cores by so much
// of it, or its direction is not believed.
constexpr double kNearShare = 1e-6;
constexpr double kLeastCertified = 0.9;

class Solver {
 public:
  // The search ends once the cores are known to be as near as `enough_m`.
  Solver(const CoreDifference& difference, double max_distance_m, double enough_m)
      : difference_(difference),
        max_distance_m_(max_distance_m),
        enough_m_(enough_m),
        size_(difference.extent_m()),
        touching_(kTouchingShare * size_) {}

  // Begins across a line from B to A.
  GjkAnswer Run(const Vector3& offset) {
    Vector3 direction = -offset;
    if (!(direction.squaredNorm() > 0)) direction = Vector3::UnitX();
    const CoreDifference::Vertex first = difference_.Support(direction);
    // The plane across this first line parts nine of ten pairs that are apart.
    const double first_bound = -first.w.dot(direction) / direction.norm();
    if (first_bound > max_distance_m_) {
      return {.outcome = GjkOutcome::kBeyond, .distance_m = first_bound};
    }
    Add(first);
    Reduce(NearestToOrigin(corners_, count_));
    for (int i = 0; i < kMaxIterations && distance_ > std::max(touching_, enough_m_); ++i) {
      const CoreDifference::Vertex vertex = difference_.Support(-nearest_);
      const double lower_bound = vertex.w.dot(nearest_) / distance_;
      last_lower_bound_ = lower_bound;
      if (lower_bound > lower_bound_) {
        lower_bound_ = lower_bound;
        parting_ = nearest_;
      }
      if (lower_bound > max_distance_m_) {
        return {.outcome = GjkOutcome::kBeyond, .distance_m = lower_bound};
      }
      if (distance_ - lower_bound <= kRelativeGap * (distance_ + size_)) break;
      if (IsKnown(vertex.w) || count_ == 4) break;
      Add(vertex);
      const SimplexFeature feature = NearestToOrigin(corners_, count_);
      // Rounding has the last word: no vertex of D leads nearer to the origin.
      if (!(feature.distance_squared < distance_ * distance_)) break;
      // Nor nearer than a plane allows: of thin corners, rounding can put the nearest point there.
      const double least = lower_bound_ - touching_;
      if (least > 0 && feature.distance_squared < least * least) break;
      Reduce(feature);
    }
    if (distance_ > touching_ && IsDirectionTold()) return Separated();
    const bool met = distance_ <= touching_;
    return {.outcome = GjkOutcome::kTouching,
            .distance_m = met ? 0 : distance_,
            .overlaps = met && count_ == 4};
  }

 private:
  // Of a small gap, rounding can leave a direction along which the cores are not apart.
  bool IsDirectionTold() const {
    return distance_ > kNearShare * size_ || lower_bound_ >= kLeastCertified * distance_;
  }

  void Add(const CoreDifference::Vertex& vertex) {
    corners_[static_cast<std::size_t>(count_)] = vertex.w;
    on_a_[static_cast<std::size_t>(count_)] = vertex.a;
    ++count_;
  }

  bool IsKnown(const Vector3& w) const {
    return std::find(corners_.begin(), corners_.begin() + count_, w) != corners_.begin() + count_;
  }

  // Keeps the corners of the nearest feature only.
  void Reduce(const SimplexFeature& feature) {
    const auto corners = corners_;
    const auto on_a = on_a_;
    for (std::size_t i = 0; i < static_cast<std::size_t>(feature.count); ++i) {
      corners_[i] = corners[static_cast<std::size_t>(feature.index[i])];
      on_a_[i] = on_a[static_cast<std::size_t>(feature.index[i])];
    }
    weight_ = feature.weight;
    count_ = feature.count;
    nearest_ = feature.nearest;
    distance_ = std::sqrt(feature.distance_squared);
  }

  GjkAnswer Separated() const {
    GjkAnswer answer{GjkOutcome::kSeparated, distance_,
                     Vector3::Zero(),        Vector3::Zero(),
                     -nearest_ / distance_,  std::max(0.0, distance_ - lower_bound_)};
    // Round cores of very different sizes: the last points may tell a direction that parts them
    // less than an earlier one did.
    if (lower_bound_ - last_lower_bound_ > kTouchingShare * size_) {
      answer.normal = -parting_.normalized();
    }
    // A corner of a last step that failed has no weight.
    for (std::size_t i = 0; i < static_cast<std::size_t>(count_); ++i) {
      answer.point_a += weight_[i] * on_a_[i];
    }
    answer.point_b = answer.point_a + distance_ * answer.normal;
    return answer;
  }

  const CoreDifference& difference_;
  const double max_distance_m_;
  const double enough_m_;
  const double size_;
  const double touching_;
  std::array<Vector3, 4> corners_;
  std::array<Vector3, 4> on_a_;
  std::array<double, 4> weight_ = {1, 0, 0, 0};
  int count_ = 0;
  Vector3 nearest_ = Vector3::Zero();
  double distance_ = 0;
  double lower_bound_ = 0;              // no two points are nearer: a plane that parts them says so
  double last_lower_bound_ = 0;         // by the plane across the last gap
  Vector3 parting_ = Vector3::UnitZ();  // across the best plane, of any length
};

}  // namespace

GjkAnswer GjkDistance(const CoreDifference& difference, double max_distance_m) {
  return Solver(difference, max_distance_m, 0).Run(difference.CentreOffset());
}

std::optional<bool> GjkOverlap(const CoreDifference& difference, const GjkLimits& limits) {
  const double rounding_m = kTouchingShare * difference.extent_m();
  const double far_m = limits.far_m + rounding_m, near_m = limits.near_m - rounding_m;
  Vector3 offset = difference.NearOffset();
  if (!(offset.norm() > rounding_m)) offset = difference.CentreOffset();
  const GjkAnswer answer = Solver(difference, far_m, near_m).Run(offset);
  if (answer.outcome == GjkOutcome::kBeyond) return false;
  if (answer.overlaps) return true;
  const double distance_m = answer.distance_m;
  if (answer.outcome == GjkOutcome::kTouching && distance_m > 0) return std::nullopt;
  // From above; out of work, it may be too large.
  if (distance_m >= near_m && distance_m - answer.bound_m <= far_m) return std::nullopt;
  return distance_m < near_m;
}

Vector3 LastTouchOnA(const CoreDifference& difference, double depth_m, const Vector3& normal) {
  // The nearer the cores, the less their nearest points are pulled to the middle of round faces; a
  // tenth of a percent keeps twelve digits of the direction.
  const double gap_m = 1e-3 * difference.extent_m();
  return GjkDistance(difference.Moved((depth_m + gap_m) * normal)).point_a;
}

}  // namespace cwm::collision
