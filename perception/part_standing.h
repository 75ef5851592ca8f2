// Things that touch are one to the segmentation, and the modeler finds their solids. What stands by
// itself, and has none of its surfaces carried on by another, is an object of its own.
#pragma once

#include <vector>

#include "perception/model_thing.h"

namespace cwm::perception {

// Whether two solids on one support may well be one thing: cylinders on one axis and of one radius,
// boxes that are level and aligned, within what soft packages bend by, or vessels about one axis. Symmetric.
bool CarriesOn(const ShapePart& part, const ShapePart& other, const Pose& X_SupportO);

// `modelled` are the scene's things, one for one. Each object of several solids that all touch what it
// stands on, or one on the top of another, becomes an object for each of them, where each is one solid when
// modelled by itself: all of them vessels or none, nothing as thin as a face, and none that carries another
// on (in a stack, and of vessels, those that do are one). Throws Stopped when `work` is stopped.
void PartStanding(const InterpretOptions& options, const Work& work, SegmentedScene& scene,
                  std::vector<ModelledThing>& modelled);

}  // namespace cwm::perception
