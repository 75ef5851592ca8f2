// The text header of a PLY file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/formats/scalar.h"
#include "clients/formats/text_cursor.h"

namespace cwm::formats {

enum class PlyEncoding { kAscii, kLittleEndian, kBigEndian };

struct PlyProperty {
  std::string name;
  Scalar type = Scalar::kF32;
  std::optional<Scalar> list_count = {};  // for a list: the integer type of its length
};

struct PlyElement {
  std::string name;
  std::int64_t count = 0;
  std::vector<PlyProperty> properties = {};  // at least one

  // The minimum number of bytes of a row (with empty lists).
  std::size_t MinRowBytes(PlyEncoding encoding) const;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  std::vector<PlyElement> elements;  // in the order of the data
};

// Consumes the header; the cursor is then at the first byte of the data.
absl::StatusOr<PlyHeader> ParsePlyHeader(TextCursor& cursor, const std::string& file);

}  // namespace cwm::formats
