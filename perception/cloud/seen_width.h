// Sizes as the sensor sees them, across the ray: there a camera's pixels are equally far apart,
// however slanted or bent the surface is.
#pragma once

#include <span>
#include <vector>

#include "perception/cloud/oriented_points.h"

namespace cwm::perception {

// measured: the quantile of the points per cell that a cell wholly inside a cluster holds. Border
// cells, which are half of all cells across a slender cluster, are partly empty.
inline constexpr double kFullCell = 0.75;
// chosen: fewer points may be in a cell by chance.
inline constexpr int kMinPointsPerCell = 4;

// The distance between neighbouring points across the ray to their middle, in metres, for the
// denser half of the cluster. Zero without points.
double SeenPitch_m(std::span<const Eigen::Vector3f> points, const Vector3& viewpoint);

// The diameter of the largest disc across the ray, about one of the points, that they fill as
// densely as most are surrounded within 5 mm. For a strip it is 1.35 times the width, because a
// disc may reach beyond the strip.
double SeenWidth_m(std::span<const Eigen::Vector3f> points, const Vector3& viewpoint);

// One flag per point: 1 if it lies within `beside_m` of such a disc of this diameter, so the
// cluster is that wide there.
std::vector<char> MarkWideParts(std::span<const Eigen::Vector3f> points, const Vector3& viewpoint,
                                double diameter_m, double beside_m);

}  // namespace cwm::perception
