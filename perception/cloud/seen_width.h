// Sizes as the sensor sees them, across the ray: a camera's pixels lie equally far apart there,
// however slanted or bent the surface is that they show.
#pragma once

#include <span>
#include <vector>

#include "perception/cloud/oriented_points.h"

namespace cwm::perception {

// measured: quantile of the points per cell that a cell wholly inside holds; those at the border,
// half of all across a slender cluster, are partly empty.
inline constexpr double kFullCell = 0.75;
// chosen: fewer points are in a cell or not by chance.
inline constexpr int kPointsOfCell = 4;

// Distance between neighbouring points across the ray to their middle, metres; of the denser half
// of what is seen. Zero without points.
double SeenPitch_m(std::span<const Eigen::Vector3f> points, const Vector3& viewpoint);

// Diameter of the largest disc across the ray, about one of the points, that they fill as densely
// as most are surrounded within 5 mm: of a strip, 1.35 times its width, as a disc may jut out of it.
double SeenWidth_m(std::span<const Eigen::Vector3f> points, const Vector3& viewpoint);

// Per point whether it lies within `beside_m` of such a disc of this diameter: 1 where what is seen
// is as wide.
std::vector<char> SeenAsWide(std::span<const Eigen::Vector3f> points, const Vector3& viewpoint,
                             double diameter_m, double beside_m);

}  // namespace cwm::perception
