#include "clients/simulator/text_lines.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "clients/formats/format_error.h"
#include "clients/formats/scalar.h"

namespace cwm::simulator {

std::optional<std::vector<std::string_view>> TextLines::Next() {
  while (const auto line = cursor_.NextLine()) {
    ++line_;
    auto words = formats::SplitWords(*line);
    if (!words.empty()) return words;
  }
  return std::nullopt;
}

absl::Status TextLines::Error(std::string_view field, std::string_view value,
                              std::string_view rule) const {
  return formats::FileError(
      absl::StrCat(file_, ":", line_),
      {.field = std::string(field), .value = std::string(value), .rule = std::string(rule)});
}

absl::StatusOr<std::array<double, 3>> TextLines::ReadPoint(
    const std::vector<std::string_view>& words) const {
  const std::string field(words.front());
  if (words.size() < 4) return Error(field, "", "must have three coordinates");
  std::array<double, 3> point = {};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    char bytes[sizeof(double)];
    const std::string_view word = words[axis + 1];
    if (formats::ParseScalar(word, formats::Scalar::kF64, bytes)) {
      point[axis] = formats::ToDouble(bytes, formats::Scalar::kF64);
      if (std::isfinite(point[axis])) continue;
    }
    return Error(absl::StrCat(field, "[", axis, "]"), word, "must be a finite number");
  }
  return point;
}

}  // namespace cwm::simulator
