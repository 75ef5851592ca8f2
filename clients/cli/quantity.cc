#include "clients/cli/quantity.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace cwm::cli {
namespace {

// derived: a smaller rotation is rounding of a quaternion; 1e-6 rad moves the end of a 1 m object
// by 1 um.
constexpr double kSmallestShownAngle_rad = 1e-6;

}  // namespace

std::string Fixed(double value, int decimals) {
  const std::string text = absl::StrFormat("%.*f", decimals, value);
  // "-0.000" is zero with a sign from rounding.
  const bool zero = text.find_first_not_of("-0.") == std::string::npos;
  return zero && text[0] == '-' ? text.substr(1) : text;
}

std::string Length(double length_m) {
  if (std::abs(length_m) < 1) return Fixed(1000 * length_m, 1) + " mm";
  return Fixed(length_m, 3) + " m";
}

std::string Size(const cwm::v1::Box& box) {
  const double largest = std::max({box.size_x_m(), box.size_y_m(), box.size_z_m()});
  const double scale = largest < 1 ? 1000 : 1;
  const int decimals = largest < 1 ? 0 : 3;
  return absl::StrCat(Fixed(scale * box.size_x_m(), decimals), " x ",
                      Fixed(scale * box.size_y_m(), decimals), " x ",
                      Fixed(scale * box.size_z_m(), decimals), largest < 1 ? " mm" : " m");
}

std::string Vector(const cwm::v1::Vector3& vector) {
  return absl::StrCat(Fixed(vector.x(), 3), " ", Fixed(vector.y(), 3), " ", Fixed(vector.z(), 3));
}

std::string PoseText(const cwm::v1::Pose& pose) {
  std::string text = absl::StrCat(Fixed(pose.tx_m(), 3), " ", Fixed(pose.ty_m(), 3), " ",
                                  Fixed(pose.tz_m(), 3), " m");
  const double sine = std::hypot(pose.qx(), pose.qy(), pose.qz());
  const double angle_rad = 2 * std::atan2(sine, std::abs(pose.qw()));
  if (angle_rad < kSmallestShownAngle_rad) return text;
  const double scale = (pose.qw() < 0 ? -1 : 1) / sine;
  cwm::v1::Vector3 axis;
  axis.set_x(scale * pose.qx());
  axis.set_y(scale * pose.qy());
  axis.set_z(scale * pose.qz());
  return absl::StrCat(text, ", ", Fixed(angle_rad * 180 / std::numbers::pi, 1), " deg about ",
                      Vector(axis));
}

std::string Percent(double ratio) { return Fixed(100 * ratio, 1) + " %"; }

std::string Bytes(double bytes) {
  if (bytes < 1e3) return Fixed(bytes, 0) + " B";
  if (bytes < 1e6) return Fixed(bytes / 1e3, 1) + " kB";
  return Fixed(bytes / 1e6, 1) + " MB";
}

}  // namespace cwm::cli
