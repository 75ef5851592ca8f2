// The part of an interpretation that a moving sensor adds to the known world.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "collision/geometry/aabb.h"
#include "perception/live/frame_evidence.h"
#include "perception/scene_interpretation.h"

namespace cwm::perception {

// A known body that goes on where the sensor had not seen it.
struct GrownBody {
  BodyId body = kNoBody;
  std::shared_ptr<const HybridModel> model = {};  // of before, with the parts that are new
  // The supports of the interpretation that are parts of it now.
  std::vector<int> supports = {};
};

struct NewSurfaces {
  std::vector<GrownBody> grown = {};
  // Blocks of the view with objects that are left to a later frame.
  std::vector<std::int32_t> cut_blocks = {};
};

// Leaves in the scene what is new in it, and tells which known bodies grow.
//   * What known bodies explain by half, and a plane that they explain but for a small part, is
//     known: the rest is its fringe. The tolerance is that of noise and of the sensor's pose.
//   * A support or a plane that continues a known one, coplanar and beside it, is a part of that.
//   * Residuals that touch each other are one, planes only with planes that they continue.
//   * An object that the border of the view cuts is seen whole later.
//   * An object on the way of a body that moved since the frame may be that body.
// The bodies are those of the frame; `ways_W` hold those that moved since, at both places. The
// supports of the scene stay, its labels are dropped.
NewSurfaces FindNewSurfaces(const FrameEvidence& frame, std::span<const KnownBody> bodies,
                            std::span<const Aabb> ways_W, SceneInterpretation& scene);

}  // namespace cwm::perception
