// What lies between places that were seen on one plane: more of the support, or nothing.
#pragma once

#include <cstdint>
#include <span>

#include "perception/cloud/oriented_points.h"
#include "perception/segmentation/plane_fit.h"
#include "perception/segmentation/sight_map.h"

namespace cwm::perception {

// chosen: the width of an object. Where nobody knows where the sensor was, gaps of up to twice this
// are taken for closed: an object of 15 cm and the shadow that it throws at 45 degrees.
inline constexpr double kClosing_m = 0.15;

// Whether the ray to a place on a plane goes on through it: for farther below than a plate is thick
// and than warp of the sensor reaches. Of what is hidden or returned nothing, it does not.
class PassageTest {
 public:
  // `members` are points on the plane; they tell the noise.
  PassageTest(const SightMap& sight, const Plane& plane, const OrientedPoints& points,
              std::span<const std::uint32_t> members);

  bool operator()(const Vector3& place) const;

 private:
  const SightMap& sight_;
  double sensor_height_m_ = 0;  // above the plane
  double depth_m_ = 0;          // below the plane
};

// Whether two sets of points on one plane are one support: their gap is hidden, or returned
// nothing, along most of the lines that cross it (kMainShare). Two tables side by side are two although
// things that stand on them hide some of the gap; of a table with a large object across its middle
// all of the gap is hidden but mixed pixels. Without `sight`, whether the gap is at most
// 2 kClosing_m wide.
bool GapIsClosed(const Plane& plane, const OrientedPoints& points,
                 std::span<const std::uint32_t> larger, std::span<const std::uint32_t> smaller,
                 const SightMap* sight);

}  // namespace cwm::perception
