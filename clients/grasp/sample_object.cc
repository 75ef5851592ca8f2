#include "clients/grasp/sample_object.h"

#include <algorithm>

namespace cwm::grasp {
namespace {

namespace pb = cwm::v1;
using Eigen::Isometry3d;
using Eigen::Vector3d;

bool HasClosedForm(const pb::ShapePart& part) {
  return part.has_vessel() || part.has_box() || part.has_cylinder() || part.has_cone() ||
         part.has_capsule() || part.has_sphere();
}

Candidates SamplePart(const pb::ShapePart& part, const SamplerOptions& options) {
  if (part.has_vessel()) return SampleVessel(part.vessel(), options);
  if (part.has_box()) return SampleBox(part.box(), options);
  if (part.has_cylinder()) return SampleCylinder(part.cylinder(), options);
  if (part.has_cone()) return SampleCone(part.cone(), options);
  if (part.has_capsule()) return SampleCapsule(part.capsule(), options);
  if (part.has_sphere()) return SampleSphere(part.sphere(), options);
  return {};
}

// One standard deviation of the width. Fits report it for radii (last) and for the edges of boxes,
// where 0 means that an end was not observed: the edge is then a guess, off by a centimetre or
// more. Otherwise both walls are off by the noise of the points around them.
double WidthSigma_m(const pb::ShapePart& part, const Vector3d& closing_S) {
  constexpr double kGuessed_m = 0.01;
  const auto& sigma = part.fit().parameter_sigma();
  if (part.has_box() && sigma.size() == 3) {
    int axis = 0;
    closing_S.cwiseAbs().maxCoeff(&axis);
    return sigma[axis] > 0 ? sigma[axis] : kGuessed_m;
  }
  if ((part.has_cylinder() || part.has_sphere()) && !sigma.empty() && sigma[sigma.size() - 1] > 0) {
    return 2 * sigma[sigma.size() - 1];
  }
  return part.fit().rms_m();
}

Candidates Placed(Candidates candidates, const Isometry3d& X_WF) {
  for (Candidate& candidate : candidates.list) candidate.X_FG = X_WF * candidate.X_FG;
  return candidates;
}

Candidates SampleBounds(const pb::OrientedBox& bounds, const Vector3d& axis_O,
                        const Isometry3d& X_WO, const SamplerOptions& options) {
  const Isometry3d X_OB = ToIsometry(bounds.x_object_box());
  return Placed(SampleHandle(bounds.box(), X_OB.linear().transpose() * axis_O, options),
                X_WO * X_OB);
}

}  // namespace

Isometry3d ToIsometry(const pb::Pose& pose) {
  Isometry3d X = Isometry3d::Identity();
  X.translation() = Vector3d(pose.tx_m(), pose.ty_m(), pose.tz_m());
  const Eigen::Quaterniond q(pose.qw(), pose.qx(), pose.qy(), pose.qz());
  // A missing pose is the identity.
  if (q.norm() > 0) X.linear() = q.normalized().toRotationMatrix();
  return X;
}

Candidates SampleObject(const pb::Object& object, const SamplerOptions& options) {
  Candidates found;
  const Isometry3d X_WO = ToIsometry(object.x_world_object());
  bool by_bounds = object.shapes().empty();
  for (const pb::ShapePart& part : object.shapes()) {
    if (!HasClosedForm(part)) {
      by_bounds = true;
      continue;
    }
    const Isometry3d X_WS = X_WO * ToIsometry(part.x_object_shape());
    SamplerOptions of_part = options;
    of_part.up_S = X_WS.linear().transpose() * Vector3d::UnitZ();
    Candidates candidates = SamplePart(part, of_part);
    for (Candidate& candidate : candidates.list) {
      candidate.sigma_m = WidthSigma_m(part, candidate.X_FG.linear().col(0));
    }
    found.Append(Placed(std::move(candidates), X_WS));
  }
  for (const pb::Handle& handle : object.handles()) {
    found.Append(SampleBounds(
        handle.bounds(), {handle.axis().x(), handle.axis().y(), handle.axis().z()}, X_WO, options));
  }
  if (by_bounds && object.has_bounds()) {
    const Isometry3d X_OB = ToIsometry(object.bounds().x_object_box());
    for (int axis = 0; axis < 3; ++axis) {
      Candidates around = SampleBounds(object.bounds(), X_OB.linear().col(axis), X_WO, options);
      for (Candidate& candidate : around.list) candidate.strategy = "bounds";
      found.Append(around);
    }
  }
  return found;
}

}  // namespace cwm::grasp
