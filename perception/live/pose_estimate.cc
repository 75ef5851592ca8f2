#include "perception/live/pose_estimate.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <vector>

#include "perception/live/body_evidence.h"
#include "perception/live/frame_evidence.h"
#include "perception/live/pixel_rays.h"

namespace cwm::perception {
namespace {

// chosen: pixels of a grid this wide, so that their errors are nearly independent; 2 000 of an
// image of 640 x 480.
constexpr int kGrid_px = 12;
// chosen: models err by some millimetres, and all pixels of one by the same.
constexpr double kModelSigma_m = 0.003;
// cited: Tukey's biweight with this constant has 95 % efficiency for normal errors (Holland and
// Welsch 1977).
constexpr double kTukey = 4.685;
constexpr int kReweightings = 4;
// chosen: directions that no surface determines have so little of the given pose's information.
constexpr double kUndetermined = 1e-3;
// chosen: fewer pixels correct nothing.
constexpr int kMinPixels = 50;
// derived: what shares an error with its neighbours, as the warp, does not average out.
constexpr double kMinSigma_m = 0.001;
constexpr double kMinSigma_rad = 0.0005;

// residual_m = derivative * twist, the twist being that of the sensor: its translation, and its
// rotation about itself, in the world's axes.
struct Row {
  Vector6 derivative = Vector6::Zero();
  double residual_m = 0;
  double sigma_m = 0;
};

Vector6 TwistBetween(const Pose& X_WC, const Pose& X_WC_other) {
  const Eigen::AngleAxisd turn(Matrix3(X_WC_other.linear() * X_WC.linear().transpose()));
  Vector6 twist;
  twist << X_WC_other.translation() - X_WC.translation(), turn.angle() * turn.axis();
  return twist;
}

Pose Moved(const Pose& X_WC, const Vector6& twist) {
  Pose moved = X_WC;
  moved.translation() += twist.head<3>();
  const double angle_rad = twist.tail<3>().norm();
  if (angle_rad > 0) {
    const Matrix3 turn =
        Eigen::AngleAxisd(angle_rad, twist.tail<3>() / angle_rad).toRotationMatrix();
    moved.linear() = Quaternion(Matrix3(turn * X_WC.linear())).normalized().toRotationMatrix();
  }
  return moved;
}

std::vector<Row> RowsOf(const ExpectedView& view, const Pose& X_WC, const DepthImage& image,
                        const RobotMask& robots, const DepthCamera& camera, const DepthNoise& noise,
                        const PoseSigma& given) {
  const PixelRays rays(camera, X_WC);
  const Eigen::Matrix3f R_WC = X_WC.linear().cast<float>();
  std::vector<Row> rows;
  for (int v = kGrid_px / 2; v < camera.height; v += kGrid_px) {
    for (int u = kGrid_px / 2; u < camera.width; u += kGrid_px) {
      const std::size_t i = static_cast<std::size_t>(v) * camera.width + u;
      const float z = image.depth_m[i];
      if (z == 0 || view.body()[i] == kNoBody) continue;
      if (!robots.empty() && robots.pixels[i] != 0) continue;
      Eigen::Vector3f plane_C;
      if (!ExpectedPlaneAt(view, camera, u, v, plane_C)) continue;
      const float expected_m = view.depth_m()[i];
      // A sensor that moves by v and turns by w sees a fixed point q move by -v - w x q.
      const Vector3 by_translation = -(expected_m * (R_WC * plane_C)).cast<double>();
      const Vector3 q_L = rays.Point(u, v, expected_m).cast<double>();
      Row row;
      row.derivative << by_translation, q_L.cross(by_translation);
      row.residual_m = z - expected_m;
      row.sigma_m =
          std::hypot(noise.Axial_m(expected_m), noise.model().WarpSigma_m(), kModelSigma_m);
      const double by_pose_m = std::hypot(row.derivative.head<3>().norm() * given.translation_m,
                                          row.derivative.tail<3>().norm() * given.rotation_rad);
      // What the pose cannot explain is something else.
      if (std::abs(row.residual_m) > kGate_sigma * std::hypot(by_pose_m, row.sigma_m)) continue;
      rows.push_back(row);
    }
  }
  return rows;
}

}  // namespace

PoseEstimate EstimatePose(const ExpectedView& view, const Pose& X_WC, const DepthImage& image,
                          const RobotMask& robots, const DepthCamera& camera,
                          const DepthNoise& noise, const Pose& X_WC_given, const PoseSigma& given) {
  const PoseEstimate unknown = {
      .X_WC = X_WC_given, .sigma = given, .depth_sigma_m = given.translation_m};
  if (given.translation_m <= 0 || given.rotation_rad <= 0) return unknown;
  const std::vector<Row> rows = RowsOf(view, X_WC, image, robots, camera, noise, given);
  if (rows.size() < kMinPixels) return unknown;
  Vector6 variance_given;
  variance_given << Vector3::Constant(given.translation_m * given.translation_m),
      Vector3::Constant(given.rotation_rad * given.rotation_rad);
  const Matrix6 prior = variance_given.cwiseInverse().asDiagonal();
  const Vector6 twist_given = TwistBetween(X_WC, X_WC_given);
  Vector6 twist = twist_given;
  Matrix6 information = prior;
  double scale = 1;
  for (int k = 0; k < kReweightings; ++k) {
    Matrix6 measured = kUndetermined * prior;
    Vector6 moment = measured * twist_given;
    double squares = 0;
    double weights = 0;
    for (const Row& row : rows) {
      const double error = (row.residual_m - row.derivative.dot(twist)) / row.sigma_m;
      // The first weights are those of the pose's own error.
      const double limit = k == 0 ? 4 * kTukey : kTukey * std::max(1.0, scale);
      if (std::abs(error) >= limit) continue;
      const double tukey = 1 - error * error / (limit * limit);
      const double weight = tukey * tukey;
      squares += weight * error * error;
      weights += weight;
      const double per_m2 = weight / (row.sigma_m * row.sigma_m);
      measured.noalias() += per_m2 * row.derivative * row.derivative.transpose();
      moment += per_m2 * row.residual_m * row.derivative;
    }
    if (weights < kMinPixels) return unknown;
    scale = std::sqrt(squares / weights);
    // The surfaces were placed by earlier poses, which erred as much: each pose is worth as much as
    // the world, and a drift of the world does not grow.
    const Matrix6 variance_of_world = variance_given.asDiagonal();
    const Matrix6 by_world = (measured.inverse() + variance_of_world).inverse();
    information = prior + by_world;
    twist =
        information.ldlt().solve(prior * twist_given + by_world * measured.ldlt().solve(moment));
  }
  const double spread = std::max(1.0, scale);
  const Matrix6 covariance = spread * spread * information.inverse();
  double depth_variance_m2 = 0;
  for (const Row& row : rows) {
    depth_variance_m2 += row.derivative.dot(covariance * row.derivative);
  }
  const auto mean_variance = [](const auto& block) { return block.trace() / 3; };
  const double translation_m = std::sqrt(mean_variance(covariance.topLeftCorner<3, 3>()));
  const double rotation_rad = std::sqrt(mean_variance(covariance.bottomRightCorner<3, 3>()));
  return {.X_WC = Moved(X_WC, twist),
          .sigma = {.translation_m = std::hypot(kMinSigma_m, translation_m),
                    .rotation_rad = std::hypot(kMinSigma_rad, rotation_rad)},
          .depth_sigma_m = std::hypot(
              kMinSigma_m, std::sqrt(depth_variance_m2 / static_cast<double>(rows.size())))};
}

}  // namespace cwm::perception
