// The text header of a PCD file.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/formats/cloud_file.h"
#include "clients/formats/text_cursor.h"

namespace cwm::formats {

enum class PcdEncoding { kAscii, kBinary, kBinaryCompressed };

struct PcdHeader {
  std::vector<CloudField> fields;  // with padding ("_"), laid out as in the file
  std::size_t point_step = 0;      // at most kMaxPcdPointStep
  std::int64_t width = 0;
  std::int64_t height = 0;  // width * height does not overflow
  std::array<double, 7> viewpoint = {0, 0, 0, 1, 0, 0, 0};
  PcdEncoding encoding = PcdEncoding::kAscii;

  std::int64_t points() const { return width * height; }
};

// chosen: FPFH-like descriptors take 1.3 KiB per point; no valid file is wider than this.
inline constexpr std::size_t kMaxPcdPointStep = 1 << 16;

// Consumes the header; the cursor is then at the first byte of the data.
absl::StatusOr<PcdHeader> ParsePcdHeader(TextCursor& cursor, const std::string& file);

}  // namespace cwm::formats
