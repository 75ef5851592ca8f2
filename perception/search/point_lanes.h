// The points of a search side by side, so that four of them are tested at once: where the search
// spends most of its time.
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
  std::uint32_t at = 0;  // its place in the PointLanes
  double distance_m = 0;
};

// As of ModelPoints, with PointLanes::kMaxLanes more entries at the end, so that the last group can
// be read.
struct PointArrays {
  std::vector<double> x, y, z, nx, ny, nz, gate_m, min_cos;
};

// Structure of arrays; holds copies of what the gates need.
class PointLanes {
 public:
  // Points that are tested at once are no more: vectors of Highway's are capped at it.
  static constexpr std::size_t kMaxLanes = 4;  // cited: doubles of an AVX register, 32 bytes

  // From `begin` to before `end`.
  struct Range {
    std::size_t begin = 0, end = 0;
  };

  PointLanes() = default;
  // The points in their order.
  explicit PointLanes(const ModelPoints& points);
  // The listed ones, in the order of the list.
  PointLanes(const ModelPoints& points, std::span<const std::uint32_t> listed);

  std::size_t size() const { return size_; }

  // The points in the ranges for which IsInlier (model_points.h) holds, in the order of the ranges,
  // with the very bits of the model's Distance_m: whichever way a point is tested, and on whichever
  // processor, the answer is the same.
  std::vector<Hit> HitsIn(const AnyModel& model, std::span<const Range> ranges,
                          double gate_scale = 1) const;

 private:
  void Add(const ModelPoints& points, std::uint32_t i);
  void Pad();

  std::size_t size_ = 0;
  PointArrays arrays_;
};

}  // namespace cwm::perception
