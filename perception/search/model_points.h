// An object's points as the search and the refinement use them: thinned, near the origin, in Morton
// order, with their gates.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "perception/cloud/oriented_points.h"
#include "perception/cloud/work.h"
#include "perception/search/shape_model.h"

namespace cwm::perception {

// Structure of arrays, all of one length. The frame M is the level frame with its origin moved to
// origin_L, the mean of the points.
struct ModelPoints {
  std::vector<Vector3> p;            // metres, relative to origin_L
  std::vector<Vector3> n;            // unit, towards the sensor
  std::vector<double> sigma_m;       // standard deviation of the range
  std::vector<double> gate_m;        // inliers are at most this far from the surface
  std::vector<double> min_cos;       // least cosine between an inlier's normal and the surface's
  std::vector<std::uint32_t> key;    // Morton key, ascending
  std::vector<std::uint32_t> index;  // into the object's points
  Vector3 origin_L = Vector3::Zero();
  Vector3 viewpoint = Vector3::Zero();  // position of the sensor, relative to origin_L
  double max_gate_m = 0;                // the largest of gate_m
  double weight = 1;                    // measured points per point
  double spacing_m = 0;                 // median distance between neighbours in Morton order

  std::size_t size() const { return p.size(); }
};

// chosen: standard deviations of the range, and of other noise of a surface; 0.3 % of Gaussian
// errors are larger.
inline constexpr double kDistanceGate_sigma = 3;

// derived: levels of the keys, three bits each: cells of 1/1024 of the extent.
inline constexpr int kMortonLevels = std::numeric_limits<std::uint32_t>::digits / 3;

// The cosine of the normal gate: kSameNormal_rad, or 3 standard deviations of the normal if that is
// more, at most 45 degrees, beyond which a gate would not discriminate.
double NormalGate_cos(double normal_sigma_rad);

// Returns every k-th point in Morton order, so that at most `max_points` remain, evenly spread.
// Points that are not finite or have no normal are left out.
ModelPoints SubsampleForSearch(const OrientedPoints& points, std::size_t max_points,
                               const Work& work = {});

// Returns the listed points, in the order of the list, about the same origin.
ModelPoints Subset(const ModelPoints& all, std::span<const std::uint32_t> listed);

// True if the point is inside the distance gate (times `gate_scale`) and the normal gate.
template <ShapeModel M>
bool IsInlier(const M& model, const ModelPoints& points, std::uint32_t i, double gate_scale = 1) {
  const double distance_m = model.Distance_m(points.p[i]);
  if (!(distance_m <= gate_scale * points.gate_m[i] &&
        distance_m >= -gate_scale * points.gate_m[i]))
    return false;
  return model.FacingSign() * model.Normal(points.p[i]).dot(points.n[i]) >= points.min_cos[i];
}

// Returns at most `max_count` of the indices, evenly spread over the list.
std::vector<std::uint32_t> Subsampled(std::span<const std::uint32_t> indices,
                                      std::size_t max_count);

}  // namespace cwm::perception
