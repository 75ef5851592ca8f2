// One thing of the scene becomes a hybrid model: shapes, handles, and meshes for what is left.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "perception/interpret_scene.h"
#include "perception/model/object_model.h"
#include "perception/scene/segment_scene.h"
#include "perception/scene_rays.h"

namespace cwm::perception {

// One thing, modelled. Everything but points_L in the object's frame, whose origin is the mean of
// its points in the level frame, axes parallel to it.
struct ModelledThing {
  Pose X_LO = Pose::Identity();
  std::shared_ptr<HybridModel> model;
  std::vector<std::int32_t> part_of_point;
  std::vector<Eigen::Vector3f> thinned_L;
  std::uint64_t explained = 0;
  std::vector<std::string> notes;
  // Its shapes are simpler standing on the support than on what seemed to lie between: that hides
  // its foot.
  bool reaches_support = false;
};

// The top of its support or of what lies between (z up, in the level frame); nothing where that is
// unknown.
std::optional<Pose> WhatItStandsOn(const SegmentedScene& scene, const SegmentedThing& thing);

// Whether it is a single shape that explains so much of the points.
bool IsOneSolid(const std::vector<ShapePart>& shapes,
                const std::vector<std::int32_t>& part_of_point, double least_explained);

// Steps 6 to 8 (paper, section III) for one thing of the scene, whose rays are `rays`. Throws Stopped
// when `work` is stopped.
ModelledThing ModelThing(const SegmentedScene& scene, std::size_t index, const SceneRays& rays,
                         const InterpretOptions& options, const Work& work);
// Nothing, and no surfaces made in vain, where `wanted` is false of the shapes.
using WantedShapes = std::function<bool(const ObjectModel&)>;
std::optional<ModelledThing> ModelThingIf(const WantedShapes& wanted, const SegmentedScene& scene,
                                          std::size_t index, const SceneRays& rays,
                                          const InterpretOptions& options, const Work& work);
// The same of a thing whose shapes are known, in the level frame.
ModelledThing ModelThingAs(std::vector<ShapePart> shapes, const SegmentedScene& scene,
                           std::size_t index, const InterpretOptions& options, const Work& work);

}  // namespace cwm::perception
