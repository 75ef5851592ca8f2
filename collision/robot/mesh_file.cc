#include "collision/robot/mesh_file.h"

#include <array>
#include <string>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "collision/robot/collada_file.h"
#include "collision/robot/glb_file.h"
#include "collision/robot/obj_file.h"
#include "collision/robot/stl_file.h"

namespace cwm::collision {
namespace {

struct Format {
  std::string_view ending;
  absl::StatusOr<TriangleMesh> (*read)(std::string_view, const RobotLimits&);
};
constexpr std::array<Format, 4> kFormats = {
    {{".stl", ReadStl}, {".obj", ReadObj}, {".dae", ReadCollada}, {".glb", ReadGlb}}};

}  // namespace

absl::StatusOr<TriangleMesh> ReadMeshFile(std::string_view bytes, std::string_view name,
                                          const RobotLimits& limits) {
  const std::string lower = absl::AsciiStrToLower(std::string(name));
  for (const Format& format : kFormats) {
    if (!std::string_view(lower).ends_with(format.ending)) continue;
    if (bytes.empty()) return absl::InvalidArgumentError("must not be empty");
    if (bytes.size() <= limits.max_mesh_bytes) return format.read(bytes, limits);
    return absl::ResourceExhaustedError(
        absl::StrCat("is ", bytes.size(), " bytes long, must be at most ", limits.max_mesh_bytes));
  }
  return absl::InvalidArgumentError("must end in .stl, .obj, .dae or .glb");
}

}  // namespace cwm::collision
