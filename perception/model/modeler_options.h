// What the object modeler looks for, and how hard.
#pragma once

#include <cstdint>

namespace cwm::perception {

struct ModelerOptions {
  // Each kind can be switched off (paper, section V): nothing of that kind is proposed, grown out
  // of another kind, or kept. Its points go to the kinds that are left where these explain them,
  // else to handles and surfaces. Without planes there are no boxes, no plates, and no discs that
  // cap round solids; without all four no shapes and no handles.
  bool search_planes = true;
  bool search_cylinders = true;
  bool search_spheres = true;
  bool search_cones = true;
  // Whether what was seen as one may be things that touch, parted by upright cuts.
  bool part_touching = true;
  // Whether the points were seen from their viewpoint. Of views that were merged, what lies between
  // proves nothing.
  bool from_viewpoint = true;
  // For small things among more than any scene holds: of whole solids only balls and upright
  // cylinders and boxes, no vessels, and the search for shapes gives up sooner.
  bool in_haste = false;
  double max_radius_m = 0.5;  // larger curved shapes are not told from planes at close range
  // Chosen: what is thinner shows five pixels of a Kinect at 0.8 m or fewer across.
  double min_radius_m = 0.004;
  // A shape must explain at least this many points: five independent ones, as many as a cylinder
  // has parameters (kPointsPerIndependentSample).
  int min_inliers = 60;
  double missed_shape_probability = 0.01;  // of a shape of min_inliers points
  std::uint64_t seed = 1;                  // same seed, same bytes
};

// Without that there are no handles and no vessels either.
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
