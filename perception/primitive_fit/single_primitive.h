// The last stage of an object's fit: replaces the solids that were assembled from walls and faces
// by one closed solid fitted to all points, if that one explains the points better.
#pragma once

#include <optional>
#include <vector>

#include "perception/primitive_fit/primitive_fit.h"
#include "perception/solids/solid_assembly.h"

namespace cwm::perception {

// A whole solid replaces a single assembled solid of the same kind only if its value is less than
// this share of the old one: kMaxCylinderValueRatio for cylinders, kMaxValueRatio for boxes and
// spheres, because the slow warp bends a face more than the criterion expects. Cones need no
// margin.
// chosen: with 1 for cylinders, simulated cans are estimated still better, and tins on real scans
// worse. The limits for several solids are in split_solids.cc.
inline constexpr double kMaxCylinderValueRatio = 0.9, kMaxValueRatio = 0.8;

// chosen: as a share of the rays beside and behind a solid. Rays may enter it as mixed pixels, or
// because its silhouette is off by 2 mm. No ray runs deep in a thin box, but its outline follows
// the outermost points.
inline constexpr double kMaxPassedBeside = 0.2;

// True if more than a quarter of one solid's volume lies more than kMaxDepth_m deep in another. Two
// objects cannot occupy the same place.
bool AnyOverlap(const std::vector<Solid>& solids);

// True unless the solid is a thin box whose points bend more than noise and the sensor's slow warp
// bend a flat face. All points of a curved wall lie within the gates of the two faces of a box that
// is as thick as the wall bends. Thicker boxes and other solids always pass.
bool LooksFlat(const Solid& solid, const FitContext& context);

// The criterion's value and the loss of assembled solids, with the sum of their parameters.
FitScore FitScoreOf(const std::vector<Solid>& solids, const FitContext& context);

// Returns the closed solid that explains the context's points better than `solids` do and that no
// ray contradicts; empty if there is none. Its value must be lower by more than kPositive, or by
// anything if it is a cone or has fewer parameters. If `solids` is a single solid, a solid of the
// same kind must keep the ratios above instead, and one of another kind must also beat the best fit
// of that kind by as much. Round solids are refined on more of the points (RefineOnMorePoints).
std::optional<PrimitiveFit> FindBetterPrimitive(const FitContext& context,
                                                const std::vector<Solid>& solids);

// Fits a solid of the same kind, starting from `fit`, to the context's points, which are most of
// those that `fit` was fitted to. Empty if it is no better than no solid at all, or if a ray
// contradicts it.
std::optional<PrimitiveFit> Refit(const PrimitiveFit& fit, const FitContext& context);

// The solid with the standard deviations of its parameters.
Solid WithParameterSigmas(PrimitiveFit fit, const FitContext& context);

// Replaces the solids of an object on a known ground by one solid if FindBetterPrimitive finds one
// (or a single round face by a disc); else replaces each of several solids by a better one, if
// there is one, for the points nearest to it. Overlapping solids are compared as if they explained
// nothing.
void ReplaceBySinglePrimitive(const FitContext& context, Assembly& assembly);

}  // namespace cwm::perception
