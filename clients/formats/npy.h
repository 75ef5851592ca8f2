// NPY, the file format of numpy.save.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "clients/formats/cloud_file.h"

namespace cwm::formats {

inline constexpr std::string_view kNpyMagic = "\x93NUMPY";

// Reads versions 1 to 3, either byte order, C and Fortran order:
// - float32 or float64 of shape (N, 3), or (H, W, 3) for an organised cloud: x y z; of up to 16
//   columns, as with intensities or colours, the first three are taken;
// - a structured type of shape (N) or (H, W) with x, y and z among its members, which may be
//   integers, floats and subarrays of these; nx ny nz are normal_x normal_y normal_z. Padding is
//   dropped.
// Objects (unpickling them would run code), other shapes and types, and data that does not match
// the shape are refused.
absl::StatusOr<CloudFile> ParseNpy(std::string_view bytes, const std::string& file);

}  // namespace cwm::formats
