// The header of an NPY file: a Python dictionary literal.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/formats/scalar.h"

namespace cwm::formats {

// A member of a structured type: ("x", "<f4"), or ("rgb", "|u1", (3,)).
struct NpyMember {
  std::string name;
  std::string type;                 // "<f4"
  std::vector<std::int64_t> shape;  // for a subarray
};

struct NpyHeader {
  std::string type;                // "<f8"; empty: structured
  std::vector<NpyMember> members;  // for a structured type
  bool fortran_order = false;
  std::vector<std::int64_t> shape;
  std::size_t data_begin = 0;  // offset in the file
};

// The type of numbers in a file: "<f4".
struct NpyType {
  Scalar type;
  bool big_endian = false;
};
// Empty for anything but integers and floats of 1 to 8 bytes.
std::optional<NpyType> NumberType(std::string_view text);

// chosen: a plain array has at most so many columns, as a point has few numbers; an image of depths
// has more.
inline constexpr std::int64_t kMaxNpyColumns = 16;

// Numbers of shapes are at least 0. INVALID_ARGUMENT with the byte offset where the dictionary is
// not as numpy writes it.
absl::StatusOr<NpyHeader> ParseNpyHeader(std::string_view bytes, const std::string& file);

}  // namespace cwm::formats
