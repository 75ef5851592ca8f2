// The shape of a body at rest by what several sensors see of it.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "perception/cloud/point_cloud.h"
#include "perception/live/mean_view.h"
#include "perception/live/view_offsets.h"
#include "perception/scene_interpretation.h"

namespace cwm::perception {

// The points of a body in all views, with those of what bears it around, as one cloud. The offset
// of each view (ViewOffsets_m) is taken off its points.
struct FusionCloud {
  PointCloud cloud;              // merged views, in the level frame C of the first view's sensor
  Pose X_WC = Pose::Identity();  // the world's axes, at that sensor
  // The points of the body alone, in that frame, by view.
  std::vector<BodyView> own_C = {};
};

// The bodies that are parts of a body, though they were published beside it: one view showed them as
// things of their own. Nearly all of such a body's surface lies in the solid of the other one within
// noise, and most of it without; and nearly all of its points in the views lie on the surface of that
// one, within noise. Supports, movers and what users own are no parts. `bodies` are all that the
// world holds.
std::vector<BodyId> PartsOf(std::span<const MeanView> views, const KnownBody& body,
                            std::span<const KnownBody> bodies);

// `bodies` are all that the world holds. Points that another body explains better are left out.
FusionCloud CloudOfBody(std::span<const MeanView> views, const KnownBody& body,
                        std::span<const KnownBody> bodies);

// The object of the interpretation of that cloud which is the body: its model takes the place of
// the body's, without the surfaces that lie on a support of `bodies` within noise: the warp of each
// view raises other parts of it. Empty if there is no such object, if what is found is part of it or
// of more than it, or if its model explains the points of any view less well than the body's does.
std::optional<DetectedObject> FusedObject(const FusionCloud& fused,
                                          const SceneInterpretation& scene, const KnownBody& body,
                                          std::span<const KnownBody> bodies,
                                          const SensorNoise& noise);

}  // namespace cwm::perception
