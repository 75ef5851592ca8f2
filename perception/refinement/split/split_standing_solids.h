// Objects that touch are one to the segmentation, and the modeler finds their solids. A solid that
// stands by itself, and has none of its surfaces carried on by another, is an object of its own.
#pragma once

#include <memory>

#include "perception/refinement/pass.h"

namespace cwm::perception {

// Whether two solids on one support may well be one object: cylinders on one axis and of one radius,
// boxes that are level and aligned, within what soft packages bend by, or vessels about one axis.
// Symmetric.
bool CarriesOn(const ShapePart& part, const ShapePart& other, const Pose& X_GroundL);

// Each object of several closed solids, or of several vessels, that all touch what it stands on, or one
// on the top of another, becomes an object for each of them, where each is one solid when modelled by
// itself and none carries another on (in a stack, and of vessels, those that do are one). Lone faces
// beside closed solids go to the solid that they are nearest to.
std::unique_ptr<const RefinementPass> MakeSplitStandingSolids();

}  // namespace cwm::perception
