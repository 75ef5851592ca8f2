// Objects that are put into a view one after the other, so that they keep apart, stay in sight and
// hide no more of each other than is wanted.
#pragma once

#include <optional>
#include <vector>

#include "perception/simulation/simulated_scene.h"

namespace cwm::perception {

struct ArrangementRules {
  double least_gap_m = 0.02;  // between the hulls of two objects, but where they shall touch
  double most_hidden = 0.2;   // share of what would be seen of an object alone
};

// Which object of the scene a new one may touch, if any.
using Touching = std::optional<std::size_t>;

class Arrangement {
 public:
  // The furniture stays first in the scene; how much of it is hidden does not matter.
  Arrangement(SimulatedScene furniture, const PinholeCamera& camera, const ArrangementRules& rules);

  const SimulatedScene& scene() const { return scene_; }
  const PinholeCamera& camera() const { return camera_; }
  std::size_t furniture_count() const { return furniture_count_; }
  const SimulatedObject& object(std::size_t index) const { return scene_.objects[index]; }

  // The hidden shares of all the objects after the furniture, with the new one at the end; nothing
  // when the rules forbid to add it, or when the image does not hold the middle of its bounds.
  std::optional<std::vector<double>> HiddenSharesWith(const SimulatedObject& candidate,
                                                      Touching touching) const;

  void Add(SimulatedObject object);

  // True when the image shows as much of each object after the furniture as the rules ask for.
  bool ShowsAll() const;

 private:
  // Depth per pixel of a coarse image; infinite where the object is not seen.
  using Silhouette = std::vector<float>;

  bool KeepsApart(const SimulatedObject& candidate, Touching touching) const;
  Silhouette SilhouetteOf(const SimulatedObject& object) const;

  SimulatedScene scene_;
  PinholeCamera camera_;
  PinholeCamera coarse_camera_;
  ArrangementRules rules_;
  std::size_t furniture_count_ = 0;
  std::vector<Silhouette> silhouettes_;  // of the objects after the furniture
  Silhouette front_;                     // the nearest of all, furniture too
};

}  // namespace cwm::perception
