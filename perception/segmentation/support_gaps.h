// Decides whether a gap between places seen on one plane is free, or more of the support.
#pragma once

#include <cstdint>
#include <span>

#include "perception/cloud/oriented_points.h"
#include "perception/segmentation/plane_fit.h"
#include "perception/segmentation/sight_map.h"

namespace cwm::perception {

// chosen: the width of an object. If the sensor's place is unknown, gaps of up to twice this width
// count as closed: an object of 15 cm and its shadow at 45 degrees.
inline constexpr double kClosing_m = 0.15;

// True if the ray to a place on a plane continues through it, farther below it than the thickness
// of a plate and the sensor's warp. False if the place is hidden or gave no return.
class PassageTest {
 public:
  // `members` are points on the plane that the noise is taken from
  PassageTest(const SightMap& sight, const Plane& plane, const OrientedPoints& points,
              std::span<const std::uint32_t> members);

  bool operator()(const Vector3& place) const;

 private:
  const SightMap& sight_;
  double sensor_height_m_ = 0;  // above the plane
  double depth_m_ = 0;          // below the plane
};

// True if two sets of points on one plane belong to one support: their gap is hidden, or gave no
// return, along most of the lines that cross it (kMainShare). Two tables side by side stay two
// although objects on them hide a part of the gap; a large object across the middle of a table
// hides all of the gap but mixed pixels. If `sight` is null: true if the gap is at most 2
// kClosing_m wide.
bool IsGapClosed(const Plane& plane, const OrientedPoints& points,
                 std::span<const std::uint32_t> larger, std::span<const std::uint32_t> smaller,
                 const SightMap* sight);

}  // namespace cwm::perception
