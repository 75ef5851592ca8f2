// Writes the container of GLB files.
#pragma once

#include <string>
#include <string_view>

namespace cwm {

// Returns a GLB file of the two chunks. It has no binary chunk if `binary` is empty.
std::string JoinGlb(std::string_view json, std::string_view binary);

}  // namespace cwm
