// The object modeler (paper, section V): finds the shapes that explain an object's points, its
// handles, and the points that remain for triangulation.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "perception/cloud/oriented_points.h"
#include "perception/cloud/sensor_noise.h"
#include "perception/cloud/work.h"
#include "perception/fit/passing_rays.h"
#include "perception/model/modeler_options.h"
#include "perception/model/object_model.h"

namespace cwm::perception {

// chosen: points, or rays to points, of a whole scene that are processed; a shape of 300 of a
// camera's 300 000 points keeps 40.
inline constexpr std::size_t kMaxScenePoints = 40'000;

// Models one object in the level frame L: z up, any origin. The plane z = 0 of `X_LSupport`, if
// known, is the top of the object's support, and its z axis is the plane's normal (up): solids are
// extended down to it and never below it. `passing` holds rays to what is beside and behind the
// object; no solid may fill the space they crossed. Throws Stopped when `work` is stopped.
ObjectModel ModelObject(const OrientedPoints& points, const std::optional<Pose>& X_LSupport,
                        const SensorNoise& noise, const ModelerOptions& options,
                        const Work& work = {}, const PassingRays& passing = {});

// Returns the closed solid on the support that explains nearly all points; empty if there is none.
// It is a likely shape at less cost than a full model.
std::optional<ShapePart> ModelSingleSolid(const OrientedPoints& points, const Pose& X_LSupport,
                                          const SensorNoise& noise, const ModelerOptions& options,
                                          const Work& work = {});

// Returns the shell of a lying or leaning vessel (FindLyingWall); empty if there is none. Its axis
// is one of `axes`, which are candidates and may be none, or one estimated from the normals.
std::optional<ShapePart> FindLyingVessel(const OrientedPoints& points,
                                         const std::optional<Pose>& X_LSupport,
                                         const std::vector<Vector3>& axes, const SensorNoise& noise,
                                         const ModelerOptions& options, const Work& work = {});

// Models an object whose shapes are known, in the level frame: which points they explain, how well,
// and which parts stand out from them as handles.
ObjectModel ModelFromShapes(const OrientedPoints& points, const std::optional<Pose>& X_LSupport,
                            std::vector<ShapePart> shapes, const Work& work = {});

// Models a wall or a furniture front whose plates are known, in the level frame. The plates are its
// shapes, with the role COMPLETED because their bodies were supplied. It gets no handles:
// FindHandles skips parts whose nearest shape is a plate.
ObjectModel ModelStructure(const OrientedPoints& points, const std::vector<Placed<Plate>>& plates,
                           const Work& work = {});

}  // namespace cwm::perception
