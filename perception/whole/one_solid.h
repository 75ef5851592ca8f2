// The last word on an object: whether one closed solid, fitted to all of its points, accounts for
// them better than the solids that were assembled wall by wall and face by face.
#pragma once

#include <optional>
#include <vector>

#include "perception/solids/solid_assembly.h"
#include "perception/whole/whole_fit.h"

namespace cwm::perception {

// Solids replace others where their value is at most this share of the others' value. kBetter holds
// for a cylinder in place of a cylinder, and for several solids in place of several; kMuchBetter for
// other solids of one kind, and for several in place of one, as the slow warp bends a face more than
// the criterion expects.
// chosen: with 1 for cylinders, cans of the simulator are known still better, and tins on real scans
// worse. With 0.95 for several and 0.85 in place of one the labelled Kinect scans are parted as with
// 0.8 and 0.6; of simulated things that touch more stay one the less is allowed.
inline constexpr double kBetter = 0.9, kMuchBetter = 0.8;

// chosen: of the rays beside and behind a solid, those that enter it: mixed pixels, and silhouettes
// that are 2 mm off. Thin boxes hold none of them deep, but are as wide as their outermost points.
inline constexpr double kMaxPassedBeside = 0.2;

// Whether one of them lies by a quarter or more in another, deeper than noise puts it: no two
// things are in one place.
bool AnyOverlap(const std::vector<Solid>& solids);

// Whether the points of a thin box are as flat as noise and the sensor's slow warp leave a face:
// all of a wall that is bent by no more than the box is thick would lie within the gates of its two
// faces. Thicker boxes and other solids are.
bool LooksFlat(const Solid& solid, const FitContext& context);

// Of assembled solids, with as many parameters as they have.
Account AccountOf(const std::vector<Solid>& solids, const FitContext& context);

// The one closed solid that accounts for the context's points better than `solids`, by more than
// kPositive (a cone by anything), if any does, and no ray contradicts it. Of the kind of the only
// one of them it must account for them better by far, by a tenth where it has a lid. Round ones are
// where more of the points have them (FitToMore).
std::optional<WholeFit> BetterSolid(const FitContext& context, const std::vector<Solid>& solids);

// The solid of the same kind that accounts best for other points, the context's: most of those that
// it was fitted to. Nothing where that is no better than none, or a ray contradicts it.
std::optional<WholeFit> FittedAnew(const WholeFit& fit, const FitContext& context);

// The solid, with the standard deviations of its parameters.
Solid Described(WholeFit fit, const FitContext& context);

// Replaces the solids of an object on a known ground by one where the criterion prefers it
// decisively and no ray contradicts it, as BetterSolid does. Solids that overlap account for
// nothing.
void PreferOneSolid(const FitContext& context, Assembly& assembly);

}  // namespace cwm::perception
