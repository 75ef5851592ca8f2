#include "perception/hypotheses/point_sample.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace cwm::perception {
namespace {

using namespace std::chrono_literals;

// measured: the least number of points in an object's sample, of which the modeler searches a
// quarter. In kitchens of 5 and 15 million points, objects on the counter get the same shapes from
// a sample of this size as from all of their 20 000 to 430 000 points; from 16 000 or 32 000 points
// some get others or none.
constexpr std::size_t kMinSampled = 64'000;
// derived: points per node in the sample of a larger object. Noise spreads a surface over two to
// three layers of cells of 2.7 sigma, so this makes about ten points per 7 sigma^2: more than the
// pixels of a Kinect at 0.8 m, whose noise is correlated too.
constexpr std::size_t kPointsPerNode = 4;
// derived: sampled points on each side that are searched for the nearest one: about those of a
// cell.
constexpr std::size_t kSearchReach = kPointsPerNode;

}  // namespace

PointSample::PointSample(const OrientedPoints& all, const PointSet& members, std::size_t node_count)
    : all_(all), members_(members) {
  const std::size_t enough = std::max(kMinSampled, kPointsPerNode * node_count);
  stride_ = std::max<std::size_t>(1, members_.size() / enough);
}

OrientedPoints PointSample::Points() const {
  std::vector<std::uint32_t> sampled;
  sampled.reserve((members_.size() + stride_ - 1) / stride_);
  for (std::size_t k = 0; k < members_.size(); k += stride_) sampled.push_back(members_[k]);
  return Subset(all_, sampled);
}

std::vector<std::int32_t> PointSample::PartsOfAllPoints(
    const std::vector<std::int32_t>& part_of_sampled, const Work& work) const {
  if (stride_ == 1) return part_of_sampled;
  std::vector<std::int32_t> part_of_point(members_.size());
  for (std::size_t s = 0; s < part_of_sampled.size(); ++s) {
    // Up to 100 points of at most 30 ns each.
    if (s % ItemsPerChunk(3us) == 0) work.Poll();
    const std::size_t end = std::min((s + 1) * stride_, members_.size());
    const Around around = AroundSampled(s, part_of_sampled.size());
    const auto first = part_of_sampled.begin() + static_cast<std::ptrdiff_t>(around.first);
    const auto last = part_of_sampled.begin() + static_cast<std::ptrdiff_t>(around.end);
    const bool agree = std::all_of(first, last, [&](std::int32_t part) { return part == *first; });
    for (std::size_t k = s * stride_; k < end; ++k) {
      part_of_point[k] = agree ? *first : part_of_sampled[NearestSampled(k, around)];
    }
  }
  return part_of_point;
}

std::vector<std::int32_t> PointSample::PartsOfSampledPoints(
    const std::vector<std::int32_t>& part_of_member) const {
  if (stride_ == 1) return part_of_member;
  std::vector<std::int32_t> part_of_sampled;
  for (std::size_t k = 0; k < part_of_member.size(); k += stride_) {
    part_of_sampled.push_back(part_of_member[k]);
  }
  return part_of_sampled;
}

PointSample::Around PointSample::AroundSampled(std::size_t s, std::size_t count) {
  return {s - std::min(s, kSearchReach), std::min(s + kSearchReach + 1, count)};
}

std::size_t PointSample::NearestSampled(std::size_t k, const Around& around) const {
  std::size_t nearest = around.first;
  float nearest_m2 = std::numeric_limits<float>::infinity();
  for (std::size_t s = around.first; s < around.end; ++s) {
    const float distance_m2 =
        (all_.points[members_[k]] - all_.points[members_[s * stride_]]).squaredNorm();
    if (distance_m2 < nearest_m2) nearest = s, nearest_m2 = distance_m2;
  }
  return nearest;
}

std::uint64_t PointSample::Scaled(std::uint64_t sampled) const {
  const std::size_t count = (members_.size() + stride_ - 1) / stride_;
  const double share = static_cast<double>(sampled) / static_cast<double>(count);
  return static_cast<std::uint64_t>(std::llround(share * static_cast<double>(members_.size())));
}

}  // namespace cwm::perception
