#include "perception/live/view_offsets.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "collision/geometry/signed_distance.h"

namespace cwm::perception {
namespace {

// measured: on tables of simulated things, sizes and offsets change by less than 0.1 um in the last
// step of nine in ten fits, and by 40 um at most.
constexpr int kSteps = 10;
// chosen: so many points of a view, evenly taken, determine its offset.
constexpr std::size_t kMaxUsedPoints = 1000;
// chosen: a difference far below the noise, and far above the rounding of doubles.
constexpr double kDifference_m = 1e-6;
// chosen: standard deviations of the start's pose and sizes; they keep the steps of what no point
// shows finite.
constexpr double kStartSigma_m = 0.02, kStartSigma_rad = 0.2;

constexpr int kPoseParameters = 6;  // a translation and a rotation in the shape's frame

// The sizes of a shape that a fit may change.
std::vector<double*> SizesOf(Shape& shape) {
  if (auto* sphere = std::get_if<Sphere>(&shape)) return {&sphere->radius_m};
  if (auto* box = std::get_if<Box>(&shape)) {
    return {&box->size_m.x(), &box->size_m.y(), &box->size_m.z()};
  }
  if (auto* cylinder = std::get_if<Cylinder>(&shape)) {
    return {&cylinder->radius_m, &cylinder->length_m};
  }
  if (auto* cone = std::get_if<Cone>(&shape)) {
    return {&cone->radius_bottom_m, &cone->radius_top_m, &cone->length_m};
  }
  return {};
}

// The sizes, the pose and the offsets of one body, in this order after the pose.
class OffsetFit {
 public:
  OffsetFit(std::span<const BodyView> views, const Shape& shape, const Pose& X_FS,
            const SensorNoise& noise)
      : views_(views), noise_(noise), shape_(shape), X_FS_(X_FS), offsets_m_(views.size(), 0) {
    const std::size_t count = kPoseParameters + SizesOf(shape_).size() + views.size();
    from_start_.setZero(static_cast<Eigen::Index>(count));
  }

  std::vector<double> Run() {
    for (int step = 0; step < kSteps; ++step) Step();
    return offsets_m_;
  }

 private:
  void Step() {
    const Eigen::Index count = from_start_.size();
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(count, count);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(count);
    for (std::size_t v = 0; v < views_.size(); ++v) AddView(v, information, gradient);
    AddPrior(information, gradient);
    const Eigen::VectorXd step = information.ldlt().solve(-gradient);
    if (!step.allFinite()) return;
    from_start_ += step;
    X_FS_ = X_FS_ * MakePose(step.head<3>(), Turn(step.segment<3>(3)));
    Eigen::Index i = kPoseParameters;
    for (double* size_m : SizesOf(shape_)) *size_m = std::max(*size_m + step[i++], kDifference_m);
    for (double& offset_m : offsets_m_) offset_m += step[i++];
  }

  static Quaternion Turn(const Vector3& rotation_rad) {
    const double angle_rad = rotation_rad.norm();
    if (angle_rad == 0) return Quaternion::Identity();
    return Quaternion(Eigen::AngleAxisd(angle_rad, rotation_rad / angle_rad));
  }

  void AddView(std::size_t v, Eigen::MatrixXd& information, Eigen::VectorXd& gradient) {
    const BodyView& view = views_[v];
    const std::size_t stride = 1 + view.points.size() / kMaxUsedPoints;
    const Pose X_SF = X_FS_.inverse();
    const Vector3 sensor_S = X_SF * view.sensor;
    const std::vector<double*> sizes = SizesOf(shape_);
    const Eigen::Index own = from_start_.size() - static_cast<Eigen::Index>(views_.size() - v);
    Eigen::VectorXd derivatives = Eigen::VectorXd::Zero(from_start_.size());
    for (std::size_t i = 0; i < view.points.size(); i += stride) {
      const Vector3 measured_S = X_SF * view.points[i].cast<double>();
      const double range_m = (measured_S - sensor_S).norm();
      const Vector3 ray_S = (measured_S - sensor_S) / range_m;
      const Vector3 p_S = measured_S - offsets_m_[v] * ray_S;
      const SurfacePoint surface = NearestSurfacePoint(shape_, p_S);
      const double sigma_m = noise_.AxialSigma_m(range_m);
      derivatives.head<3>() = -surface.normal;
      derivatives.segment<3>(3) = -p_S.cross(surface.normal);
      for (std::size_t s = 0; s < sizes.size(); ++s) {
        derivatives[kPoseParameters + static_cast<Eigen::Index>(s)] = BySize(sizes[s], p_S);
      }
      derivatives[own] = -surface.normal.dot(ray_S);
      const double misfit = surface.signed_distance_m / (kGate_sigma * sigma_m);
      const double robust = 1 / ((1 + misfit * misfit) * (1 + misfit * misfit));
      const double weight =
          robust * static_cast<double>(stride) / (noise_.PointsPerSample() * sigma_m * sigma_m);
      information.noalias() += weight * derivatives * derivatives.transpose();
      gradient += weight * surface.signed_distance_m * derivatives;
    }
  }

  // The change of a point's distance by that of a size, as a central difference.
  double BySize(double* size_m, const Vector3& p_S) const {
    const double at_m = *size_m;
    *size_m = at_m + kDifference_m;
    const double more_m = SignedDistance_m(shape_, p_S);
    *size_m = at_m - kDifference_m;
    const double less_m = SignedDistance_m(shape_, p_S);
    *size_m = at_m;
    return (more_m - less_m) / (2 * kDifference_m);
  }

  void AddPrior(Eigen::MatrixXd& information, Eigen::VectorXd& gradient) const {
    const Eigen::Index first_offset = from_start_.size() - static_cast<Eigen::Index>(views_.size());
    for (Eigen::Index i = 0; i < from_start_.size(); ++i) {
      const bool is_rotation = i >= 3 && i < kPoseParameters;
      const double sigma = i >= first_offset ? noise_.WarpSigma_m()
                           : is_rotation     ? kStartSigma_rad
                                             : kStartSigma_m;
      information(i, i) += 1 / (sigma * sigma);
      gradient[i] += from_start_[i] / (sigma * sigma);
    }
  }

  const std::span<const BodyView> views_;
  const SensorNoise& noise_;
  Shape shape_;
  Pose X_FS_;
  std::vector<double> offsets_m_;
  Eigen::VectorXd from_start_;  // the sum of all steps
};

}  // namespace

bool HasViewOffsets(const Shape& shape) {
  Shape copy = shape;
  return !SizesOf(copy).empty();
}

std::vector<double> ViewOffsets_m(std::span<const BodyView> views, const Shape& shape,
                                  const Pose& X_FS, const SensorNoise& noise) {
  if (!HasViewOffsets(shape) || noise.WarpSigma_m() == 0) {
    return std::vector<double>(views.size(), 0);
  }
  return OffsetFit(views, shape, X_FS, noise).Run();
}

}  // namespace cwm::perception
