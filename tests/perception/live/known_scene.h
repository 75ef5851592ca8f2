// Simulated scenes as known bodies, and what a camera measures of them.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "perception/live/depth_image.h"
#include "perception/live/known_body.h"
#include "perception/simulation/random_scenes.h"
#include "perception/simulation/range_image.h"

namespace cwm::perception {

inline DepthCamera CameraOf(const PinholeCamera& camera) {
  return {.pinhole = {.focal_u_px = camera.focal_px,
                      .focal_v_px = camera.focal_px,
                      .center_u_px = camera.center_x_px,
                      .center_v_px = camera.center_y_px},
          .width = camera.width,
          .height = camera.height};
}

// The scene's objects with their indices as ids.
inline std::vector<KnownBody> KnownBodies(const SimulatedScene& scene) {
  std::vector<KnownBody> bodies;
  for (const SimulatedObject& object : scene.objects) {
    auto model = std::make_shared<HybridModel>();
    for (const Placed<>& part : object.parts) {
      model->shapes.push_back({.X_OS = part.X_FS, .shape = part.shape});
    }
    bodies.push_back(
        {.id = static_cast<BodyId>(bodies.size()),
         .kind = object.is_support ? KnownBody::Kind::kSupport : KnownBody::Kind::kObject,
         .name = object.name,
         .X_WB = object.X_WO,
         .model = std::move(model)});
  }
  return bodies;
}

}  // namespace cwm::perception
