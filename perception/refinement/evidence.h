// What passes ask of hypotheses and their models.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "perception/hypotheses/scene_state.h"
#include "perception/refinement/pass.h"

namespace cwm::perception {

// chosen: some thirty independent samples of a Kinect's.
inline constexpr std::size_t kMaxJudgedPoints = 400;

// Whether one shape explains so large a share of the points.
bool IsOneSolid(const ObjectModel& model, double min_explained);

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
