// OBJECT MODELER (paper, section V): the shapes that explain an object's points, its handles, and
// the points that remain for triangulation.
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

// chosen: of a whole scene so many points, or the rays to them, are looked at: a shape of 300 of a
// camera's 300 000 keeps 40.
inline constexpr std::size_t kMaxOfScene = 40'000;

// Everything in the level frame L: z up, any origin. The z = 0 of `X_LSupport` is the top plane of
// what the object stands on, its z the plane's normal (up), where known: solids are completed down
// to it and never extend below it. `passing`: what was seen beside and behind it tells where no
// solid is. Throws Stopped when `work` is stopped.
ObjectModel ModelObject(const OrientedPoints& points, const std::optional<Pose>& X_LSupport,
                        const SensorNoise& noise, const ModelerOptions& options,
                        const Work& work = {}, const PassingRays& passing = {});

// The one closed solid on the support that accounts for nearly all points, where one does: what they
// are likely to be, for less than a model.
std::optional<ShapePart> ModelOneSolid(const OrientedPoints& points, const Pose& X_LSupport,
                                       const SensorNoise& noise, const ModelerOptions& options,
                                       const Work& work = {});

// The shell of a vessel that lies or leans (FindLyingWall) about one of the axes, which may be none's,
// or one that the normals suggest.
std::optional<ShapePart> FindLyingVessel(const OrientedPoints& points,
                                         const std::optional<Pose>& X_LSupport,
                                         const std::vector<Vector3>& axes, const SensorNoise& noise,
                                         const ModelerOptions& options, const Work& work = {});

// What is known to consist of these shapes, which are in the level frame: which points they explain, how
// well, and what stands out from them as handles do.
ObjectModel ModelKnown(const OrientedPoints& points, const std::optional<Pose>& X_LSupport,
                       std::vector<ShapePart> shapes, const Work& work = {});

// A wall or front of which the plates are known, in the level frame: they are its shapes, COMPLETED
// since their bodies were supplied, and what stands out from them may be handles.
ObjectModel ModelStructure(const OrientedPoints& points, const std::vector<Placed<Plate>>& plates,
                           const Work& work = {});

}  // namespace cwm::perception
