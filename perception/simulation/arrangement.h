// Adds objects to a view one after the other, so that they keep apart, stay visible and do not hide
// more of each other than allowed.
#pragma once

#include <optional>
#include <vector>

#include "perception/simulation/simulated_scene.h"

namespace cwm::perception {

struct ArrangementRules {
  double min_gap_m = 0.02;  // between the hulls of two objects, unless they shall touch
  double max_hidden = 0.2;  // share of an object's own silhouette
};

// Index of the object of the scene that a new one may touch, if any.
using Touching = std::optional<std::size_t>;

class Arrangement {
 public:
  // The furniture stays first in the scene; it may be hidden to any extent.
  Arrangement(SimulatedScene furniture, const PinholeCamera& camera, const ArrangementRules& rules);

  const SimulatedScene& scene() const { return scene_; }
  const PinholeCamera& camera() const { return camera_; }
  std::size_t furniture_count() const { return furniture_count_; }
  const SimulatedObject& object(std::size_t index) const { return scene_.objects[index]; }

  // Returns the hidden shares of all objects after the furniture, the new one last. Empty if the
  // rules do not allow to add it, or if the middle of its bounds is outside the image.
  std::optional<std::vector<double>> HiddenSharesWith(const SimulatedObject& candidate,
                                                      Touching touching) const;

  void Add(SimulatedObject object);

  // True if each object after the furniture is visible to the extent that the rules require.
  bool ShowsAll() const;

 private:
  // Depth per pixel of a coarse image; infinite where the object is not visible.
  using Silhouette = std::vector<float>;

  bool KeepsApart(const SimulatedObject& candidate, Touching touching) const;
  Silhouette SilhouetteOf(const SimulatedObject& object) const;

  SimulatedScene scene_;
  PinholeCamera camera_;
  PinholeCamera coarse_camera_;
  ArrangementRules rules_;
  std::size_t furniture_count_ = 0;
  std::vector<Silhouette> silhouettes_;  // per object after the furniture
  Silhouette front_;                     // the nearest depths of all objects, with the furniture
};

}  // namespace cwm::perception
