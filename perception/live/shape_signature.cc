#include "perception/live/shape_signature.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <vector>

#include "perception/cloud/sensor_noise.h"
#include "perception/track/model_surface.h"

namespace cwm::perception {
namespace {

constexpr double kSignatureReach_m = 0.01;  // of distances, which the samples do not need

}  // namespace

ShapeSignature::ShapeSignature(const HybridModel& model) {
  const std::vector<SurfaceSample> samples =
      ModelSurface(model, kSignatureReach_m).Samples(kSurfaceSamples);
  if (samples.empty()) return;
  const auto count = static_cast<double>(samples.size());
  Vector3 mean = Vector3::Zero();
  for (const SurfaceSample& sample : samples) mean += sample.p_O / count;
  Matrix3 moments = Matrix3::Zero();
  for (const SurfaceSample& sample : samples) {
    moments += (sample.p_O - mean) * (sample.p_O - mean).transpose() / count;
  }
  // Ascending; of points evenly along an edge of length l, the variance is l^2 / 12.
  const Vector3 variances = Eigen::SelfAdjointEigenSolver<Matrix3>(moments).eigenvalues();
  extents_m_ = (12 * variances.cwiseMax(0)).cwiseSqrt().reverse();
}

bool ShapeSignature::IsAlike(const ShapeSignature& other) const {
  return (extents_m_ - other.extents_m_).cwiseAbs().maxCoeff() <= kExplainedWithin_m;
}

}  // namespace cwm::perception
