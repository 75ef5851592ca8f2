#include "clients/grasp/sample_object.h"

#include <cstddef>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

namespace cwm::grasp {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// The candidates of a shape with a closed form; nothing for others.
std::optional<Candidates> SamplePart(const Part& part, const SamplerOptions& options) {
  if (part.vessel) return SampleVessel(*part.vessel, options);
  if (const auto* box = std::get_if<Box>(&part.shape)) return SampleBox(*box, options);
  if (const auto* cylinder = std::get_if<Cylinder>(&part.shape)) {
    return SampleCylinder(*cylinder, options);
  }
  if (const auto* cone = std::get_if<Cone>(&part.shape)) return SampleCone(*cone, options);
  if (const auto* capsule = std::get_if<Capsule>(&part.shape)) {
    return SampleCapsule(*capsule, options);
  }
  if (const auto* sphere = std::get_if<Sphere>(&part.shape)) return SampleSphere(*sphere, options);
  return std::nullopt;
}

// One standard deviation of the width. Fits report it for radii (last) and for the edges of boxes,
// where 0 means that an end was not observed: the edge is then a guess, off by a centimetre or
// more. Otherwise both walls are off by the noise of the points around them.
double WidthSigma_m(const Part& part, const Vector3d& closing_S) {
  constexpr double kGuessed_m = 0.01;
  if (!part.fit) return 0;
  const std::vector<double>& sigma = part.fit->parameter_sigma;
  if (std::holds_alternative<Box>(part.shape) && sigma.size() == 3) {
    Eigen::Index axis = 0;
    closing_S.cwiseAbs().maxCoeff(&axis);
    const double edge_m = sigma[static_cast<std::size_t>(axis)];
    return edge_m > 0 ? edge_m : kGuessed_m;
  }
  const bool is_round =
      std::holds_alternative<Cylinder>(part.shape) || std::holds_alternative<Sphere>(part.shape);
  if (is_round && !sigma.empty() && sigma.back() > 0) return 2 * sigma.back();
  return part.fit->rms_m;
}

Candidates Placed(Candidates candidates, const Isometry3d& X_WF) {
  for (Candidate& candidate : candidates.list) candidate.X_FG = X_WF * candidate.X_FG;
  return candidates;
}

Candidates SampleBounds(const OrientedBox& bounds, const Vector3d& axis_O, const Isometry3d& X_WO,
                        const SamplerOptions& options) {
  return Placed(SampleHandle(bounds.size, bounds.X_OB.linear().transpose() * axis_O, options),
                X_WO * bounds.X_OB);
}

}  // namespace

Candidates SampleObject(const Object& object, const SamplerOptions& options) {
  Candidates found;
  bool by_bounds = object.parts.empty();
  for (const Part& part : object.parts) {
    const Isometry3d X_WS = object.X_WO * part.X_OS;
    SamplerOptions of_part = options;
    of_part.up_S = X_WS.linear().transpose() * Vector3d::UnitZ();
    auto candidates = SamplePart(part, of_part);
    if (!candidates) {
      by_bounds = true;
      continue;
    }
    for (Candidate& candidate : candidates->list) {
      candidate.sigma_m = WidthSigma_m(part, candidate.X_FG.linear().col(0));
    }
    found.Append(Placed(*std::move(candidates), X_WS));
  }
  for (const Handle& handle : object.handles) {
    found.Append(SampleBounds(handle.bounds, handle.axis_O, object.X_WO, options));
  }
  if (by_bounds && object.bounds) {
    for (int axis = 0; axis < 3; ++axis) {
      Candidates around = SampleBounds(*object.bounds, object.bounds->X_OB.linear().col(axis),
                                       object.X_WO, options);
      for (Candidate& candidate : around.list) candidate.strategy = "bounds";
      found.Append(around);
    }
  }
  return found;
}

}  // namespace cwm::grasp
