// The range that the sensor saw in each direction; distinguishes hidden places from empty ones.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "perception/cloud/oriented_points.h"

namespace cwm::perception {

enum class Visibility {
  kSeenThrough,  // the ray continued behind the place, which is free space
  kOnSurface,    // the ray ended at the place
  kHidden,       // the ray ended before the place
  kNoReturn      // no return in that direction
};

// Nearest range per direction, on a square map of the sphere around the viewpoint (octahedral
// projection: no pole, no trigonometry). Works for images, scans and shuffled clouds alike.
class SightMap {
 public:
  // `pitch_rad` is the angular size of a cell: about two pixels, so that few cells stay empty.
  SightMap(const OrientedPoints& points, float pitch_rad);

  Visibility VisibilityAt(const Eigen::Vector3f& place, float tolerance_m) const;

  const Eigen::Vector3f& viewpoint() const { return viewpoint_; }
  float pitch_rad() const { return 2 / static_cast<float>(cells_per_side_); }  // of a cell, about

 private:
  std::size_t CellOf(const Eigen::Vector3f& direction) const;

  Eigen::Vector3f viewpoint_;
  int cells_per_side_;
  std::vector<float> nearest_m_;  // infinity without a return
};

// chosen: lines of sight that test the space between two places, and places along each line (the
// first is an end); a share of the lines is known to 6 percent, of the places to one.
inline constexpr std::size_t kLinesOfSight = 48;
inline constexpr int kPlacesPerLineOfSight = 8;
// derived: prime to kLinesOfSight, so that each point is paired with many of the other set.
inline constexpr std::size_t kLineStride = 19;

// The places on straight lines between points of two sets: how many are seen through, are hidden,
// and were looked at.
struct PlacesBetween {
  int through = 0, hidden = 0, seen = 0;
};
PlacesBetween CountBetween(const SightMap& sight, const OrientedPoints& points,
                           const std::vector<std::uint32_t>& a,
                           const std::vector<std::uint32_t>& b);

// chosen: evenly spread nodes of an object or a cloud that are tested. For an object that fills the
// view of a Kinect at 1 m these are two per cell of its footprint, for one below 30 cm there all.
inline constexpr std::size_t kMaxTestedNodes = 20'000;

// True if all points may have been seen from the viewpoint: a ray has one return, so that hardly any
// two points lie in one direction at different ranges, unlike in clouds merged from several views.
bool IsSeenFromOnePlace(const OrientedPoints& points);

}  // namespace cwm::perception
