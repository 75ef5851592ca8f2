// The shape of a body at rest by what several sensors see of it.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "perception/cloud/point_cloud.h"
#include "perception/live/mean_view.h"
#include "perception/scene_interpretation.h"

namespace cwm::perception {

// The points of a body in all views, with those of what bears it around, as one cloud.
struct FusionCloud {
  PointCloud cloud;              // merged views, in the level frame C of the first view's sensor
  Pose X_WC = Pose::Identity();  // the world's axes, at that sensor
  // The points of the body alone, in that frame, by view.
  std::vector<std::vector<Eigen::Vector3f>> own_C = {};
};

// `bodies` are all that the world holds. Points that another body explains better are left out.
FusionCloud CloudOfBody(std::span<const MeanView> views, const KnownBody& body,
                        std::span<const KnownBody> bodies);

// The object of the interpretation of that cloud which is the body: its model takes the place of
// the body's. Empty if there is none, if what is found is part of it or of more than it, or if its
// model explains the points of any view less well than the body's does.
std::optional<int> FusedObject(const FusionCloud& fused, const SceneInterpretation& scene,
                               const KnownBody& body, const SensorNoise& noise);

}  // namespace cwm::perception
