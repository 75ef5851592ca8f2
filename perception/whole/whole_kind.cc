#include "perception/whole/whole_kind.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

// chosen: the least cosine of the inclination of an axis that counts as upright: 26 degrees.
constexpr double kMayStand_cos = 0.9;

Matrix3 AxisAt(double yaw_rad, double elevation_sine) {
  const double level = std::sqrt(std::max(0.0, 1 - elevation_sine * elevation_sine));
  return BasisFromZ(Vector3(level * std::cos(yaw_rad), level * std::sin(yaw_rad), elevation_sine));
}

// The middle of a lying cone's axis is as high as its mid radius times the cosine of its slope,
// because the axis rises with the radius.
WholeSolid PlaceLying(const WholeParameters& x, double slope) {
  const double cosine = 1 / std::sqrt(1 + slope * slope);
  WholeSolid out;
  out.X_GS.linear() = AxisAt(x(2), slope * cosine);
  out.X_GS.translation() = Vector3(x(0), x(1), x(3) * cosine);
  return out;
}

WholeSolid PlaceLeaning(const WholeParameters& x) {
  const double sine = std::sin(x(3)), cosine = std::cos(x(3));
  WholeSolid out;
  out.X_GS.linear() = AxisAt(x(2), sine);
  out.X_GS.translation() = Vector3(x(0), x(1), 0.5 * x(5) * std::abs(sine) + x(4) * cosine);
  out.shape = Cylinder{.radius_m = x(4), .length_m = x(5)};
  return out;
}

Matrix3 RotationBy(const Vector3& turn) {
  const double angle_rad = turn.norm();
  if (!(angle_rad > 0)) return Matrix3::Identity();
  return Eigen::AngleAxisd(angle_rad, turn / angle_rad).toRotationMatrix();
}

struct Axial {
  Vector3 at = Vector3::Zero();  // the middle of the axis
  Vector3 axis = Vector3::UnitZ();
  double radius_mid_m = 0, slope = 0, length_m = 0;
};

std::optional<Axial> AsAxial(const WholeSolid& solid) {
  Axial out{.at = solid.X_GS.translation(), .axis = solid.X_GS.linear().col(2)};
  if (const auto* cylinder = std::get_if<Cylinder>(&solid.shape)) {
    out.radius_mid_m = cylinder->radius_m;
    out.length_m = cylinder->length_m;
    return out;
  }
  if (const auto* cone = std::get_if<Cone>(&solid.shape)) {
    out.radius_mid_m = 0.5 * (cone->radius_bottom_m + cone->radius_top_m);
    out.slope = (cone->radius_top_m - cone->radius_bottom_m) / cone->length_m;
    out.length_m = cone->length_m;
    return out;
  }
  return std::nullopt;
}

std::optional<WholeParameters> OfUpright(WholeKind kind, const Axial& a) {
  if (a.axis.z() < kMayStand_cos) return std::nullopt;
  const double height_m = a.at.z() + 0.5 * a.length_m;
  if (kind == WholeKind::kUprightCylinder) {
    return WholeParameters(Eigen::Vector4d(a.at.x(), a.at.y(), height_m, a.radius_mid_m));
  }
  WholeParameters x(5);
  x << a.at.x(), a.at.y(), height_m, a.radius_mid_m + 0.5 * a.slope * a.length_m, a.slope;
  return x;
}

std::optional<WholeParameters> OfLying(WholeKind kind, const Axial& a) {
  if (std::abs(a.axis.z()) > kWallRise_sin) return std::nullopt;
  WholeParameters x(kind == WholeKind::kLyingCone ? 6 : 5);
  x.head<5>() << a.at.x(), a.at.y(), std::atan2(a.axis.y(), a.axis.x()), a.radius_mid_m, a.length_m;
  if (kind == WholeKind::kLyingCone) x(5) = a.slope;
  return x;
}

std::optional<WholeParameters> OfLeaning(const Axial& a) {
  const double sine = std::clamp(a.axis.z(), -1.0, 1.0);
  WholeParameters x(6);
  x << a.at.x(), a.at.y(), std::atan2(a.axis.y(), a.axis.x()), std::asin(sine), a.radius_mid_m,
      a.length_m;
  return x;
}

std::optional<WholeParameters> OfTiltedBox(const WholeSolid& solid) {
  const auto* box = std::get_if<Box>(&solid.shape);
  if (box == nullptr) return std::nullopt;
  const Eigen::AngleAxisd turn(solid.X_GS.linear());
  WholeParameters x(9);
  x << solid.X_GS.translation(), turn.angle() * turn.axis(), box->size_m;
  return x;
}

}  // namespace

bool IsConical(WholeKind kind) {
  return kind == WholeKind::kUprightCone || kind == WholeKind::kLyingCone;
}

bool Lies(WholeKind kind) {
  return kind == WholeKind::kLyingCylinder || kind == WholeKind::kLyingCone;
}

double SlopeOf(WholeKind kind, const WholeParameters& x) {
  return IsConical(kind) ? x(x.size() - 1) : 0;
}

WholeSolid Place(WholeKind kind, const WholeParameters& x) {
  WholeSolid out;
  switch (kind) {
    case WholeKind::kBall:
      out.X_GS.translation() = x.head<3>();
      out.shape = Sphere{.radius_m = x(3)};
      break;
    case WholeKind::kUprightCylinder:
      out.X_GS.translation() = Vector3(x(0), x(1), 0.5 * x(2));
      out.shape = Cylinder{.radius_m = x(3), .length_m = x(2)};
      break;
    case WholeKind::kUprightCone:
      out.X_GS.translation() = Vector3(x(0), x(1), 0.5 * x(2));
      out.shape =
          Cone{.radius_bottom_m = x(3) - x(4) * x(2), .radius_top_m = x(3), .length_m = x(2)};
      break;
    case WholeKind::kLyingCylinder:
      out = PlaceLying(x, 0);
      out.shape = Cylinder{.radius_m = x(3), .length_m = x(4)};
      break;
    case WholeKind::kLyingCone: {
      const double half_growth_m = 0.5 * x(5) * x(4);
      out = PlaceLying(x, x(5));
      out.shape = Cone{.radius_bottom_m = x(3) - half_growth_m,
                       .radius_top_m = x(3) + half_growth_m,
                       .length_m = x(4)};
      break;
    }
    case WholeKind::kLeaningCylinder:
      return PlaceLeaning(x);
    case WholeKind::kUprightBox:
      out.X_GS.linear() = RotationBy(Vector3(0, 0, x(2)));
      out.X_GS.translation() = Vector3(x(0), x(1), 0.5 * x(5));
      out.shape = Box{.size_m = x.tail<3>()};
      break;
    case WholeKind::kTiltedBox:
      out.X_GS.linear() = RotationBy(x.segment<3>(3));
      out.X_GS.translation() = x.head<3>();
      out.shape = Box{.size_m = x.tail<3>()};
      break;
  }
  return out;
}

std::optional<WholeParameters> ParametersOf(WholeKind kind, const WholeSolid& solid) {
  if (kind == WholeKind::kTiltedBox) return OfTiltedBox(solid);
  const std::optional<Axial> axial = AsAxial(solid);
  if (!axial) return std::nullopt;
  if (Lies(kind)) return OfLying(kind, *axial);
  if (kind == WholeKind::kLeaningCylinder) return OfLeaning(*axial);
  const bool upright = kind == WholeKind::kUprightCylinder || kind == WholeKind::kUprightCone;
  return upright ? OfUpright(kind, *axial) : std::nullopt;
}

}  // namespace cwm::perception
