#include "perception/search/model_points.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "perception/cloud/morton.h"
#include "perception/cloud/quantile.h"
#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

using namespace std::chrono_literals;

// derived: halfway between the faces of a right-angled edge; a wider gate would not discriminate.
constexpr double kMaxNormalGate_rad = 45 * kDegree;
// derived: as for distances.
constexpr double kNormalGate_sigma = kDistanceGate_sigma;
// chosen: a point without a stated noise still needs a gate; no range sensor has less.
constexpr double kMinSigma_m = 1e-4;

struct KeyedPoint {
  std::uint32_t key = 0;
  std::uint32_t index = 0;
  friend bool operator<(const KeyedPoint& a, const KeyedPoint& b) {
    return a.key != b.key ? a.key < b.key : a.index < b.index;
  }
};

std::vector<std::uint32_t> UsablePoints(const OrientedPoints& points) {
  std::vector<std::uint32_t> usable;
  usable.reserve(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (points.points[i].allFinite() && std::abs(points.normals[i].squaredNorm() - 1) < 0.1f) {
      usable.push_back(i);
    }
  }
  return usable;
}

std::vector<KeyedPoint> SortByMorton(const OrientedPoints& points,
                                     const std::vector<std::uint32_t>& usable, const Work& work) {
  Eigen::AlignedBox3f bounds;
  for (std::uint32_t i : usable) bounds.extend(points.points[i]);
  const float extent = std::max(bounds.sizes().maxCoeff(), 1e-6f);
  const float scale = static_cast<float>((1 << kMortonLevels) - 1) / extent;
  std::vector<KeyedPoint> keyed;
  keyed.reserve(usable.size());
  for (std::uint32_t i : usable) {
    const Eigen::Vector3f q = (points.points[i] - bounds.min()) * scale;
    const auto cell = [&q](int axis) { return static_cast<std::uint32_t>(q[axis]); };
    keyed.push_back({static_cast<std::uint32_t>(MortonKey(cell(0), cell(1), cell(2))), i});
  }
  PollEvery poll(work, ItemsPerChunk(20ns));
  std::sort(keyed.begin(), keyed.end(), [&poll](const KeyedPoint& a, const KeyedPoint& b) {
    poll();
    return a < b;
  });
  return keyed;
}

double MedianSpacing_m(const ModelPoints& points) {
  if (points.size() < 2) return 0;
  std::vector<double> gaps;
  gaps.reserve(points.size() - 1);
  for (std::size_t i = 1; i < points.size(); ++i) {
    gaps.push_back((points.p[i] - points.p[i - 1]).norm());
  }
  return Median(std::move(gaps));
}

}  // namespace

double NormalGate_cos(double normal_sigma_rad) {
  const double gate_rad = kNormalGate_sigma * normal_sigma_rad;
  return std::cos(std::clamp(gate_rad, kSameNormal_rad, kMaxNormalGate_rad));
}

ModelPoints SubsampleForSearch(const OrientedPoints& points, std::size_t max_points,
                               const Work& work) {
  ModelPoints out;
  const std::vector<std::uint32_t> usable = UsablePoints(points);
  if (usable.empty()) return out;
  const std::vector<KeyedPoint> keyed = SortByMorton(points, usable, work);
  const std::size_t stride = (keyed.size() + max_points - 1) / max_points;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const KeyedPoint& k : keyed) sum += points.points[k.index].cast<double>();
  out.origin_L = sum / static_cast<double>(keyed.size());
  out.viewpoint = points.viewpoint - out.origin_L;
  out.weight = static_cast<double>(stride);
  for (std::size_t k = 0; k < keyed.size(); k += stride) {
    const std::uint32_t i = keyed[k].index;
    // Copies of a point are neighbours in this order and count once.
    if (!out.index.empty() && points.points[out.index.back()] == points.points[i]) continue;
    const double sigma_m = std::max<double>(points.sigma_m[i], kMinSigma_m);
    out.p.push_back(points.points[i].cast<double>() - out.origin_L);
    out.n.push_back(points.normals[i].cast<double>().normalized());
    out.sigma_m.push_back(sigma_m);
    out.gate_m.push_back(kDistanceGate_sigma * sigma_m);
    out.min_cos.push_back(NormalGate_cos(points.normal_sigma_rad[i]));
    out.key.push_back(keyed[k].key);
    out.index.push_back(i);
  }
  out.max_gate_m = *std::max_element(out.gate_m.begin(), out.gate_m.end());
  out.spacing_m = MedianSpacing_m(out);
  return out;
}

ModelPoints Subset(const ModelPoints& all, std::span<const std::uint32_t> listed) {
  ModelPoints out;
  for (std::uint32_t i : listed) {
    out.p.push_back(all.p[i]);
    out.n.push_back(all.n[i]);
    out.sigma_m.push_back(all.sigma_m[i]);
    out.gate_m.push_back(all.gate_m[i]);
    out.min_cos.push_back(all.min_cos[i]);
    out.key.push_back(all.key[i]);
    out.index.push_back(all.index[i]);
  }
  out.origin_L = all.origin_L;
  out.viewpoint = all.viewpoint;
  out.max_gate_m = all.max_gate_m;
  out.weight = all.weight;
  out.spacing_m = all.spacing_m;
  return out;
}

std::vector<std::uint32_t> Subsampled(std::span<const std::uint32_t> indices,
                                      std::size_t max_count) {
  const std::size_t stride = (indices.size() + max_count - 1) / std::max<std::size_t>(max_count, 1);
  if (stride <= 1) return {indices.begin(), indices.end()};
  std::vector<std::uint32_t> out;
  for (std::size_t k = 0; k < indices.size(); k += stride) out.push_back(indices[k]);
  return out;
}

}  // namespace cwm::perception
