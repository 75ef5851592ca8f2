#include "perception/refinement/evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "collision/geometry/hybrid_model.h"
#include "perception/fit/shape_fit.h"
#include "perception/search/model_points.h"

namespace cwm::perception {
namespace {

// measured: the largest increase of the mean square, in variances; true parts of one object
// increased it by 0.1 because of warp.
constexpr double kMaxLoss = 0.5;

void SortPoints(PointSet& points) { std::ranges::sort(points); }

}  // namespace

bool IsSingleSolid(const ObjectModel& model, double min_explained) {
  const auto explained = std::ranges::count(model.part_of_point, 0);
  return model.shapes.size() == 1 &&
         static_cast<double>(explained) >=
             min_explained * static_cast<double>(model.part_of_point.size());
}

bool IsLevel(const Eigen::Vector3f& normal, const Eigen::Vector3f& up) {
  const double rise = double{normal.dot(up)};
  return rise > 0 && 1 - rise * rise <= kNormalMiss_sin * kNormalMiss_sin;
}

bool IsClosed(const ShapePart& shape) {
  if (shape.vessel || std::holds_alternative<Plate>(shape.shape)) return false;
  const auto* box = std::get_if<Box>(&shape.shape);
  return box == nullptr || box->size_m.minCoeff() > kLoneThickness_m + kGroundNoise_m;
}

double MisfitOf(const std::vector<ShapePart>& shapes, const PointSet& points,
                const OrientedPoints& all) {
  double sum = 0;
  for (std::uint32_t i : points) {
    const double off_m = DistanceToShapes_m(shapes, all.points[i].cast<double>());
    const double off = off_m / double{all.sigma_m[i]};
    sum += std::min(kTruncatedSquare, off * off);
  }
  return sum / static_cast<double>(points.size());
}

bool ExplainsAllParts(const ModelledProposal& modelled) {
  const OrientedPoints& all = modelled.state.points();
  const std::vector<ShapePart>& whole = modelled.products.front()->shapes();
  return std::ranges::all_of(modelled.proposal.consumes, [&](const Consumed& consumed) {
    const ObjectHypothesis& part = modelled.state.Get(consumed.id);
    const PointSet some = Subsampled(part.points, kMaxComparedPoints);
    return MisfitOf(whole, some, all) <= MisfitOf(part.model->shapes(), some, all) + kMaxLoss;
  });
}

double DistanceToShapes_m(const std::vector<ShapePart>& shapes, const Vector3& p_L) {
  double min_m = std::numeric_limits<double>::infinity();
  for (const ShapePart& part : shapes) {
    const Vector3 p_S = part.X_OS.inverse(Eigen::Isometry) * p_L;
    min_m = std::min(min_m, std::abs(SignedDistance_m(part, p_S)));
  }
  return min_m;
}

std::size_t NearestShape(const std::vector<ShapePart>& shapes, const Vector3& p_L) {
  std::size_t nearest = 0;
  double min_m = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    const Vector3 p_S = shapes[k].X_OS.inverse(Eigen::Isometry) * p_L;
    const double off_m = std::abs(SignedDistance_m(shapes[k], p_S));
    if (off_m < min_m) nearest = k, min_m = off_m;
  }
  return nearest;
}

PointSet PointsOfPart(const ObjectHypothesis& hypothesis, std::int32_t part) {
  PointSet members;
  for (std::size_t k = 0; k < hypothesis.points.size(); ++k) {
    if (hypothesis.model->part_of_point()[k] == part) members.push_back(hypothesis.points[k]);
  }
  return members;
}

PointSet PointsOfHandle(const ObjectHypothesis& hypothesis, std::size_t handle) {
  return PointsOfPart(hypothesis,
                      static_cast<std::int32_t>(hypothesis.model->shapes().size() + handle));
}

Product Merged(const SceneState& state, std::span<const HypothesisId> parts) {
  Product merged;
  for (const HypothesisId id : parts) {
    const ObjectHypothesis& part = state.Get(id);
    merged.points.insert(merged.points.end(), part.points.begin(), part.points.end());
    merged.node_count += part.node_count;
    if (id == parts.front()) {
      merged.resting = part.resting;
      merged.plates = part.plates;
    } else if (part.IsObject() && part.resting.foot_height_m < merged.resting.foot_height_m) {
      merged.resting.foot_height_m = part.resting.foot_height_m;
      merged.resting.on = part.resting.on;
    }
  }
  SortPoints(merged.points);
  return merged;
}

Product Without(const ObjectHypothesis& hypothesis, const PointSet& points) {
  Product product{.node_count = hypothesis.node_count - NodesOf(hypothesis, points.size()),
                  .resting = hypothesis.resting,
                  .plates = hypothesis.plates};
  for (std::uint32_t i : hypothesis.points) {
    if (!std::ranges::binary_search(points, i)) product.points.push_back(i);
  }
  return product;
}

Product With(const ObjectHypothesis& hypothesis, const PointSet& points,
             std::size_t nodes_of_points) {
  Product product{.points = hypothesis.points,
                  .node_count = hypothesis.node_count + nodes_of_points,
                  .resting = hypothesis.resting,
                  .plates = hypothesis.plates};
  product.points.insert(product.points.end(), points.begin(), points.end());
  SortPoints(product.points);
  return product;
}

std::size_t NodesOf(const ObjectHypothesis& hypothesis, std::size_t point_count) {
  return hypothesis.node_count * point_count / hypothesis.points.size();
}

std::size_t CountPoints(const SceneState& state, const Proposal& proposal) {
  std::size_t points = proposal.from_support ? proposal.from_support->points.size() : 0;
  for (const Consumed& consumed : proposal.consumes) points += state.Get(consumed.id).points.size();
  return points;
}

}  // namespace cwm::perception
