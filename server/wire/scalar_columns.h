// Columns of numbers as bytes, in the requested precision.
#pragma once

#include <bit>
#include <string>
#include <vector>

#include "server/wire/queries.h"

namespace cwm::server {

static_assert(std::endian::native == std::endian::little, "columns are written as they lie");

// The bytes of the numbers in memory.
template <class Number>
std::string NumberBytes(const std::vector<Number>& values) {
  return std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Number));
}

// Little-endian doubles or floats; floats are rounded to nearest.
std::string Scalars(const std::vector<double>& values, Precision precision);

// The kind of bound that a value is: rounding may only lower a lower bound and only raise an upper
// bound.
enum class Bound { kLower, kUpper };

// The values rounded to the given precision such that they stay bounds.
std::vector<double> Rounded(std::vector<double> values, Bound bound, Precision precision);

}  // namespace cwm::server
