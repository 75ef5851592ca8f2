// The container of GLB files: a JSON document and a binary chunk.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string_view>

#include "absl/status/statusor.h"

namespace cwm::collision {

struct GlbChunks {
  std::string_view json;
  std::string_view binary;  // empty if the file has none
};

// Splits a file into its chunks, which refer to `bytes`. Refuses lengths that exceed the file.
absl::StatusOr<GlbChunks> SplitGlb(std::string_view bytes);

// Parses a JSON object. Refuses anything else, more than 4 MiB or 250,000 values, nesting deeper
// than 64, and an object with a duplicate key, which another reader may resolve differently.
absl::StatusOr<nlohmann::json> ParseGlbJson(std::string_view text);

}  // namespace cwm::collision
