#include "perception/fit/solid.h"

#include <algorithm>
#include <cmath>

#include "collision/geometry/aabb.h"
#include "collision/geometry/signed_distance.h"
#include "perception/cloud/quantile.h"
#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

// derived: about two standard deviations of the noise.
constexpr double kExtentBin_m = 0.004;
// chosen: half a metre in bins of that width; longer extents get wider bins.
constexpr int kMaxBins = 128;
// derived: an extent no longer than the edge loss consists of ends only.
constexpr int kMinBins = static_cast<int>(kEdgeLoss_m / kExtentBin_m);

// The typical count of the bins next behind one: a face that leads away from the sensor has fewer
// and fewer points per length. It is at most the typical count of all bins (another face may add
// points), and at least half of that (stray points may follow each other).
double TypicalBehind(const std::vector<double>& counts, std::size_t bin, double typical) {
  constexpr std::ptrdiff_t kBinsBehind = 8;  // chosen: 32 mm
  const auto begin = counts.begin() + static_cast<std::ptrdiff_t>(bin) + 1;
  const std::vector<double> behind(begin, begin + std::min(kBinsBehind, counts.end() - begin));
  return behind.empty() ? typical : std::clamp(Quantile(behind, 0.5), 0.5 * typical, typical);
}

// The distance from the first bin at which an edge of full density would hold as many points as the
// ragged one: as many points scatter beyond an edge as are missing before it.
double RaggedEnd_m(const std::vector<double>& counts, double width_m, Density density) {
  const double of_all = std::max(1.0, Quantile(counts, 0.5));
  for (std::size_t k = 0; k < counts.size(); ++k) {
    const double typical = density == Density::kEven ? of_all : TypicalBehind(counts, k, of_all);
    if (counts[k] < 0.5 * typical) continue;
    double outside = 0;
    for (std::size_t j = 0; j <= k; ++j) outside += std::min(counts[j], typical);
    return static_cast<double>(k + 1) * width_m - std::min(outside / typical, 2.0) * width_m;
  }
  return 0;
}

}  // namespace

double SignedDistance_m(const Solid& solid, const Vector3& p) {
  return solid.vessel ? SignedDistance_m(*solid.vessel, p) : SignedDistance_m(solid.shape, p);
}

std::vector<double> PropagatedSigmas(
    const std::function<std::vector<double>(const Eigen::VectorXd&)>& f,
    const Eigen::MatrixXd& covariance) {
  Eigen::VectorXd step = Eigen::VectorXd::Zero(covariance.rows());
  const std::vector<double> at = f(step);
  Eigen::MatrixXd jacobian(at.size(), step.size());
  for (Eigen::Index k = 0; k < step.size(); ++k) {
    step.setZero();
    step(k) = kDerivativeStep;
    const std::vector<double> moved = f(step);
    if (moved.size() != at.size()) return {};
    for (std::size_t row = 0; row < at.size(); ++row) {
      jacobian(static_cast<Eigen::Index>(row), k) = (moved[row] - at[row]) / kDerivativeStep;
    }
  }
  const Eigen::VectorXd variance = (jacobian * covariance * jacobian.transpose()).diagonal();
  std::vector<double> sigma;
  for (double v : variance) sigma.push_back(std::sqrt(std::max(0.0, v)));
  return sigma;
}

double LowestHeight_m(const Solid& solid, const Ground& ground) {
  // Bounds in a frame whose z is up, its origin on the ground.
  Pose X_GM = Pose::Identity();
  X_GM.linear() = BasisFromZ(ground.up).transpose();
  X_GM.translation() = -(X_GM.linear() * ground.point);
  return TightBounds(solid.shape, X_GM * solid.X_MS).min().z();
}

Interval ExtentAlong(const Vector3& direction, const ModelPoints& points,
                     const std::vector<std::uint32_t>& listed, Density density) {
  std::vector<double> values;
  values.reserve(listed.size());
  for (std::uint32_t i : listed) values.push_back(direction.dot(points.p[i]));
  const double min_m = Quantile(values, 0);
  const double length_m = Quantile(values, 1) - min_m;
  const int bins = std::clamp(static_cast<int>(length_m / kExtentBin_m), 1, kMaxBins);
  const double width_m = length_m / bins;
  if (bins < kMinBins) return {min_m, min_m + length_m};
  std::vector<double> counts(static_cast<std::size_t>(bins), 0);
  for (double v : values) {
    counts[static_cast<std::size_t>(std::min(bins - 1.0, (v - min_m) / width_m))] += 1;
  }
  const double low_m = RaggedEnd_m(counts, width_m, density);
  std::reverse(counts.begin(), counts.end());
  const double high_m = length_m - RaggedEnd_m(counts, width_m, density);
  if (!(high_m > low_m)) return {min_m, min_m + length_m};
  return {min_m + low_m, min_m + high_m};
}

}  // namespace cwm::perception
