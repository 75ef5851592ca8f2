// Options of the object modeler: the kinds of shapes that it seeks, and its effort.
#pragma once

#include <cstdint>

namespace cwm::perception {

struct ModelerOptions {
  // Each kind can be switched off (paper, section V): nothing of that kind is proposed, grown out
  // of another kind, or kept. Its points go to the remaining kinds if these explain them, else to
  // handles and surfaces. Without planes there are no boxes, no plates, and no discs that cap round
  // solids; without all four there are no shapes and no handles.
  bool search_planes = true;
  bool search_cylinders = true;
  bool search_spheres = true;
  bool search_cones = true;
  // True if an object may be split by upright cuts into several that touch.
  bool split_touching = true;
  // True if all points were seen from their viewpoint. In merged views the space before a point is
  // not known to be free.
  bool from_viewpoint = true;
  // Reduced effort, for small objects in a scene with too many of them: closed solids are only
  // balls and upright cylinders and boxes, there are no vessels, and the search for shapes gives up
  // sooner.
  bool reduced_effort = false;
  double max_radius_m = 0.5;  // larger ones look like planes at close range
  // chosen: a thinner part is at most five pixels of a Kinect wide at 0.8 m.
  double min_radius_m = 0.004;
  // A shape must explain at least this many points: five independent ones, as many as a cylinder
  // has parameters (kPointsPerIndependentSample).
  int min_inliers = 60;
  double missed_shape_probability = 0.01;  // probability of missing a shape of min_inliers points
  std::uint64_t seed = 1;                  // same seed, same bytes
};

// True if any kind is sought. Otherwise there are no handles and no vessels either.
inline bool SearchesAny(const ModelerOptions& options) {
  return options.search_planes || options.search_cylinders || options.search_spheres ||
         options.search_cones;
}

inline ModelerOptions WithoutSearch(ModelerOptions options) {
  options.search_planes = options.search_cylinders = false;
  options.search_spheres = options.search_cones = false;
  return options;
}

}  // namespace cwm::perception
