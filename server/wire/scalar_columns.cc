#include "server/wire/scalar_columns.h"

#include <cmath>
#include <cstring>
#include <limits>

namespace cwm::server {

std::string Scalars(const std::vector<double>& values, Precision precision) {
  if (precision == Precision::kDouble) return NumberBytes(values);
  std::string bytes(values.size() * sizeof(float), '\0');
  char* out = bytes.data();
  for (const double value : values) {
    const auto single = static_cast<float>(value);
    std::memcpy(out, &single, sizeof(single));
    out += sizeof(single);
  }
  return bytes;
}

std::vector<double> Rounded(std::vector<double> values, Bound bound, Precision precision) {
  if (precision == Precision::kDouble) return values;
  const float outward = bound == Bound::kLower ? -std::numeric_limits<float>::infinity()
                                               : std::numeric_limits<float>::infinity();
  for (double& value : values) {
    auto single = static_cast<float>(value);
    const bool is_inside = bound == Bound::kLower ? single > value : single < value;
    if (is_inside) single = std::nextafter(single, outward);
    value = single;
  }
  return values;
}

}  // namespace cwm::server
