// A world for drawing: triangles, colours and names, for files that viewers and modellers open.
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
#include "server/export/cancellation_check.h"

namespace cwm::server {

// The kind of body that a triangle belongs to; each material has its own colour.
enum class MaterialKind : std::uint8_t {
  kSupport,
  kObject,
  kCompleted,  // part of a support or an object that was completed without measurements
  kSurface,    // triangulated surface of an object without a shape
  kHandle,
  kUnseen,
  kUser,
  kRobot,
  kMover,  // a piece of something that moves and is not modelled
};
inline constexpr int kMaterialKindCount = 9;

std::string_view NameOf(MaterialKind material);  // "support" ...
// Red, green, blue (sRGB) and opacity.
std::array<std::uint8_t, 4> ColourOf(MaterialKind material);

// All parts of a body with the same material.
struct DrawnMesh {
  MaterialKind material = MaterialKind::kUser;
  TriangleMesh mesh;      // in the body's frame
  bool is_closed = true;  // an open one is drawn from both sides
  friend bool operator==(const DrawnMesh&, const DrawnMesh&) = default;
};
using DrawnBody = std::vector<DrawnMesh>;

// An object, or a link of a robot.
struct DrawnItem {
  std::string name;
  std::string robot;  // the robot that has the link; empty: an object
  Pose X_WB = Pose::Identity();
  std::shared_ptr<const DrawnBody> body;                             // equal bodies are one
  std::vector<std::pair<std::string, std::string>> properties = {};  // further properties, by name
};

struct DrawnWorld {
  std::string name;
  std::vector<DrawnItem> items;       // objects by name, then robots by name, their links in order
  std::vector<std::string> warnings;  // what is not drawn, and why
};

// Draws what collision checking sees: tessellated shapes (tessellate.h), surfaces, handles.
// Unbounded shapes are left out. ResourceExhausted GEOMETRY_TOO_LARGE if the total is more than
// `max_triangles`.
absl::StatusOr<DrawnWorld> DrawWorld(const collision::WorldSnapshot& snapshot,
                                     std::int64_t max_triangles,
                                     const CancellationCheck& check_cancelled = absl::OkStatus);

// Binary glTF 2.0. A node for each object and each robot, with its properties as extras, below a
// root that rotates the world's Z to glTF's Y. Objects of one model share their mesh. Coordinates
// are single precision, in the object's frame.
absl::StatusOr<std::string> FormatGlb(const DrawnWorld& world,
                                      const CancellationCheck& check_cancelled = absl::OkStatus);

// PLY 1.0, binary, little-endian: one mesh in the world's frame with double coordinates, a colour
// per vertex, and per face the number of its object; the header's comments name the objects.
absl::StatusOr<std::string> FormatPly(const DrawnWorld& world,
                                      const CancellationCheck& check_cancelled = absl::OkStatus);

}  // namespace cwm::server
