// Tests and measures of hypotheses and their models that passes share.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "perception/cloud/tolerances.h"
#include "perception/hypotheses/scene_state.h"
#include "perception/refinement/pass.h"
#include "perception/solids/plane_solid.h"
#include "perception/vessels/revolved_wall.h"

namespace cwm::perception {

// derived: the number of tested points at which a share is known to 0.06.
inline constexpr std::size_t kMaxTestedPoints = 64;
// chosen: the largest number of touching hypotheses that are examined together; bounds the work in
// clutter.
inline constexpr std::size_t kMaxGroupSize = 12;

// chosen: the largest extent of a tabletop object: a pan with its handle, a moving box.
inline constexpr double kMaxObjectSize_m = 0.7;
// derived: a single face is modelled half as thick, and noise adds to it.
inline constexpr double kMaxLoneThickness_m = kLoneThickness_m * 2;
// chosen: nearer faces are the same face, by noise, warp and bent cardboard; flat objects are
// thicker.
inline constexpr double kMaxSameFaceGap_m = 0.015;
// derived: the largest gap between the ends of objects that touch: the distance within which a
// surface explains points. Noise, creases and feet that were not seen move the ends by as much.
inline constexpr double kMaxContactGap_m = kExplainedWithin_m;
// chosen: the distance between the axes of objects in a stack, or of parts of one object: soft
// packages bend, and the sensor warps everything.
inline constexpr double kMaxAxisOffset_m = 0.012;
// chosen: 14 degrees: an axis within it is upright, and axes within it belong to one object.
inline constexpr double kAligned_cos = 0.97;

// True if one shape explains at least this share of the points.
bool IsSingleSolid(const ObjectModel& model, double min_explained = kNearlyAll);

// True if the normal is that of a level face, within the error of normals.
bool IsLevel(const Eigen::Vector3f& normal, const Eigen::Vector3f& up);

// True for shapes that enclose a measured volume. Vessels are open, and single faces are given 5
// mm.
bool IsClosed(const ShapePart& shape);

// Truncated mean square of the distances of points from the nearest solid, in standard deviations.
double MisfitOf(const std::vector<ShapePart>& shapes, const PointSet& points,
                const OrientedPoints& all);

// True if the only product accounts for the points of each part nearly as well as the part's own
// model.
bool ExplainsAllParts(const ModelledProposal& modelled);

// Distance from the surface of the nearest shape, in metres; infinite without shapes.
double DistanceToShapes_m(const std::vector<ShapePart>& shapes, const Vector3& p_L);
// The index of the nearest shape. Precondition: there is one.
std::size_t NearestShape(const std::vector<ShapePart>& shapes, const Vector3& p_L);

// The points of a shape or handle, in the order of the hypothesis.
PointSet PointsOfPart(const ObjectHypothesis& hypothesis, std::int32_t part);
PointSet PointsOfHandle(const ObjectHypothesis& hypothesis, std::size_t handle);

// Merges all hypotheses into one product: on the support of the first one and with its plates, and
// with the foot of the lowest object. Plates of the others are dropped. Precondition: the first one
// is an object.
Product Merged(const SceneState& state, std::span<const HypothesisId> parts);

// The hypothesis without, or with, some points, and its nodes in proportion. Points are ascending.
Product Without(const ObjectHypothesis& hypothesis, const PointSet& points);
Product With(const ObjectHypothesis& hypothesis, const PointSet& points,
             std::size_t nodes_of_points);

// The number of nodes of this number of a hypothesis's points.
std::size_t NodesOf(const ObjectHypothesis& hypothesis, std::size_t point_count);

std::size_t CountPoints(const SceneState& state, const Proposal& proposal);

}  // namespace cwm::perception
