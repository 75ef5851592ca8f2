// OBJECT MODELER (paper, section V): the shapes that explain an object's points, its handles, and
// the points that remain for triangulation.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "collision/geometry/hybrid_model.h"
#include "perception/cloud/oriented_points.h"
#include "perception/cloud/sensor_noise.h"
#include "perception/cloud/work.h"

namespace cwm::perception {

struct ModelerOptions {
  bool search_planes = true;
  bool search_cylinders = true;
  bool search_spheres = true;
  bool search_cones = true;
  double max_radius_m = 0.5;  // larger curved shapes are not told from planes at close range
  double min_radius_m = 0.004;
  int min_inliers = 60;                    // a shape must explain at least this many points
  double missed_shape_probability = 0.01;  // of a shape of min_inliers points
  std::uint64_t seed = 1;                  // same seed, same bytes
};

// Index of a point's part: -1 unexplained, 0.. shape, and handles after them.
inline constexpr std::int32_t kUnexplained = -1;

struct ObjectModel {
  std::vector<ShapePart> shapes;  // world frame: X_OS is X_WS here
  std::vector<Handle> handles;    // without meshes
  std::vector<std::int32_t>
      part_of_point;  // per input point: shape index, shapes.size() + handle index, or kUnexplained
  std::vector<std::string> notes;  // caps that fired, in words
};

// `support` is the top plane of what the object stands on (frame W, normal up), where known: solids
// are completed down to it. Solids never extend below it. Throws Stopped when `work` is stopped.
ObjectModel ModelObject(const OrientedPoints& points, const std::optional<Pose>& X_WSupport,
                        const SensorNoise& noise, const ModelerOptions& options,
                        const Work& work = {});

}  // namespace cwm::perception
