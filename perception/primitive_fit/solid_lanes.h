// Signed distances of many places to one solid, four places at once: what a descent asks for again
// and again.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "collision/geometry/pose.h"
#include "collision/geometry/shape.h"

namespace cwm::perception {

struct PlaceArrays {
  std::vector<double> x, y, z;  // padded to full groups
};

// Structure of arrays: the places are copied once for all solids.
class PlaceLanes {
 public:
  // Places that are asked about at once are no more: vectors of Highway's are capped at it.
  static constexpr std::size_t kMaxLanes = 4;  // cited: doubles of an AVX register, 32 bytes

  PlaceLanes() = default;
  explicit PlaceLanes(std::span<const Vector3> places);

  std::size_t size() const { return size_; }

  // To the surface of a ball, cylinder, cone or box; negative inside. SignedDistance_m of each
  // place, but for rounding. X_SP is of the frame of the places, `distance_m` as long as they are
  // many.
  void DistancesTo(const Shape& solid, const Pose& X_SP, std::span<double> distance_m) const;

 private:
  std::size_t size_ = 0;
  PlaceArrays arrays_;
};

}  // namespace cwm::perception
