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
constexpr double kMinShownAngle_rad = 1e-6;

}  // namespace

std::string FormatFixed(double value, int decimals) {
  const std::string text = absl::StrFormat("%.*f", decimals, value);
  // "-0.000" is zero with a sign from rounding.
  const bool zero = text.find_first_not_of("-0.") == std::string::npos;
  return zero && text[0] == '-' ? text.substr(1) : text;
}

std::string FormatLength(double length_m) {
  if (std::abs(length_m) < 1) return FormatFixed(1000 * length_m, 1) + " mm";
  return FormatFixed(length_m, 3) + " m";
}

std::string FormatSize(const cwm::v1::Box& box) {
  const double largest = std::max({box.size_x_m(), box.size_y_m(), box.size_z_m()});
  const double scale = largest < 1 ? 1000 : 1;
  const int decimals = largest < 1 ? 0 : 3;
  return absl::StrCat(FormatFixed(scale * box.size_x_m(), decimals), " x ",
                      FormatFixed(scale * box.size_y_m(), decimals), " x ",
                      FormatFixed(scale * box.size_z_m(), decimals), largest < 1 ? " mm" : " m");
}

std::string FormatVector(const cwm::v1::Vector3& vector) {
  return absl::StrCat(FormatFixed(vector.x(), 3), " ", FormatFixed(vector.y(), 3), " ",
                      FormatFixed(vector.z(), 3));
}

std::string FormatPose(const cwm::v1::Pose& pose) {
  std::string text = absl::StrCat(FormatFixed(pose.tx_m(), 3), " ", FormatFixed(pose.ty_m(), 3),
                                  " ", FormatFixed(pose.tz_m(), 3), " m");
  const double sine = std::hypot(pose.qx(), pose.qy(), pose.qz());
  const double angle_rad = 2 * std::atan2(sine, std::abs(pose.qw()));
  if (angle_rad < kMinShownAngle_rad) return text;
  const double scale = (pose.qw() < 0 ? -1 : 1) / sine;
  cwm::v1::Vector3 axis;
  axis.set_x(scale * pose.qx());
  axis.set_y(scale * pose.qy());
  axis.set_z(scale * pose.qz());
  return absl::StrCat(text, ", ", FormatFixed(angle_rad * 180 / std::numbers::pi, 1), " deg about ",
                      FormatVector(axis));
}

std::string FormatPercent(double ratio) { return FormatFixed(100 * ratio, 1) + " %"; }

std::string FormatBytes(double bytes) {
  if (bytes < 1e3) return FormatFixed(bytes, 0) + " B";
  if (bytes < 1e6) return FormatFixed(bytes / 1e3, 1) + " kB";
  return FormatFixed(bytes / 1e6, 1) + " MB";
}

}  // namespace cwm::cli
