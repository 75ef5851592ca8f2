// What the sensor saw in each direction: tells places that are hidden from places that are empty.
#pragma once

#include <cstddef>
#include <vector>

#include "perception/cloud/oriented_points.h"

namespace cwm::perception {

enum class Visibility {
  kSeenThrough,  // the ray went on behind the place: nothing is there
  kOnSurface,    // the ray ended there
  kHidden,       // the ray ended before
  kNoReturn      // nothing came back in that direction
};

// Nearest range per direction, on a square map of the sphere around the viewpoint (octahedral
// projection: no pole, no trigonometry). Works for images, scans and shuffled clouds alike.
class SightMap {
 public:
  // `pitch_rad` is the size of a cell of directions: about two pixels, so that few cells stay
  // empty.
  SightMap(const OrientedPoints& points, float pitch_rad);

  Visibility Look(const Eigen::Vector3f& place, float tolerance_m) const;

  const Eigen::Vector3f& viewpoint() const { return viewpoint_; }
  float pitch_rad() const { return 2 / static_cast<float>(cells_per_side_); }  // of a cell, about

 private:
  std::size_t CellOf(const Eigen::Vector3f& direction) const;

  Eigen::Vector3f viewpoint_;
  int cells_per_side_;
  std::vector<float> nearest_m_;  // infinity where nothing was seen
};

// chosen: lines of sight that tell what is between two places, and places along each (the first is
// an end): a share of the lines is known to 6 percent, of the places to one.
inline constexpr std::size_t kLinesOfSight = 48;
inline constexpr int kPlacesPerLineOfSight = 8;
// derived: prime to kLinesOfSight: pairs each point with many of the other set.
inline constexpr std::size_t kLineStride = 19;

// chosen: nodes of an object or of a cloud, evenly spread, that are asked where they are. Of an
// object two in each cell of a footprint where one fills the view of a Kinect at 1 m, all of them
// of what is smaller than 30 cm there.
inline constexpr std::size_t kMaxNodesAsked = 20'000;

// Whether all may have been seen from the viewpoint: few places lie behind others in its view, as
// they do where views from elsewhere were merged. `pitch_rad` as of a map of them.
bool IsSeenFromOnePlace(const OrientedPoints& points, float pitch_rad);

}  // namespace cwm::perception
