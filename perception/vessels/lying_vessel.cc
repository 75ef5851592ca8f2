#include "perception/vessels/lying_vessel.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <variant>

#include "perception/cloud/tolerances.h"
#include "perception/vessels/shell_fit.h"

namespace cwm::perception {
namespace {

bool AreParallel(const Vector3& a, const Vector3& b) {
  return std::abs(a.dot(b)) > std::cos(kSameDirection_rad);
}

std::optional<Vector3> AxisOf(const AnyModel& model) {
  if (const auto* cylinder = std::get_if<CylinderModel>(&model)) return cylinder->axis;
  if (const auto* cone = std::get_if<ConeModel>(&model)) return cone->axis;
  if (const auto* plane = std::get_if<PlaneModel>(&model)) return plane->normal;
  return std::nullopt;
}

class LyingVesselSearch {
 public:
  LyingVesselSearch(const OrientedPoints& object, const FitContext& context)
      : object_(object),
        c_(context),
        up_(context.ground.known ? context.ground.up : Vector3::UnitZ()),
        asked_({up_}) {}

  void TryStandingWalls(const std::vector<RevolvedWall>& walls) {
    for (const RevolvedWall& wall : walls) {
      if (const auto shell = FitShell(wall, c_)) Consider(wall, *shell, Posture::kStands);
    }
  }

  void TryAxis(const Vector3& axis) {
    const auto is_known = [&](const Vector3& other) { return AreParallel(axis, other); };
    if (std::ranges::any_of(asked_, is_known)) return;
    asked_.push_back(axis);
    // A sensor that sees the inside looks into the mouth.
    const bool opens_here = axis.dot(c_.points.viewpoint) > 0;
    for (const AxisFreedom freedom : {AxisFreedom::kHeld, AxisFreedom::kFree}) {
      const auto wall =
          FitRevolvedWall(object_, opens_here ? axis : Vector3(-axis), freedom, c_.work);
      if (!wall || AreParallel(wall->Axis(), up_)) continue;
      const auto shell = FitShell(*wall, c_);
      if (shell && IsLying(*wall, *shell)) Consider(*wall, *shell, Posture::kLies);
    }
  }

  // Tries the mean of the normals, as for a flat surface, and the axis that the normals turn about.
  void TryNormals() {
    Vector3 mean = Vector3::Zero();
    Matrix3 moments = Matrix3::Zero();
    for (const Vector3& n : c_.points.n) {
      mean += n;
      moments += n * n.transpose();
    }
    if (mean.norm() > 0) TryAxis(mean.normalized());
    TryAxis(Eigen::SelfAdjointEigenSolver<Matrix3>(moments).eigenvectors().col(0));
  }

  // True if the best shell explains nearly all points; the rest may be handles.
  bool IsSettled() const {
    return best_ && static_cast<double>(best_->inliers) >=
                        kNearlyAll * static_cast<double>(c_.points.size());
  }

  std::optional<RevolvedWall> Lying() const {
    if (!best_ || best_->posture == Posture::kStands) return std::nullopt;
    return best_->wall;
  }

 private:
  enum class Posture { kStands, kLies };

  struct Found {
    RevolvedWall wall;
    Posture posture = Posture::kStands;
    double criterion = 0;  // as for shape fits; all have about as many parameters
    std::size_t inliers = 0;
  };

  void Consider(const RevolvedWall& wall, const Solid& shell, Posture posture) {
    const double prior = posture == Posture::kStands ? kUprightPrior : 0;
    const double criterion = CriterionOf(shell) - prior;
    if (best_ && criterion >= best_->criterion) return;
    best_ = {wall, posture, criterion, shell.inliers.size()};
  }

  // True if most of the shell is seen and the vessel is empty. A part of a wall fits about many
  // axes, and contents of a lying vessel would have fallen out.
  bool IsLying(const RevolvedWall& wall, const Solid& shell) const {
    if (shell.role != PartRole::kFitted) return false;
    std::size_t within = 0;
    for (std::size_t i = 0; i < c_.points.size(); ++i) {
      within += wall.Protrusion_m(c_.points.origin_L + c_.points.p[i]) <= c_.points.gate_m[i];
    }
    return static_cast<double>(shell.inliers.size()) >= kNearlyAll * static_cast<double>(within);
  }

  double CriterionOf(const Solid& shell) const {
    const Pose X_SM = shell.X_MS.inverse(Eigen::Isometry);
    double squares = 0;
    for (std::size_t i = 0; i < c_.points.size(); ++i) {
      const double off_sigma =
          SignedDistance_m(shell, X_SM * c_.points.p[i]) / c_.points.sigma_m[i];
      squares += std::min(kTruncatedSquare, off_sigma * off_sigma);
    }
    return c_.IndependentSamples(1) * squares;
  }

  const OrientedPoints& object_;
  const FitContext& c_;
  const Vector3 up_;
  std::vector<Vector3> asked_;  // up itself was tried with the standing walls
  std::optional<Found> best_;
};

}  // namespace

std::vector<Vector3> AxesOf(const Extraction& extraction) {
  std::vector<Vector3> axes;
  for (std::size_t k = 0; k < std::min(kMaxTries, extraction.fits.size()); ++k) {
    if (const auto axis = AxisOf(extraction.fits[k].model)) axes.push_back(*axis);
  }
  return axes;
}

std::optional<RevolvedWall> FindLyingWall(const OrientedPoints& object,
                                          const std::vector<RevolvedWall>& standing,
                                          const std::vector<Vector3>& axes,
                                          const FitContext& context) {
  LyingVesselSearch search(object, context);
  search.TryStandingWalls(standing);
  for (const Vector3& axis : axes) search.TryAxis(axis);
  if (!search.IsSettled()) search.TryNormals();
  return search.Lying();
}

}  // namespace cwm::perception
