#include "server/wire/numbers.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "collision/geometry/validation.h"

namespace cwm::server {

absl::Status CheckCoordinate(double value, const FieldPath& path) {
  if (std::abs(value) <= kMaxCoordinate_m) return absl::OkStatus();  // false for NaN
  return path.Error(absl::StrCat("is ", value, ", must be finite and at most ", kMaxCoordinate_m,
                                 " in magnitude"));
}

absl::Status CheckLength(double value, const FieldPath& path) {
  if (value >= 0 && value <= kMaxCoordinate_m) return absl::OkStatus();
  return path.Error(
      absl::StrCat("is ", value, ", must be finite, not negative and at most ", kMaxCoordinate_m));
}

absl::Status CheckRange(std::int64_t value, IntRange range, const FieldPath& path) {
  if (value >= range.min && value <= range.max) return absl::OkStatus();
  return path.Error(absl::StrCat("is ", value, ", must be from ", range.min, " to ", range.max));
}

absl::Status CheckTextLength(const std::string& text, std::int64_t max_bytes,
                             const FieldPath& path) {
  if (static_cast<std::int64_t>(text.size()) <= max_bytes) return absl::OkStatus();
  return path.Error(absl::StrCat("has ", text.size(), " bytes, must have at most ", max_bytes));
}

}  // namespace cwm::server
