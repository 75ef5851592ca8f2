#include "server/core/approximate_bytes.h"

namespace cwm::server {
namespace {

using collision::PreparedModel;
using collision::WorldObject;

// A primitive in three engines, each a few hundred bytes with its allocation (sizeof of FCL's and
// Bullet's shapes: 100 to 300).
constexpr std::int64_t kPreparedPartBytes = 1'000;
// Per triangle: mesh 12 + half a vertex 12; FCL two OBBRSS nodes of 256; Bullet two quantised nodes
// of 16 and its copy; the exact kernels' boxes.
constexpr std::int64_t kTriangleBytes = 700;
// A leaf and an inner node of the tree (box 48 and indices), and the pointer.
constexpr std::int64_t kSnapshotEntryBytes = 144;
// Four names beyond the small-string size, at half of their longest.
constexpr std::int64_t kRuleExtraBytes = 250;
// A name, a uid and a supporter beyond the small-string size, and the shared pointer's block.
constexpr std::int64_t kObjectExtraBytes = 150;

std::int64_t Triangles(const Mesh& mesh) {
  return mesh.mesh == nullptr ? 0 : static_cast<std::int64_t>(mesh.mesh->triangles.size());
}

std::int64_t Triangles(const Shape& shape) {
  if (const Mesh* mesh = std::get_if<Mesh>(&shape)) return Triangles(*mesh);
  const Convex* convex = std::get_if<Convex>(&shape);
  return convex == nullptr || convex->hull == nullptr
             ? 0
             : static_cast<std::int64_t>(convex->hull->triangles.size());
}

std::int64_t GeometryBytes(const PreparedModel& geometry) {
  std::int64_t triangles = 0;
  for (const ShapePart& part : geometry.model->shapes) triangles += Triangles(part.shape);
  for (const SurfacePart& part : geometry.model->surfaces) triangles += Triangles(part.surface);
  for (const Handle& handle : geometry.model->handles) triangles += Triangles(handle.surface);
  return triangles * kTriangleBytes +
         static_cast<std::int64_t>(geometry.parts.size()) * kPreparedPartBytes;
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
  // Names, indices by name, groups and spheres: as much again.
  const std::size_t tree = 2 * (model.links.size() * sizeof(collision::ModelLink) +
                                model.variables.size() * sizeof(collision::Variable));
  const std::size_t pairs = model.self_pairs.size() * sizeof(collision::LinkPair);
  return static_cast<std::int64_t>(tree + pairs) + GeometryBytes(*robot.geometry);
}

}  // namespace

std::int64_t ApproximateBytes(const WorldObject& object) {
  return OwnBytes(object) + GeometryBytes(*object.geometry);
}

std::int64_t ApproximateOwnBytes(const collision::WorldSnapshot& snapshot) {
  return static_cast<std::int64_t>(sizeof(snapshot)) +
         static_cast<std::int64_t>(snapshot.objects().size()) * kSnapshotEntryBytes +
         static_cast<std::int64_t>(snapshot.robots().size() * sizeof(collision::WorldRobotPtr));
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
