// The container of GLB files: a JSON document and a binary chunk.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string_view>

#include "absl/status/statusor.h"

namespace cwm::collision {

struct GlbChunks {
  std::string_view json;
  std::string_view binary;  // empty where the file has none
};

// The chunks of a file, which must outlive them. Refuses lengths that leave the file.
absl::StatusOr<GlbChunks> SplitGlb(std::string_view bytes);

// Refuses what is no JSON object, more than 4 MiB or 250,000 values of it, nesting deeper than 64, and
// an object that has a key twice, which another reader may understand differently.
absl::StatusOr<nlohmann::json> ParseGlbJson(std::string_view text);

}  // namespace cwm::collision
