// The lines of a mesh written as text, and how their errors are told.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "clients/formats/text_cursor.h"

namespace cwm::simulator {

class TextLines {
 public:
  TextLines(std::string_view bytes, std::string file) : cursor_(bytes), file_(std::move(file)) {}

  // The words of the next line that has any; nothing at the end.
  std::optional<std::vector<std::string_view>> Next();

  // "FILE:LINE: FIELD is VALUE, RULE", about the line read last.
  absl::Status Error(std::string_view field, std::string_view value, std::string_view rule) const;

  // The three finite numbers after the first word.
  absl::StatusOr<std::array<double, 3>> ReadPoint(const std::vector<std::string_view>& words) const;

 private:
  formats::TextCursor cursor_;
  std::string file_;
  int line_ = 0;
};

}  // namespace cwm::simulator
