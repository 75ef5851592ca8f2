// XYZ: points as lines of text, and its relatives ASC, CSV and the text files of CloudCompare and
// spreadsheets.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "clients/formats/cloud_file.h"

namespace cwm::formats {

// True if the first line that is neither empty, a comment nor a count begins with three numbers, or
// names columns x, y and z.
bool LooksLikeXyz(std::string_view bytes);

// Reads one point per line: numbers separated by blanks, commas or semicolons, in double precision.
// Lines that begin with "#" or "//" are comments and may occur anywhere.
// - If the last line before the first point, a comment or not, names columns including x, y and z
//   ("# x y z nx ny nz", "//X Y Z R G B", "x,y,z,intensity"), each column is a field of that name
//   in lower case; nx ny nz are normal_x normal_y normal_z. Every line must have as many numbers.
//   At most 256 columns may be named.
// - Otherwise the first three numbers of a line are x y z, and further ones are ignored.
// A line of one whole number before the points counts those that follow, and must be right. The
// first column may have an empty name: an index.
// "nan" marks an unmeasured point. The cloud is not organised.
absl::StatusOr<CloudFile> ParseXyz(std::string_view bytes, const std::string& file);

}  // namespace cwm::formats
