#include "perception/segmentation/local_planes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "perception/cloud/decompositions.h"
#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

// chosen: patches per cloud: the median of their scatter errs by a fifth of its spread.
constexpr std::size_t kPatches = 48;
// chosen: the number of points among which neighbours are searched: one per 2 cm^2 of a table.
constexpr std::size_t kSearchedPoints = 8192;
// chosen: neighbours per patch. In a cloud of no more than kSearchedPoints points, neighbours have
// correlated errors.
constexpr std::size_t kNeighbours = kTwoSamples;
// chosen: the largest radius of a patch; wider ones hold several surfaces.
constexpr double kWidest_m = 0.1;
// chosen: the largest ratio of thickness to width of a flat patch, rms.
constexpr double kFlat = 0.3;

using NearPoint = std::pair<float, std::uint32_t>;  // squared distance, index

// The nearest of `among` to a point, without the point itself.
std::vector<NearPoint> NearestOf(const OrientedPoints& points,
                                 const std::vector<std::uint32_t>& among, std::uint32_t middle) {
  std::vector<NearPoint> heap(kNeighbours, {std::numeric_limits<float>::infinity(), 0});
  const Eigen::Vector3f& p = points.points[middle];
  for (const std::uint32_t i : among) {
    const float m2 = (points.points[i] - p).squaredNorm();
    if (m2 >= heap.front().first || i == middle) continue;
    std::pop_heap(heap.begin(), heap.end());
    heap.back() = {m2, i};
    std::push_heap(heap.begin(), heap.end());
  }
  return heap;
}

std::optional<LocalPlane> FitAround(const OrientedPoints& points,
                                    const std::vector<std::uint32_t>& among, std::uint32_t middle) {
  const std::vector<NearPoint> near = NearestOf(points, among, middle);
  if (near.front().first > kWidest_m * kWidest_m) return std::nullopt;
  const Vector3 p = points.points[middle].cast<double>();
  Vector3 mean = Vector3::Zero();
  Matrix3 products = Matrix3::Zero();
  for (const auto& [m2, i] : near) {
    const Vector3 q = points.points[i].cast<double>() - p;
    mean += q;
    products += q * q.transpose();
  }
  constexpr double kCount = kNeighbours, kFreedom = kNeighbours - 3;
  mean /= kCount;
  const Matrix3 covariance = products / kCount - mean * mean.transpose();
  const SymmetricEigen<3> axes = EigenOfSymmetric(covariance);
  const Vector3 spread = axes.values.cwiseMax(0).cwiseSqrt();
  const Vector3 normal = axes.vectors.col(0);
  const double cosine = std::abs(normal.dot((p - points.viewpoint).normalized()));
  if (cosine < kGrazing_sin) return std::nullopt;
  return LocalPlane{.middle = middle,
                    .normal = normal,
                    .scatter_m = spread(0) * std::sqrt(kCount / kFreedom) / cosine,
                    .is_flat = spread(0) < kFlat * spread(1)};
}

}  // namespace

std::vector<LocalPlane> SampleLocalPlanes(const OrientedPoints& points) {
  std::vector<std::uint32_t> among;
  const std::size_t stride = points.size() / kSearchedPoints + 1;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    among.push_back(static_cast<std::uint32_t>(i));
  }
  std::vector<LocalPlane> planes;
  if (among.size() <= kNeighbours) return planes;
  const std::size_t step = among.size() / kPatches + 1;
  for (std::size_t k = step / 2; k < among.size(); k += step) {
    if (const auto plane = FitAround(points, among, among[k])) planes.push_back(*plane);
  }
  return planes;
}

}  // namespace cwm::perception
