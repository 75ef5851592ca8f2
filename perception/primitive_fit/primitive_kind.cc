#include "perception/primitive_fit/primitive_kind.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

// chosen: the least cosine of the inclination of an axis that counts as upright: 26 degrees.
constexpr double kMinUpright_cos = 0.9;

Matrix3 AxisAt(double yaw_rad, double elevation_sine) {
  const double level = std::sqrt(std::max(0.0, 1 - elevation_sine * elevation_sine));
  return BasisFromZ(Vector3(level * std::cos(yaw_rad), level * std::sin(yaw_rad), elevation_sine));
}

// The middle of a lying cone's axis is as high as its mid radius times the cosine of its slope,
// because the axis rises with the radius.
PlacedPrimitive PlaceLying(const PrimitiveParameters& x, double slope) {
  const double cosine = 1 / std::sqrt(1 + slope * slope);
  PlacedPrimitive out;
  out.X_GS.linear() = AxisAt(x(2), slope * cosine);
  out.X_GS.translation() = Vector3(x(0), x(1), x(3) * cosine);
  return out;
}

PlacedPrimitive PlaceLeaning(const PrimitiveParameters& x) {
  const double sine = std::sin(x(3)), cosine = std::cos(x(3));
  PlacedPrimitive out;
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

std::optional<Axial> AsAxial(const PlacedPrimitive& solid) {
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

std::optional<PrimitiveParameters> OfUpright(PrimitiveKind kind, const Axial& a) {
  if (a.axis.z() < kMinUpright_cos) return std::nullopt;
  const double height_m = a.at.z() + 0.5 * a.length_m;
  if (kind == PrimitiveKind::kUprightCylinder) {
    return PrimitiveParameters(Eigen::Vector4d(a.at.x(), a.at.y(), height_m, a.radius_mid_m));
  }
  PrimitiveParameters x(5);
  x << a.at.x(), a.at.y(), height_m, a.radius_mid_m + 0.5 * a.slope * a.length_m, a.slope;
  return x;
}

std::optional<PrimitiveParameters> OfLying(PrimitiveKind kind, const Axial& a) {
  if (std::abs(a.axis.z()) > kWallRise_sin) return std::nullopt;
  PrimitiveParameters x(kind == PrimitiveKind::kLyingCone ? 6 : 5);
  x.head<5>() << a.at.x(), a.at.y(), std::atan2(a.axis.y(), a.axis.x()), a.radius_mid_m, a.length_m;
  if (kind == PrimitiveKind::kLyingCone) x(5) = a.slope;
  return x;
}

std::optional<PrimitiveParameters> OfLeaning(const Axial& a) {
  const double sine = std::clamp(a.axis.z(), -1.0, 1.0);
  PrimitiveParameters x(6);
  x << a.at.x(), a.at.y(), std::atan2(a.axis.y(), a.axis.x()), std::asin(sine), a.radius_mid_m,
      a.length_m;
  return x;
}

std::optional<PrimitiveParameters> OfTiltedBox(const PlacedPrimitive& solid) {
  const auto* box = std::get_if<Box>(&solid.shape);
  if (box == nullptr) return std::nullopt;
  const Eigen::AngleAxisd turn(solid.X_GS.linear());
  PrimitiveParameters x(9);
  x << solid.X_GS.translation(), turn.angle() * turn.axis(), box->size_m;
  return x;
}

}  // namespace

bool IsConical(PrimitiveKind kind) {
  return kind == PrimitiveKind::kUprightCone || kind == PrimitiveKind::kLyingCone;
}

bool IsLying(PrimitiveKind kind) {
  return kind == PrimitiveKind::kLyingCylinder || kind == PrimitiveKind::kLyingCone;
}

double SlopeOf(PrimitiveKind kind, const PrimitiveParameters& x) {
  return IsConical(kind) ? x(x.size() - 1) : 0;
}

PlacedPrimitive Place(PrimitiveKind kind, const PrimitiveParameters& x) {
  PlacedPrimitive out;
  switch (kind) {
    case PrimitiveKind::kBall:
      out.X_GS.translation() = x.head<3>();
      out.shape = Sphere{.radius_m = x(3)};
      break;
    case PrimitiveKind::kUprightCylinder:
      out.X_GS.translation() = Vector3(x(0), x(1), 0.5 * x(2));
      out.shape = Cylinder{.radius_m = x(3), .length_m = x(2)};
      break;
    case PrimitiveKind::kUprightCone:
      out.X_GS.translation() = Vector3(x(0), x(1), 0.5 * x(2));
      out.shape =
          Cone{.radius_bottom_m = x(3) - x(4) * x(2), .radius_top_m = x(3), .length_m = x(2)};
      break;
    case PrimitiveKind::kLyingCylinder:
      out = PlaceLying(x, 0);
      out.shape = Cylinder{.radius_m = x(3), .length_m = x(4)};
      break;
    case PrimitiveKind::kLyingCone: {
      const double half_growth_m = 0.5 * x(5) * x(4);
      out = PlaceLying(x, x(5));
      out.shape = Cone{.radius_bottom_m = x(3) - half_growth_m,
                       .radius_top_m = x(3) + half_growth_m,
                       .length_m = x(4)};
      break;
    }
    case PrimitiveKind::kLeaningCylinder:
      return PlaceLeaning(x);
    case PrimitiveKind::kUprightBox:
      out.X_GS.linear() = RotationBy(Vector3(0, 0, x(2)));
      out.X_GS.translation() = Vector3(x(0), x(1), 0.5 * x(5));
      out.shape = Box{.size_m = x.tail<3>()};
      break;
    case PrimitiveKind::kTiltedBox:
      out.X_GS.linear() = RotationBy(x.segment<3>(3));
      out.X_GS.translation() = x.head<3>();
      out.shape = Box{.size_m = x.tail<3>()};
      break;
  }
  return out;
}

std::optional<PrimitiveParameters> ParametersOf(PrimitiveKind kind, const PlacedPrimitive& solid) {
  if (kind == PrimitiveKind::kTiltedBox) return OfTiltedBox(solid);
  const std::optional<Axial> axial = AsAxial(solid);
  if (!axial) return std::nullopt;
  if (IsLying(kind)) return OfLying(kind, *axial);
  if (kind == PrimitiveKind::kLeaningCylinder) return OfLeaning(*axial);
  const bool upright =
      kind == PrimitiveKind::kUprightCylinder || kind == PrimitiveKind::kUprightCone;
  return upright ? OfUpright(kind, *axial) : std::nullopt;
}

}  // namespace cwm::perception
