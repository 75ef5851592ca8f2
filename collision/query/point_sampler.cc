#include "collision/query/point_sampler.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

namespace cwm::collision {
namespace {

// A gap of this width or less between two solids does not count as a way out.
constexpr double kTouching_m = 1e-9;

bool Differ(const Vector3& a, const Vector3& b) {
  return (a - b).squaredNorm() > kGradientTolerance * kGradientTolerance;
}

// Upper bound of the distance of a part from any point of a block, by their boxes.
double FarthestCorner_m(const Aabb& block, const Aabb& part) {
  return (part.max() - block.min()).cwiseMax(block.max() - part.min()).norm();
}

PointSample SampleAt(const LaneSamples& samples, int i) {
  return {samples.distance_m[i],
          {samples.gradient_x[i], samples.gradient_y[i], samples.gradient_z[i]},
          samples.gap_m[i] <= kKinkTolerance_m};
}

}  // namespace

bool PointSampler::Sample(std::span<const Vector3> points, std::size_t first, std::size_t count,
                          PointColumns& columns) {
  const std::span<const Vector3> chunk = points.subspan(first, count);
  const std::span<const std::uint32_t> order = order_.Sort(chunk);
  ListNearParts(chunk);
  std::array<std::uint32_t, kBlockLanes> rows;
  for (std::size_t begin = 0; begin < count; begin += kBlockLanes) {
    const std::size_t size = std::min<std::size_t>(kBlockLanes, count - begin);
    for (std::size_t i = 0; i < kBlockLanes; ++i) {
      // The last point pads the last block.
      const std::uint32_t index = order[begin + std::min(i, size - 1)];
      points_.x[i] = chunk[index].x();
      points_.y[i] = chunk[index].y();
      points_.z[i] = chunk[index].z();
      rows[i] = static_cast<std::uint32_t>(first + index);
    }
    Aabb block;
    for (int i = 0; i < kBlockLanes; ++i) block.extend(PointOf(i));
    if (!MeasureListed(block) && !MeasureWorld(block)) return false;
    SampleBlock(std::span(rows).first(size), columns);
    if (interrupt_.CountWork(1)) return false;
  }
  return true;
}

void PointSampler::ListNearParts(std::span<const Vector3> chunk) {
  // chosen: the minimum of a few dozen numbers is found faster than a priority queue yields one
  // element.
  constexpr std::size_t kMaxListed = 96;
  Aabb bounds;
  for (const Vector3& p : chunk) bounds.extend(p);
  listed_.clear();
  listed_reach_m_ = limit_m_;
  bool few = true;
  world_.bounds().ForEachNearest(
      bounds, limit_m_ + kKinkTolerance_m, [&](const Obstacle& object, double) {
        for (const SampledPart& part : parts_.PartsOf(object)) {
          listed_.push_back(&part);
          listed_reach_m_ = std::min(listed_reach_m_, FarthestCorner_m(bounds, part.bounds_W()));
        }
        few = listed_.size() <= kMaxListed;
        return few ? listed_reach_m_ + kKinkTolerance_m : -1.0;
      });
  if (!few) listed_reach_m_ = -1;
  listed_gaps_m2_.resize(listed_.size());
}

// Tests the listed parts, nearest first. False if interrupted or if the list does not reach far
// enough.
bool PointSampler::MeasureListed(const Aabb& block) {
  if (listed_reach_m_ < 0) return false;
  for (std::size_t k = 0; k < listed_.size(); ++k) {
    listed_gaps_m2_[k] = SquaredDistance_m2(block, listed_[k]->bounds_W());
  }
  Reset();
  while (true) {
    const auto next = std::min_element(listed_gaps_m2_.begin(), listed_gaps_m2_.end());
    const double reach_m = reach_m_ + kKinkTolerance_m;
    if (next == listed_gaps_m2_.end() || !(*next <= reach_m * reach_m)) break;
    if (std::isinf(*next)) break;  // all listed parts are tested
    *next = std::numeric_limits<double>::infinity();
    if (!MeasurePart(*listed_[static_cast<std::size_t>(next - listed_gaps_m2_.begin())]))
      return false;
  }
  return reach_m_ <= listed_reach_m_;  // the depth of a point inside a solid may be greater
}

void PointSampler::Reset() {
  candidates_.clear();
  nearest_.Clear(limit_m_);
  reach_m_ = limit_m_;
}

// Tests the objects of the world, those with the nearest boxes first, up to the reach of the
// points. False if interrupted.
bool PointSampler::MeasureWorld(const Aabb& block) {
  if (interrupt_.reason() != Interrupt::Reason::kNone) return false;
  Reset();
  bool ended = false;
  world_.bounds().ForEachNearest(
      block, limit_m_ + kKinkTolerance_m, [&](const Obstacle& object, double) {
        for (const SampledPart& part : parts_.PartsOf(object)) {
          const double reach_m = reach_m_ + kKinkTolerance_m;
          if (SquaredDistance_m2(block, part.bounds_W()) > reach_m * reach_m) continue;
          ended = ended || !MeasurePart(part);
        }
        return ended ? -1.0 : reach_m_ + kKinkTolerance_m;
      });
  return !ended;
}

bool PointSampler::MeasurePart(const SampledPart& part) {
  const auto index = static_cast<std::int64_t>(candidates_.size());
  Candidate& candidate = candidates_.emplace_back();
  candidate.part = &part;
  part.Measure(points_, nearest_.reach_m, candidate.distances_m, &interrupt_);
  reach_m_ = UpdateNearest(candidate.distances_m, {part.order(), index}, limit_m_, nearest_);
  // measured: a mesh takes up to milliseconds for a block, other shapes a microsecond or less.
  return !interrupt_.CountWork(part.lanes() != nullptr ? 1 : 64);
}

// Samples together the points that have the same nearest part.
void PointSampler::SampleBlock(std::span<const std::uint32_t> rows, PointColumns& columns) {
  std::uint64_t left =
      rows.size() == kBlockLanes ? ~std::uint64_t{0} : (std::uint64_t{1} << rows.size()) - 1;
  while (left != 0) {
    const std::int64_t candidate = nearest_.candidate[std::countr_zero(left)];
    std::array<int, kSampleLanes> lanes;
    int count = 0;
    for (std::uint64_t rest = left; rest != 0 && count < kSampleLanes; rest &= rest - 1) {
      const int lane = std::countr_zero(rest);
      if (nearest_.candidate[lane] != candidate) continue;
      lanes[static_cast<std::size_t>(count++)] = lane;
      left &= ~(std::uint64_t{1} << lane);
    }
    SampleGroup(lanes.data(), count, rows, columns);
  }
}

void PointSampler::SampleGroup(const int* lanes, int count, std::span<const std::uint32_t> rows,
                               PointColumns& columns) {
  const std::int64_t index = nearest_.candidate[lanes[0]];
  if (index < 0) {  // no part within reach: the other columns keep their zeros
    for (int i = 0; i < count; ++i) columns.state[rows[lanes[i]]] = SampleState::kBeyond;
    return;
  }
  const Candidate& candidate = candidates_[static_cast<std::size_t>(index)];
  const SampledPart& part = *candidate.part;
  if (part.lanes() == nullptr) {
    for (int i = 0; i < count; ++i) {
      Write(lanes[i], SampleOf(candidate, lanes[i]), rows[lanes[i]], columns);
    }
    return;
  }
  LanePoints<kSampleLanes> points;
  for (int i = 0; i < kSampleLanes; ++i) {
    const int lane = lanes[std::min(i, count - 1)];
    points.x[i] = points_.x[lane];
    points.y[i] = points_.y[lane];
    points.z[i] = points_.z[lane];
  }
  LaneSamples samples;
  SampleLanes(*part.lanes(), points, samples);
  for (int i = 0; i < count; ++i) Write(lanes[i], SampleAt(samples, i), rows[lanes[i]], columns);
}

PointSample PointSampler::SampleOf(const Candidate& candidate, int lane) {
  const Vector3 p_W = PointOf(lane);
  const SampledPart& part = *candidate.part;
  if (part.lanes() == nullptr)
    return part.Sample(p_W, candidate.distances_m.lane[lane], &interrupt_);
  LanePoints<kSampleLanes> points;
  std::fill_n(points.x, kSampleLanes, p_W.x());
  std::fill_n(points.y, kSampleLanes, p_W.y());
  std::fill_n(points.z, kSampleLanes, p_W.z());
  LaneSamples samples;
  SampleLanes(*part.lanes(), points, samples);
  return SampleAt(samples, 0);
}

void PointSampler::Write(int lane, const PointSample& sample, std::size_t row,
                         PointColumns& columns) {
  if (sample.distance_m > limit_m_) {
    columns.state[row] = SampleState::kBeyond;
    return;
  }
  const SampledPart& part = *candidates_[static_cast<std::size_t>(nearest_.candidate[lane])].part;
  const bool kink = sample.kink || HasCompetingGradient(lane, sample);
  columns.state[row] = kink ? SampleState::kKink : SampleState::kSmooth;
  columns.distance_m[row] = sample.distance_m;
  std::copy_n(sample.gradient.data(), 3, &columns.gradient[3 * row]);
  columns.object[row] = part.id().object;
  columns.object_part[row] = part.id().part;
  columns.accuracy[row] = part.is_open() ? Accuracy::kSurfaceOnly : Accuracy::kExact;
  const bool is_alone = nearest_.second_m[lane] > -nearest_.best_m[lane] + kTouching_m;
  const bool is_known = !sample.nearest_is_interior && (sample.distance_m >= 0 || is_alone);
  Depth depth{columns.accuracy[row], 0};
  if (!is_known) depth = DepthOf(lane, sample);
  const double least_m = HiddenDistance_m(lane, sample.distance_m);
  if (least_m < sample.distance_m && depth.accuracy <= Accuracy::kBounded) {
    depth = {Accuracy::kBounded, std::max(depth.bound_m, sample.distance_m - least_m)};
  }
  if (world_.has_caps()) {
    const PairDistance answer = WithCapError(
        {.distance_m = sample.distance_m, .accuracy = depth.accuracy, .bound_m = depth.bound_m},
        CapErrorOf(lane, sample.distance_m));
    depth = {answer.accuracy, answer.bound_m};
  }
  columns.accuracy[row] = depth.accuracy;
  if (depth.accuracy == Accuracy::kBounded) {
    bounds_.push_back({static_cast<std::uint32_t>(row), depth.bound_m});
  }
}

CapError PointSampler::CapErrorOf(int lane, double distance_m) {
  const Vector3 p_W = PointOf(lane);
  const double reach_m = std::abs(distance_m);
  CapError error;
  world_.bounds().ForEachNearest(Aabb(p_W, p_W), reach_m, [&](const Obstacle& object, double) {
    for (const SampledPart& part : parts_.PartsOf(object)) {
      const CapError of_part = part.CapErrorAt(p_W, reach_m);
      error.apart_m = std::max(error.apart_m, of_part.apart_m);
      error.depth_m = std::max(error.depth_m, of_part.depth_m);
    }
    return reach_m;
  });
  return error;
}

double PointSampler::HiddenDistance_m(int lane, double distance_m) const {
  const Vector3 p_W = PointOf(lane);
  const Aabb at_W(p_W, p_W);
  double least_m = distance_m;
  for (const HiddenSpace& space : hidden_) {
    if (SquaredDistance_m2(space.bounds_W, at_W) > std::max(0.0, least_m) * std::max(0.0, least_m))
      continue;
    least_m = std::min(least_m, space.Distance_m(p_W));
  }
  return least_m;
}

bool PointSampler::HasCompetingGradient(int lane, const PointSample& sample) {
  const double reach_m = nearest_.best_m[lane] + kKinkTolerance_m;
  if (nearest_.second_m[lane] > reach_m) return false;
  const auto nearest = static_cast<std::size_t>(nearest_.candidate[lane]);
  for (std::size_t k = 0; k < candidates_.size(); ++k) {
    if (k == nearest || candidates_[k].distances_m.lane[lane] > reach_m) continue;
    const PointSample other = SampleOf(candidates_[k], lane);
    if (other.kink || Differ(other.gradient, sample.gradient)) return true;
  }
  return false;
}

// True if another solid covers the end of the way out of the deepest part. Only solids within the
// length of that way are tested.
bool PointSampler::IsCovered(int lane, const Vector3& way_out_W) {
  const double depth_m = -nearest_.best_m[lane];
  const auto nearest = static_cast<std::size_t>(nearest_.candidate[lane]);
  for (std::size_t k = 0; k < candidates_.size(); ++k) {
    const Candidate& other = candidates_[k];
    if (k == nearest || other.part->is_open()) continue;
    if (other.distances_m.lane[lane] > depth_m + kTouching_m) continue;
    if (other.part->Distance_m(way_out_W, &interrupt_) <= kTouching_m) return true;
  }
  return false;
}

// The accuracy of a depth and its bound: the length of any way out of all solids is an upper bound
// of the depth.
PointSampler::Depth PointSampler::DepthOf(int lane, const PointSample& sample) {
  const double depth_m = -sample.distance_m;
  const Vector3 way_out_W = PointOf(lane) + depth_m * sample.gradient;
  if (!sample.nearest_is_interior && !IsCovered(lane, way_out_W)) return {Accuracy::kExact, 0};
  std::optional<double> way_m = ExitDistance_m(lane, sample, sample.gradient);
  if (sample.nearest_is_interior) {  // the way out may lie in either direction
    const std::optional<double> back_m = ExitDistance_m(lane, sample, -sample.gradient);
    if (!way_m || (back_m && *back_m < *way_m)) way_m = back_m;
  }
  if (!way_m) return {Accuracy::kDegraded, 0};
  return {Accuracy::kBounded, *way_m - depth_m};
}

// The length of the way out of all solids along a direction, searched from the surface of the
// deepest part on; empty if none is found.
std::optional<double> PointSampler::ExitDistance_m(int lane, const PointSample& sample,
                                                   const Vector3& direction_W) {
  // chosen: the growing steps reach more than a hundred times as far as the depth, at some
  // microseconds each. A point without a way out by then is considered underground.
  constexpr int kMaxSteps = 16;
  constexpr double kGrowth = 1.6;
  const Vector3 p_W = PointOf(lane);
  const double depth_m = -sample.distance_m;
  double way_m = depth_m, min_step_m = 0.05 * depth_m + kTouching_m;
  if (sample.nearest_is_interior) {
    const auto nearest = static_cast<std::size_t>(nearest_.candidate[lane]);
    const auto exit_m = candidates_[nearest].part->ExitDistance_m(p_W, direction_W, &interrupt_);
    if (exit_m) way_m = std::max(depth_m, *exit_m + 2 * kTouching_m);
  }
  for (int step = 0; step < kMaxSteps; ++step) {
    const double distance_m = SolidDistance_m(p_W + way_m * direction_W);
    if (distance_m > kTouching_m) return way_m;
    way_m += std::max(-distance_m + 2 * kTouching_m, min_step_m);
    min_step_m *= kGrowth;
  }
  return std::nullopt;
}

// The signed distance of the union of all solids if p lies inside; some positive number if outside.
double PointSampler::SolidDistance_m(const Vector3& p_W) {
  double min_m = std::numeric_limits<double>::infinity();
  world_.bounds().ForEachNearest(Aabb(p_W, p_W), 2 * kTouching_m,
                                 [&](const Obstacle& object, double) {
                                   for (const SampledPart& part : parts_.PartsOf(object)) {
                                     if (part.is_open() || !part.bounds_W().contains(p_W)) continue;
                                     min_m = std::min(min_m, part.Distance_m(p_W, &interrupt_));
                                   }
                                   return 2 * kTouching_m;
                                 });
  return min_m;
}

}  // namespace cwm::collision
