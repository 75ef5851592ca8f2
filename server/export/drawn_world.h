// A world as it is drawn: triangles, colours and names, for files that viewers and modellers open.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "collision/world/world_snapshot.h"
#include "server/export/go_on.h"

namespace cwm::server {

// What a triangle is of, which is what colours tell apart.
enum class Look : std::uint8_t {
  kSupport,
  kObject,
  kCompleted,  // of a support or an object: supplied where nothing was measured
  kSurface,    // triangulated, of whatever has no shape
  kHandle,
  kUnseen,
  kUser,
  kRobot,
};
inline constexpr int kLookCount = 8;

std::string_view NameOf(Look look);  // "support" ...
// Red, green, blue (sRGB) and opacity.
std::array<std::uint8_t, 4> ColourOf(Look look);

// All of a body that looks the same.
struct DrawnPiece {
  Look look = Look::kUser;
  TriangleMesh mesh;      // in the body's frame
  bool is_closed = true;  // an open one is seen from both sides
};
using DrawnBody = std::vector<DrawnPiece>;

// An object, or a link of a robot.
struct DrawnThing {
  std::string name;
  std::string robot;  // whose link it is; empty: an object
  Pose X_WB = Pose::Identity();
  std::shared_ptr<const DrawnBody> body;                        // shared by things of one model
  std::vector<std::pair<std::string, std::string>> facts = {};  // what else is known of it
};

struct DrawnWorld {
  std::string name;
  std::vector<DrawnThing> things;     // objects by name, then robots by name, their links in order
  std::vector<std::string> warnings;  // what is not drawn
};

// What collision checking sees: shapes tessellated (tessellate.h), surfaces, handles. What has no
// end is left out. ResourceExhausted GEOMETRY_TOO_LARGE when all have more than `max_triangles`
// together.
absl::StatusOr<DrawnWorld> Draw(const collision::WorldSnapshot& snapshot,
                                std::int64_t max_triangles, const GoOn& go_on = absl::OkStatus);

// Binary glTF 2.0. A node for each object and each robot, with its facts as extras, below a root
// that turns the world's Z to glTF's Y; things of one model share their mesh. Coordinates are
// single, in the frame of the thing.
absl::StatusOr<std::string> FormatGlb(const DrawnWorld& world, const GoOn& go_on = absl::OkStatus);

// PLY 1.0, binary, little-endian: one mesh in the world's frame with doubles as coordinates, a
// colour for each vertex, and for each face the number of its thing, which comments name.
absl::StatusOr<std::string> FormatPly(const DrawnWorld& world, const GoOn& go_on = absl::OkStatus);

}  // namespace cwm::server
