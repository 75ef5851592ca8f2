// NPY, the file that numpy.save writes.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "clients/formats/cloud_file.h"

namespace cwm::formats {

inline constexpr std::string_view kNpyMagic = "\x93NUMPY";

// Versions 1 to 3, either byte order, C order:
// - float32 or float64 of shape (N, 3), or (H, W, 3) for an organised cloud: x y z;
// - a structured type of shape (N) or (H, W) with x, y and z among its members, which may be
//   integers, floats and subarrays of these; nx ny nz are normal_x normal_y normal_z. Padding is
//   dropped.
// Refused are objects (pickled, they would run code), Fortran order, other shapes and types, and
// data that is not as long as the shape says.
absl::StatusOr<CloudFile> ParseNpy(std::string_view bytes, const std::string& file);

}  // namespace cwm::formats
