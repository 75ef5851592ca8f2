#include "server/wire/numbers.h"

#include <cmath>
#include <cstddef>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "collision/geometry/validation.h"

namespace cwm::server {

namespace {

// Those of ASCII, and those from U+0080 to U+009F in UTF-8.
bool HasControlCharacter(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if (byte < 0x20 || byte == 0x7f) return true;
    const bool has_next = i + 1 < text.size();
    if (byte == 0xc2 && has_next && static_cast<unsigned char>(text[i + 1]) < 0xa0) return true;
  }
  return false;
}

}  // namespace

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

absl::Status CheckPrintable(const std::string& text, std::int64_t max_bytes,
                            const FieldPath& path) {
  if (auto status = CheckTextLength(text, max_bytes, path); !status.ok()) return status;
  if (!HasControlCharacter(text)) return absl::OkStatus();
  return path.Error(
      absl::StrCat("is \"", absl::CHexEscape(text), "\", must have no control characters"));
}

}  // namespace cwm::server
