// Checks of single numbers in a request.
#pragma once

#include "absl/status/status.h"
#include "server/wire/field_path.h"

namespace cwm::server {

// OK if the value is finite and at most kMaxCoordinate_m in magnitude.
absl::Status CheckCoordinate(double value, const FieldPath& path);
// OK if the value is finite, not negative and at most kMaxCoordinate_m.
absl::Status CheckLength(double value, const FieldPath& path);

struct IntRange {
  std::int64_t min;
  std::int64_t max;
};
absl::Status CheckRange(std::int64_t value, IntRange range, const FieldPath& path);
absl::Status CheckTextLength(const std::string& text, std::int64_t max_bytes,
                             const FieldPath& path);
// OK for a text of at most so many bytes without control characters: it is shown in terminals and
// written to logs.
absl::Status CheckPrintable(const std::string& text, std::int64_t max_bytes, const FieldPath& path);

}  // namespace cwm::server
