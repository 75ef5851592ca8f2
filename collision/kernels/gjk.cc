#include "collision/kernels/gjk.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "collision/kernels/simplex.h"

namespace cwm::collision {
namespace {

// chosen: a budget. Round cores converge linearly; if the budget is used up, the answer is the best
// point found so far, with its bound.
constexpr int kMaxIterations = 128;

// derived: the bounds of the distance count as equal if they differ by this share of distance plus
// extent, a few roundings of double precision.
constexpr double kRelativeGap = 1e-14;

// chosen: if the gap is below kNearRatio of the extent, a plane across it must separate the cores
// by kMinCertified of the gap; otherwise its direction is not trusted.
constexpr double kNearRatio = 1e-6;
constexpr double kMinCertified = 0.9;

class GjkSolver {
 public:
  // The search ends once the distance is known to be at most `enough_m`.
  GjkSolver(const CoreDifference& difference, double max_distance_m, double enough_m)
      : difference_(difference),
        max_distance_m_(max_distance_m),
        enough_m_(enough_m),
        size_(difference.extent_m()),
        touching_(kTouchingRatio * size_) {}

  // Starts with the support of D across a line from B to A.
  GjkResult Run(const Vector3& offset) {
    Vector3 direction = -offset;
    if (!(direction.squaredNorm() > 0)) direction = Vector3::UnitX();
    const CoreDifference::Vertex first = difference_.Support(direction);
    // The plane across this first line separates nine of ten pairs that are apart.
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
      // No progress: because of rounding, the new vertex leads no nearer to the origin.
      if (!(feature.distance_squared < distance_ * distance_)) break;
      // Nearer than the separating plane allows: an artefact of rounding in a thin simplex.
      const double min_distance = lower_bound_ - touching_;
      if (min_distance > 0 && feature.distance_squared < min_distance * min_distance) break;
      Reduce(feature);
    }
    if (distance_ > touching_ && IsDirectionReliable()) return Separated();
    const bool met = distance_ <= touching_;
    return {.outcome = GjkOutcome::kTouching,
            .distance_m = met ? 0 : distance_,
            .overlaps = met && count_ == 4};
  }

 private:
  // True if the direction of the gap can be trusted. In a small gap rounding can leave a direction
  // along which the cores are not separated.
  bool IsDirectionReliable() const {
    return distance_ > kNearRatio * size_ || lower_bound_ >= kMinCertified * distance_;
  }

  void Add(const CoreDifference::Vertex& vertex) {
    corners_[static_cast<std::size_t>(count_)] = vertex.w;
    on_a_[static_cast<std::size_t>(count_)] = vertex.a;
    ++count_;
  }

  bool IsKnown(const Vector3& w) const {
    return std::find(corners_.begin(), corners_.begin() + count_, w) != corners_.begin() + count_;
  }

  // Keeps only the corners of the nearest feature.
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

  GjkResult Separated() const {
    GjkResult answer{GjkOutcome::kSeparated, distance_,
                     Vector3::Zero(),        Vector3::Zero(),
                     -nearest_ / distance_,  std::max(0.0, distance_ - lower_bound_)};
    // For round cores of very different sizes the last direction may separate them less than an
    // earlier one.
    if (lower_bound_ - last_lower_bound_ > kTouchingRatio * size_) {
      answer.normal = -parting_.normalized();
    }
    // A corner that was added by a last step without progress has weight 0.
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
  double lower_bound_ = 0;              // of the distance, by the best separating plane so far
  double last_lower_bound_ = 0;         // by the plane across the last gap
  Vector3 parting_ = Vector3::UnitZ();  // normal of the best separating plane, of any length
};

}  // namespace

GjkResult GjkDistance(const CoreDifference& difference, double max_distance_m) {
  return GjkSolver(difference, max_distance_m, 0).Run(difference.CentreOffset());
}

std::optional<bool> GjkOverlap(const CoreDifference& difference, const GjkLimits& limits) {
  const double rounding_m = kTouchingRatio * difference.extent_m();
  const double far_m = limits.far_m + rounding_m, near_m = limits.near_m - rounding_m;
  Vector3 offset = difference.NearOffset();
  if (!(offset.norm() > rounding_m)) offset = difference.CentreOffset();
  const GjkResult answer = GjkSolver(difference, far_m, near_m).Run(offset);
  if (answer.outcome == GjkOutcome::kBeyond) return false;
  if (answer.overlaps) return true;
  const double distance_m = answer.distance_m;
  if (answer.outcome == GjkOutcome::kTouching && distance_m > 0) return std::nullopt;
  // distance_m is an upper bound; it may be too large if the search ran out of iterations.
  if (distance_m >= near_m && distance_m - answer.bound_m <= far_m) return std::nullopt;
  return distance_m < near_m;
}

Vector3 WitnessOnA(const CoreDifference& difference, double depth_m, const Vector3& normal) {
  // chosen: the smaller the gap, the less the nearest points shift towards the middle of round
  // faces. A gap of a tenth of a percent still keeps twelve digits of the direction.
  const double gap_m = 1e-3 * difference.extent_m();
  return GjkDistance(difference.Moved((depth_m + gap_m) * normal)).point_a;
}

}  // namespace cwm::collision
