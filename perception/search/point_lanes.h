// The points of a search as a structure of arrays, so that four of them are tested at once: the
// search spends most of its time there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "perception/search/any_model.h"
#include "perception/search/model_points.h"

namespace cwm::perception {

// A point within both gates of a model.
struct Hit {
  std::uint32_t at = 0;  // index in the PointLanes
  double distance_m = 0;
};

// The arrays of ModelPoints with PointLanes::kMaxLanes more entries at the end, so that the last
// group can be read.
struct PointArrays {
  std::vector<double> x, y, z, nx, ny, nz, gate_m, min_cos;
};

// Structure of arrays; holds copies of what the gates need.
class PointLanes {
 public:
  // The largest number of points in a vector of Highway's: wider registers are not filled.
  static constexpr std::size_t kMaxLanes = 4;  // cited: doubles of an AVX register, 32 bytes

  // From `begin` to before `end`.
  struct Range {
    std::size_t begin = 0, end = 0;
  };

  PointLanes() = default;
  // All points, in their order.
  explicit PointLanes(const ModelPoints& points);
  // The listed points, in the order of the list.
  PointLanes(const ModelPoints& points, std::span<const std::uint32_t> listed);

  std::size_t size() const { return size_; }

  // Returns the points in the ranges for which IsInlier (model_points.h) holds, in the order of the
  // ranges, with the exact bits of the model's Distance_m: the result is the same for every way of
  // testing a point and on every processor.
  std::vector<Hit> HitsIn(const AnyModel& model, std::span<const Range> ranges,
                          double gate_scale = 1) const;

 private:
  void Add(const ModelPoints& points, std::uint32_t i);
  void Pad();

  std::size_t size_ = 0;
  PointArrays arrays_;
};

}  // namespace cwm::perception
