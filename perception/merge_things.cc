#include "perception/merge_things.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "collision/geometry/hybrid_model.h"
#include "perception/model/model_points.h"
#include "perception/model/shape_fit.h"

namespace cwm::perception {

void TakeOver(SegmentedThing& first, SegmentedThing& second) {
  const std::vector<std::uint32_t> of_second = std::exchange(second.points, {});
  first.points.insert(first.points.end(), of_second.begin(), of_second.end());
  std::ranges::sort(first.points);
  first.node_count += second.node_count;
  if (second.supported_by >= 0 && second.foot_height_m < first.foot_height_m) {
    first.foot_height_m = second.foot_height_m;
    first.rests_on = second.rests_on;
  }
}

void GivePoints(const std::vector<std::uint32_t>& given, SegmentedThing& from, SegmentedThing& to) {
  const std::size_t nodes = from.node_count * given.size() / from.points.size();
  std::erase_if(from.points, [&](std::uint32_t i) { return std::ranges::binary_search(given, i); });
  to.points.insert(to.points.end(), given.begin(), given.end());
  std::ranges::sort(to.points);
  from.node_count -= nodes;
  to.node_count += nodes;
}

Eigen::AlignedBox3f BoundsOf(const ModelledThing& thing) {
  Eigen::AlignedBox3f bounds;
  for (const Eigen::Vector3f& p : thing.thinned_L) bounds.extend(p);
  return bounds;
}

void RemoveThing(std::size_t gone, std::size_t joined_with, SegmentedScene& scene,
                 std::vector<ModelledThing>& modelled) {
  const auto at = static_cast<std::ptrdiff_t>(gone);
  scene.things.erase(scene.things.begin() + at);
  modelled.erase(modelled.begin() + at);
  for (std::size_t k = 0; k < scene.things.size(); ++k) {
    std::int32_t& below = scene.things[k].rests_on;
    if (below == static_cast<std::int32_t>(gone)) below = static_cast<std::int32_t>(joined_with);
    if (below > static_cast<std::int32_t>(gone)) --below;
    if (below == static_cast<std::int32_t>(k)) below = -1;
  }
}

double MisfitOf(const ModelledThing& thing, const std::vector<std::uint32_t>& points,
                const OrientedPoints& all) {
  double sum = 0;
  for (std::uint32_t i : points) {
    const Vector3 p = all.points[i].cast<double>();
    double least = kTruncatedSquare;
    for (const ShapePart& part : thing.model->shapes) {
      const double off_m = SignedDistance_m(part, (thing.X_LO * part.X_OS).inverse() * p);
      const double off = off_m / double{all.sigma_m[i]};
      least = std::min(least, off * off);
    }
    sum += least;
  }
  return sum / static_cast<double>(points.size());
}

bool AccountsFor(const ModelledThing& whole, const ModelledThing& part,
                 const std::vector<std::uint32_t>& points_of_part, const OrientedPoints& all) {
  const std::vector<std::uint32_t> some = Thinned(points_of_part, kJudgedPoints);
  return MisfitOf(whole, some, all) <= MisfitOf(part, some, all) + kMostLoss;
}

}  // namespace cwm::perception
