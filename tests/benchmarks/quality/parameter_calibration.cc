#include "tests/benchmarks/quality/parameter_calibration.h"

#include <cmath>
#include <vector>

#include "collision/geometry/coefficients.h"

namespace cwm::benchmarks {
namespace {

// The names of the coefficients, in the order of Coefficients().
std::vector<std::string> ParameterNames(ShapeKind kind) {
  switch (kind) {
    case ShapeKind::kSphere:
      return {"centre", "centre", "centre", "radius"};
    case ShapeKind::kCylinder:
      return {"point on axis", "point on axis", "point on axis", "axis", "axis", "axis", "radius"};
    case ShapeKind::kCone:
      return {"apex", "apex", "apex", "axis", "axis", "axis", "half angle"};
    default:
      return {};
  }
}

// The coefficients of the true surface in the representation of the found one: a cylinder's axis in
// the same direction, and as its point the one nearest to the found point.
std::vector<double> TrueCoefficients(const TrueShape& truth, const std::vector<double>& found) {
  std::vector<double> values = Coefficients(truth.shape, truth.X_WS);
  if (KindOf(truth.shape) != ShapeKind::kCylinder) return values;
  const Eigen::Map<const Vector3> found_point(found.data()), found_axis(found.data() + 3);
  Eigen::Map<Vector3> point(values.data()), axis(values.data() + 3);
  point += axis.dot(found_point - point) * axis;
  if (axis.dot(found_axis) < 0) axis = -axis;
  return values;
}

}  // namespace

// Adds the sizes of a box, each compared with the true size along the same direction.
void ParameterCalibration::AddBox(const TrueShape& truth, const FoundShape& found) {
  const std::vector<double>& sigmas = found.part.fit->parameter_sigma;
  if (sigmas.size() != 3) return;
  const Vector3 size_m = std::get<Box>(found.part.shape).size_m;
  const Vector3 expected_m = std::get<Box>(truth.shape).size_m;
  const Matrix3 R_TF = truth.X_WS.linear().transpose() * found.X_WS.linear();
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double sigma_m = sigmas[static_cast<std::size_t>(k)];
    if (!(sigma_m > 0)) continue;
    Eigen::Index along = 0;
    R_TF.col(k).cwiseAbs().maxCoeff(&along);
    WithinSigma& parameter = parameters_["box size"];
    ++parameter.count;
    parameter.within += std::abs(size_m(k) - expected_m(along)) <= sigma_m;
  }
}

void ParameterCalibration::Add(const TrueShape& truth, const FoundShape& found) {
  const ShapeKind kind = KindOf(truth.shape);
  if (KindOf(found.part.shape) != kind || !found.part.fit) return;
  if (kind == ShapeKind::kBox) return AddBox(truth, found);
  const std::vector<std::string> names = ParameterNames(kind);
  const std::vector<double> values = Coefficients(found.part.shape, found.X_WS);
  const std::vector<double>& sigmas = found.part.fit->parameter_sigma;
  if (values.size() != names.size() || sigmas.size() != names.size()) return;
  const std::vector<double> expected = TrueCoefficients(truth, values);
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (!(sigmas[k] > 0)) continue;
    WithinSigma& parameter = parameters_[std::string(NameOf(kind)) + " " + names[k]];
    ++parameter.count;
    parameter.within += std::abs(values[k] - expected[k]) <= sigmas[k];
  }
}

WithinSigma ParameterCalibration::all() const {
  WithinSigma sum;
  for (const auto& [name, parameter] : parameters_) {
    sum.count += parameter.count;
    sum.within += parameter.within;
  }
  return sum;
}

}  // namespace cwm::benchmarks
