// Formats quantities with units for tables.
#pragma once

#include <string>

#include "cwm/v1/geometry.pb.h"

namespace cwm::cli {

// "35.2 mm" below a metre, "1.250 m" above.
std::string FormatLength(double length_m);
// "0.250 x 0.100 x 0.040 m", all in one unit.
std::string FormatSize(const cwm::v1::Box& box);
// "0.412 -0.100 0.051": in metres according to the column's title, or without unit for directions.
std::string FormatVector(const cwm::v1::Vector3& vector);
// "0.412 -0.100 0.051 m", followed by the rotation's angle and axis if it is not zero: "30.0 deg
// about 0.000 0.000 1.000".
std::string FormatPose(const cwm::v1::Pose& pose);
// "97.5 %"
std::string FormatPercent(double ratio);
std::string FormatFixed(double value, int decimals);
// "12.4 MB"
std::string FormatBytes(double bytes);

}  // namespace cwm::cli
