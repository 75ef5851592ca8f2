// XYZ, points as lines of text, and its relatives: ASC, CSV, the text that CloudCompare and
// spreadsheets write.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "clients/formats/cloud_file.h"

namespace cwm::formats {

// Whether the first line that is neither empty nor a comment begins with three numbers, or names
// columns x, y and z.
bool LooksLikeXyz(std::string_view bytes);

// One point a line: numbers between blanks, commas or semicolons, as double precision. Comments are
// lines that begin with "#" or "//"; they may stand anywhere.
// - Where the last line before the first point, a comment or not, names columns x, y and z among
//   others ("# x y z nx ny nz", "//X Y Z R G B", "x,y,z,intensity"), each is a field of that name in
//   lower case; nx ny nz are normal_x normal_y normal_z. Every line must have as many numbers.
//   At most 256 columns may be named.
// - Else the first three numbers of a line are x y z and what follows is left out.
// "nan" stands for a point that was not measured. The cloud is not organised.
absl::StatusOr<CloudFile> ParseXyz(std::string_view bytes, const std::string& file);

}  // namespace cwm::formats
