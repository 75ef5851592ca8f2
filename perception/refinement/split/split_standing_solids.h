// Splits touching objects that segmentation made one. The modeler finds their solids. A solid that
// stands by itself, without another that continues one of its surfaces, is an object.
#pragma once

#include <memory>

#include "perception/refinement/pass.h"

namespace cwm::perception {

// True if two solids on one support may be one object: cylinders with one axis and radius, boxes
// with parallel faces and tops at one height (within the bending of soft packages), or vessels
// about one axis. It does not check if they are in contact. Symmetric.
bool ContinuesSurface(const ShapePart& part, const ShapePart& other, const Pose& X_GroundL);

// Splits an object of several closed solids, or of several vessels, that all touch its ground or
// the top of one another, into one object for each of them, if each is one solid when modelled by
// itself and none continues another (in a stack, and of vessels, those that do are one object).
// Each point of a single face beside closed solids goes to the nearest solid, so a face may be
// divided.
std::unique_ptr<const RefinementPass> MakeSplitStandingSolids();

}  // namespace cwm::perception
