// Two things of a scene become one or give each other points, and how well a model accounts for the
// points of either.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "perception/model_thing.h"

namespace cwm::perception {

// What its points are judged by: few hundred of them.
inline constexpr std::size_t kJudgedPoints = 400;
// Of the mean square in variances: warp moves parts of one thing apart; true parts lost 0.1.
inline constexpr double kMostLoss = 0.5;

// The points of the second are the first's, on the ground of the lower one where both have any; the
// second has none then.
void TakeOver(SegmentedThing& first, SegmentedThing& second);

// Some points of the first, ascending, are the second's.
void GivePoints(const std::vector<std::uint32_t>& given, SegmentedThing& from, SegmentedThing& to);

// Of the points that a thing keeps, in the level frame.
Eigen::AlignedBox3f BoundsOf(const ModelledThing& thing);

// Drops a thing that has become a part of another: what rested on it rests on that.
void RemoveThing(std::size_t gone, std::size_t joined_with, SegmentedScene& scene,
                 std::vector<ModelledThing>& modelled);

// Mean square, truncated, of the distances of points of the scene to the nearest solid of a thing, in
// standard deviations.
double MisfitOf(const ModelledThing& thing, const std::vector<std::uint32_t>& points,
                const OrientedPoints& all);

// Whether the points of a part are accounted for nearly as well by the whole as by itself.
bool AccountsFor(const ModelledThing& whole, const ModelledThing& part,
                 const std::vector<std::uint32_t>& points_of_part, const OrientedPoints& all);

}  // namespace cwm::perception
