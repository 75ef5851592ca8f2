// Boxes around the points of things that move and are not modelled.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "perception/live/tracker.h"

namespace cwm::perception {

// chosen: the boxes reach at least this far beyond the points: noise, and the motion until the next
// frame.
inline constexpr double kMoverMargin_m = 0.010;

// Covers all points of each list, given in a frame with the world's axes whose origin is at
// `origin_W`, by boxes along the world's axes: cells of a grid, joined greedily. One piece per
// list, at most kMaxMoverBoxes boxes of all; the cells grow until they suffice. A single point far
// from all others of a list of more than kMinMoverPoints is left out: it is noise.
std::vector<MoverPiece> CoverByBoxes(std::span<const std::vector<Eigen::Vector3f>> lists,
                                     const Vector3& origin_W);
inline constexpr int kMinMoverPoints = 8;

// The share of the points that lie in a box of the pieces; 1 without points.
double CoveredShare(std::span<const MoverPiece> pieces,
                    std::span<const std::vector<Eigen::Vector3f>> lists, const Vector3& origin_W);

// The volume of all boxes, in cubic metres.
double Volume_m3(std::span<const MoverPiece> pieces);

}  // namespace cwm::perception
