// Bytes of rows, and the content of errors, for tests of conversions.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "server/core/error.h"

namespace cwm::server {

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
inline constexpr std::int64_t kStoreBytes = 1 << 20;

template <class Number>
std::string BytesOf(const std::vector<Number>& values) {
  return std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Number));
}

template <class Number>
std::vector<Number> NumbersIn(const std::string& bytes) {
  std::vector<Number> values(bytes.size() / sizeof(Number));
  std::copy(bytes.begin(), bytes.end(), reinterpret_cast<char*>(values.data()));
  return values;
}

// The field that an INVALID_ARGUMENT INVALID_FIELD names; empty for any other status.
inline std::string FieldAtFault(const absl::Status& status) {
  const ErrorDetails details = DetailsOf(status);
  if (!absl::IsInvalidArgument(status) || details.reason != "INVALID_FIELD") return "";
  return details.fields.size() == 1 ? details.fields[0].field : "";
}

inline std::string TextOf(const absl::Status& status) { return std::string(status.message()); }

}  // namespace cwm::server
