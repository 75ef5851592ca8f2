// Columns of numbers as bytes, in the precision that was asked for.
#pragma once

#include <bit>
#include <string>
#include <vector>

#include "server/wire/questions.h"

namespace cwm::server {

static_assert(std::endian::native == std::endian::little, "columns are written as they lie");

// The numbers as they lie in memory.
template <class Number>
std::string NumberBytes(const std::vector<Number>& values) {
  return std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Number));
}

// Little-endian doubles or floats; floats are the nearest ones.
std::string Scalars(const std::vector<double>& values, Precision precision);

// Where single precision may not round to.
enum class Bound { kLower, kUpper };

// The values as a column of that precision can hold them, none on the wrong side.
std::vector<double> Rounded(std::vector<double> values, Bound bound, Precision precision);

}  // namespace cwm::server
