#include "perception/segmentation/support_gaps.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "perception/cloud/quantile.h"
#include "perception/cloud/tolerances.h"
#include "perception/segmentation/support_polygon.h"

namespace cwm::perception {
namespace {

// chosen: below this cosine a ray runs along the plane and shows nothing.
constexpr double kAlongPlane_cos = 0.02;

double MedianSigma_m(const OrientedPoints& points, std::span<const std::uint32_t> members) {
  std::vector<float> sigma;
  for (std::uint32_t i : members) sigma.push_back(points.sigma_m[i]);
  return Median(std::move(sigma));
}

struct Line {
  Vector3 from, to;
};

// The line from one place of the smaller set to the nearest place of the larger.
Line LineFrom(const Vector3& from, const OrientedPoints& points,
              std::span<const std::uint32_t> larger) {
  const std::size_t stride = (larger.size() + kMaxScanned - 1) / kMaxScanned;
  Line best{from, from};
  double best_squared = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < larger.size(); k += stride) {
    const Vector3 to = points.points[larger[k]].cast<double>();
    const double squared = (to - from).squaredNorm();
    if (squared < best_squared) best_squared = squared, best.to = to;
  }
  return best;
}

// True if rays pass at two consecutive places of the line, since a single one may be a mixed pixel.
// There are two places per cell of a footprint, so that no passage of a cell's width is missed.
bool AnyPassage(const Line& line, const PassageTest& passes) {
  const double length = (line.to - line.from).norm();
  const int count =
      std::clamp(static_cast<int>(2 * length / kFootprintCell_m), 1, int{kMaxSamples});
  int passed = 0;
  for (int k = 1; k < count && passed < 2; ++k) {
    const double t = static_cast<double>(k) / count;
    passed = passes(Vector3((1 - t) * line.from + t * line.to)) ? passed + 1 : 0;
  }
  return passed >= 2;  // two consecutive places
}

}  // namespace

PassageTest::PassageTest(const SightMap& sight, const Plane& plane, const OrientedPoints& points,
                         std::span<const std::uint32_t> members)
    : sight_(sight),
      sensor_height_m_(plane.Height_m(sight.viewpoint())),
      depth_m_(std::max(kPlateThickness_m,
                        double{points.spread.wide} * MedianSigma_m(points, members))) {}

bool PassageTest::operator()(const Vector3& place) const {
  const double range_m = (place - sight_.viewpoint().cast<double>()).norm();
  const double incidence_cos = sensor_height_m_ / std::max(range_m, 1e-9);
  if (incidence_cos < kAlongPlane_cos) return false;
  const auto beyond_m = static_cast<float>(depth_m_ / incidence_cos);
  return sight_.VisibilityAt(place.cast<float>(), beyond_m) == Visibility::kSeenThrough;
}

bool IsGapClosed(const Plane& plane, const OrientedPoints& points,
                 std::span<const std::uint32_t> larger, std::span<const std::uint32_t> smaller,
                 const SightMap* sight) {
  std::vector<Line> lines;
  const std::size_t count = std::min(kLinesOfSight, smaller.size());
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint32_t from = smaller[k * smaller.size() / count];
    lines.push_back(LineFrom(points.points[from].cast<double>(), points, larger));
  }
  if (sight == nullptr) {
    return std::any_of(lines.begin(), lines.end(), [](const Line& line) {
      return (line.to - line.from).norm() <= 2 * kClosing_m;
    });
  }
  const PassageTest passes(*sight, plane, points, larger);
  const auto open = std::count_if(lines.begin(), lines.end(),
                                  [&](const Line& line) { return AnyPassage(line, passes); });
  return static_cast<double>(open) <= (1 - kMainShare) * static_cast<double>(count);
}

}  // namespace cwm::perception
