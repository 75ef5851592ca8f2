#include "server/core/approximate_bytes.h"

#include <algorithm>
#include <bit>
#include <variant>
#include <vector>

namespace cwm::server {
namespace {

using collision::PreparedModel;
using collision::WorldObject;

// derived: from sizeof on x86-64, per primitive: 288 bytes in the model, 288 prepared, 256 for its
// engine forms and 730 more for the kernels' form. The forms of FCL and Bullet are made on first
// use and not counted.
constexpr std::int64_t kPreparedPartBytes = 1'600;
// derived: likewise, per triangle: 12 bytes of indices, 72 for its corners in the kernels' tree and
// two tree nodes of 72. FCL's form takes four times as much if it is used.
constexpr std::int64_t kTriangleBytes = 228;
constexpr std::int64_t kMeshVertexBytes = sizeof(Vector3);
// An object's share of a tree leaf and of the nodes above it, and its node in the table of names.
constexpr std::int64_t kSnapshotEntryBytes = 200;
// derived: bytes that one change copies per doubling of the world's size: about 1.5 nodes of 64
// bytes in the table of names and two in the tree (of the object's old and new place). It copies
// two leaves besides.
constexpr std::int64_t kCopiedBytesPerDoubling = 224;
constexpr std::int64_t kCopiedLeafBytes = 384;
// Four names beyond the small-string size, at half of their maximum length.
constexpr std::int64_t kRuleExtraBytes = 250;
// A name, a uid and a supporter beyond the small-string size, and the shared pointer's block.
constexpr std::int64_t kObjectExtraBytes = 150;

const TriangleMesh* MeshIn(const Shape& shape) {
  if (const Mesh* mesh = std::get_if<Mesh>(&shape)) return mesh->mesh.get();
  const Convex* convex = std::get_if<Convex>(&shape);
  return convex == nullptr ? nullptr : convex->hull.get();
}

// Counts a mesh that several parts share once, together with its prepared form.
std::int64_t GeometryBytes(const PreparedModel& geometry) {
  std::vector<const TriangleMesh*> meshes;
  const auto add = [&meshes](const TriangleMesh* mesh) {
    if (mesh != nullptr && (meshes.empty() || meshes.back() != mesh)) meshes.push_back(mesh);
  };
  for (const ShapePart& part : geometry.model->shapes) add(MeshIn(part.shape));
  for (const SurfacePart& part : geometry.model->surfaces) add(part.surface.mesh.get());
  for (const Handle& handle : geometry.model->handles) add(handle.surface.mesh.get());
  std::sort(meshes.begin(), meshes.end());
  meshes.erase(std::unique(meshes.begin(), meshes.end()), meshes.end());
  MeshTotals counts;
  for (const TriangleMesh* mesh : meshes) {
    counts.triangles += static_cast<std::int64_t>(mesh->triangles.size());
    counts.vertices += static_cast<std::int64_t>(mesh->vertices.size());
  }
  return ApproximatePreparedBytes(static_cast<std::int64_t>(geometry.parts.size()), counts);
}

constexpr std::int64_t kPlacedPartBytes = sizeof(Pose) + sizeof(Aabb);

std::int64_t OwnBytes(const WorldObject& object) {
  const std::int64_t attachment =
      object.attachment == nullptr
          ? 0
          : static_cast<std::int64_t>(sizeof(collision::Attachment)) + kObjectExtraBytes;
  return static_cast<std::int64_t>(sizeof(WorldObject)) + kObjectExtraBytes + attachment +
         static_cast<std::int64_t>(object.geometry->parts.size()) * kPlacedPartBytes;
}

std::int64_t OwnBytes(const collision::WorldRobot& robot) {
  return static_cast<std::int64_t>(sizeof(robot) + robot.state.size() * sizeof(double) +
                                   robot.X_WL.size() * sizeof(Pose)) +
         static_cast<std::int64_t>(robot.body.parts_W.size()) * kPlacedPartBytes +
         kObjectExtraBytes;
}

std::int64_t Bytes(const collision::RobotGeometry& robot) {
  const collision::RobotModel& model = *robot.model;
  // The factor 2 covers names, indices by name, groups and spheres.
  const std::size_t tree = 2 * (model.links.size() * sizeof(collision::ModelLink) +
                                model.variables.size() * sizeof(collision::Variable));
  const std::size_t pairs = model.self_pairs.size() * sizeof(collision::LinkPair);
  return static_cast<std::int64_t>(tree + pairs) + GeometryBytes(*robot.geometry);
}

std::int64_t RobotListBytes(const collision::WorldSnapshot& snapshot) {
  return static_cast<std::int64_t>(snapshot.robots().size() * sizeof(collision::WorldRobotPtr));
}

}  // namespace

std::int64_t ApproximatePreparedBytes(std::int64_t parts, const MeshTotals& meshes) {
  return meshes.triangles * kTriangleBytes + meshes.vertices * kMeshVertexBytes +
         parts * kPreparedPartBytes;
}

std::int64_t ApproximateBytes(const collision::PutObject& put) {
  return static_cast<std::int64_t>(sizeof(WorldObject)) + kObjectExtraBytes + kSnapshotEntryBytes +
         static_cast<std::int64_t>(put.geometry->parts.size()) * kPlacedPartBytes +
         GeometryBytes(*put.geometry);
}

std::int64_t ApproximateBytes(const collision::RobotGeometry& robot) { return Bytes(robot); }

std::int64_t ApproximateBytes(const WorldObject& object) {
  return OwnBytes(object) + GeometryBytes(*object.geometry);
}

std::int64_t ApproximateOwnBytes(const collision::WorldSnapshot& snapshot) {
  return static_cast<std::int64_t>(sizeof(snapshot)) +
         static_cast<std::int64_t>(snapshot.objects().size()) * kSnapshotEntryBytes +
         RobotListBytes(snapshot);
}

std::int64_t ApproximateOwnBytes(const collision::WorldSnapshot& snapshot,
                                 std::size_t changed_objects) {
  const std::size_t count = snapshot.objects().size();
  const std::int64_t copied =
      kCopiedLeafBytes + static_cast<std::int64_t>(std::bit_width(count)) * kCopiedBytesPerDoubling;
  const std::int64_t alone = static_cast<std::int64_t>(count) * kSnapshotEntryBytes;
  return static_cast<std::int64_t>(sizeof(snapshot)) + RobotListBytes(snapshot) +
         std::min(static_cast<std::int64_t>(changed_objects) * copied, alone);
}

std::int64_t ApproximateSupersededBytes(std::span<const collision::ObjectDelta> deltas) {
  std::int64_t bytes = 0;
  for (const collision::ObjectDelta& delta : deltas) {
    if (delta.before == nullptr) continue;
    bytes += OwnBytes(*delta.before);
    const bool shared = delta.after != nullptr && delta.after->geometry == delta.before->geometry;
    if (!shared) bytes += GeometryBytes(*delta.before->geometry);
  }
  return bytes;
}

std::int64_t ApproximateSupersededBytes(std::span<const collision::RobotDelta> deltas) {
  std::int64_t bytes = 0;
  for (const auto& [before, after] : deltas) {
    if (before == nullptr) continue;
    bytes += OwnBytes(*before);
    if (after == nullptr || after->robot != before->robot) bytes += Bytes(*before->robot);
  }
  return bytes;
}

std::int64_t ApproximateBytes(const collision::PairRules& rules) {
  return static_cast<std::int64_t>(rules.size()) *
         (static_cast<std::int64_t>(sizeof(collision::PairRule)) + kRuleExtraBytes);
}

std::int64_t ApproximateBytes(std::span<const collision::PairRuleDelta> deltas) {
  return static_cast<std::int64_t>(deltas.size()) *
         (static_cast<std::int64_t>(sizeof(collision::PairRuleDelta)) + 2 * kRuleExtraBytes);
}

}  // namespace cwm::server
