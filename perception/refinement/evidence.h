// What passes ask of hypotheses and their models.
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

// derived: of so many places that are asked one by one, a share is known to 0.06.
inline constexpr std::size_t kMaxAskedPoints = 64;
// chosen: hypotheses that touch and are looked at together: bounds the work in clutter.
inline constexpr std::size_t kMaxInGroup = 12;

// chosen: the largest extent of a thing on a table: of a pan with its handle, of a moving box.
inline constexpr double kMaxThing_m = 0.7;
// derived: a lone face is made half as thick, and noise adds to that.
inline constexpr double kMaxLoneThickness_m = kLoneThickness_m * 2;
// chosen: faces that are nearer are one, by noise, warp and bent cardboard; flat things are
// thicker.
inline constexpr double kMaxOneFace_m = 0.015;
// derived: what is no farther apart than a surface explains may touch. Noise, creases, and a fit
// without a view of the foot move ends by as much.
inline constexpr double kMaxContactGap_m = kExplainedWithin_m;
// chosen: between the axes of things that are stacked or carry each other on: soft packages bend,
// and the sensor warps all.
inline constexpr double kMaxAxisOffset_m = 0.012;
// chosen: 14 degrees: an axis so near to upright stands, axes so near to each other are of one
// thing.
inline constexpr double kAligned_cos = 0.97;

// Whether one shape explains so large a share of the points.
bool IsOneSolid(const ObjectModel& model, double min_explained = kNearlyAll);

// Whether a normal is that of a level face, within what normals miss by.
bool IsLevel(const Eigen::Vector3f& normal, const Eigen::Vector3f& up);

// True of shapes that enclose a measured volume. Vessels are open, and lone faces are given 5 mm.
bool IsClosed(const ShapePart& shape);

// Mean square, truncated, of the distances of points to the nearest solid, in standard deviations.
double MisfitOf(const std::vector<ShapePart>& shapes, const PointSet& points,
                const OrientedPoints& all);

// True where the only product accounts for the points of each part nearly as well as the part's own
// model.
bool AllAccountedFor(const ModelledProposal& modelled);

// Distance to the surface of the nearest shape, in metres; infinite of no shapes.
double DistanceToShapes_m(const std::vector<ShapePart>& shapes, const Vector3& p_L);
// The index of that shape. Precondition: there is one.
std::size_t NearestShape(const std::vector<ShapePart>& shapes, const Vector3& p_L);

// The points of a shape or handle, in the hypothesis's order.
PointSet PointsOfPart(const ObjectHypothesis& hypothesis, std::int32_t part);
PointSet PointsOfHandle(const ObjectHypothesis& hypothesis, std::size_t handle);

// All hypotheses as one product, on the ground of the lowest of them.
Product Merged(const SceneState& state, std::span<const HypothesisId> parts);

// The hypothesis without, and with some points; its nodes in proportion. Points ascend.
Product Without(const ObjectHypothesis& hypothesis, const PointSet& points);
Product With(const ObjectHypothesis& hypothesis, const PointSet& points,
             std::size_t nodes_of_points);

// Nodes of so many of a hypothesis's points.
std::size_t NodesOf(const ObjectHypothesis& hypothesis, std::size_t point_count);

std::size_t CountPoints(const SceneState& state, const Proposal& proposal);

}  // namespace cwm::perception
