#include "server/export/drawn_world.h"

#include <functional>
#include <map>
#include <optional>
#include <string_view>
#include <unordered_map>

#include "absl/strings/str_cat.h"
#include "collision/geometry/tessellate.h"
#include "server/core/error.h"
#include "server/export/notes.h"

namespace cwm::server {
namespace {

using collision::PartSource;
using collision::PreparedModel;
using collision::PreparedPart;

MaterialKind MaterialKindOf(const collision::WorldObject& object, const PreparedPart& part) {
  if (object.kind == collision::ObjectKind::kUnseen) return MaterialKind::kUnseen;
  if (object.kind == collision::ObjectKind::kMover) return MaterialKind::kMover;
  if (object.owner == collision::Owner::kUser) return MaterialKind::kUser;
  if (part.source == PartSource::kSurface) return MaterialKind::kSurface;
  if (part.source == PartSource::kHandle) return MaterialKind::kHandle;
  const ShapePart& shape = object.model().shapes[static_cast<std::size_t>(part.index)];
  if (shape.role == PartRole::kCompleted) return MaterialKind::kCompleted;
  return object.kind == collision::ObjectKind::kSupport ? MaterialKind::kSupport
                                                        : MaterialKind::kObject;
}

bool IsClosed(const Shape& shape) {
  const auto* mesh = std::get_if<Mesh>(&shape);
  return mesh == nullptr || mesh->watertight;
}

absl::Status Append(const TriangleMesh& mesh, const Pose& X_BM,
                    const CancellationCheck& check_cancelled, TriangleMesh& all) {
  const auto first = static_cast<std::uint32_t>(all.vertices.size());
  absl::Status status =
      ForEachRange(mesh.vertices.size(), check_cancelled, [&](std::size_t v, std::size_t end) {
        for (; v < end; ++v) all.vertices.push_back(X_BM * mesh.vertices[v]);
      });
  if (!status.ok()) return status;
  return ForEachRange(mesh.triangles.size(), check_cancelled, [&](std::size_t t, std::size_t end) {
    for (; t < end; ++t) {
      const auto& [a, b, c] = mesh.triangles[t];
      all.triangles.push_back({first + a, first + b, first + c});
    }
  });
}

// Collects the parts of one body, parts of the same material together.
class BodyDrawer {
 public:
  absl::Status Add(const PreparedPart& part, MaterialKind material,
                   const CancellationCheck& check_cancelled) {
    const bool is_closed = IsClosed(part.shape);
    DrawnMesh& piece = pieces_[{material, is_closed}];
    piece.material = material;
    piece.is_closed = is_closed;
    const auto* mesh = std::get_if<Mesh>(&part.shape);
    if (mesh == nullptr)
      return Append(Tessellate(part.shape), part.X_OP, check_cancelled, piece.mesh);
    if (mesh->mesh == nullptr) return absl::OkStatus();
    return Append(*mesh->mesh, part.X_OP, check_cancelled, piece.mesh);
  }

  DrawnBody Finish() {
    DrawnBody body;
    for (auto& [key, piece] : pieces_) {
      if (!piece.mesh.triangles.empty()) body.push_back(std::move(piece));
    }
    return body;
  }

 private:
  std::map<std::pair<MaterialKind, bool>, DrawnMesh> pieces_;
};

// Makes equal bodies one, so that the file depends on what the world holds, not on who shares it.
class SharedBodies {
 public:
  std::shared_ptr<const DrawnBody> Share(DrawnBody body) {
    std::size_t hash = 0;
    for (const DrawnMesh& piece : body) {
      const auto& vertices = piece.mesh.vertices;
      const std::string_view bytes(reinterpret_cast<const char*>(vertices.data()),
                                   vertices.size() * sizeof(Vector3));
      hash = 31 * hash + std::hash<std::string_view>()(bytes);
    }
    const auto [first, last] = bodies_.equal_range(hash);
    for (auto known = first; known != last; ++known) {
      if (*known->second == body) return known->second;
    }
    return bodies_.emplace(hash, std::make_shared<const DrawnBody>(std::move(body)))->second;
  }

 private:
  std::unordered_multimap<std::size_t, std::shared_ptr<const DrawnBody>> bodies_;
};

std::vector<std::pair<std::string, std::string>> PropertiesOf(
    const collision::WorldObject& object) {
  std::vector<std::pair<std::string, std::string>> properties = {
      {"uid", object.Uid()},
      {"kind", std::string(NameOf(object.kind))},
      {"owner", std::string(NameOf(object.owner))},
      {"state", std::string(NameOf(object.state))}};
  if (!object.supported_by.empty()) properties.emplace_back("supported_by", object.supported_by);
  if (object.attachment != nullptr) {
    properties.emplace_back("attached_to",
                            absl::StrCat(object.attachment->robot, "/", object.attachment->link));
  }
  return properties;
}

class WorldDrawer {
 public:
  WorldDrawer(std::int64_t max_triangles, const CancellationCheck& check_cancelled)
      : max_triangles_(max_triangles), check_cancelled_(check_cancelled) {}

  absl::Status Add(const collision::WorldObject& object) {
    // The material depends on the geometry, the kind and the owner.
    const Key key{object.geometry.get(), object.kind, object.owner};
    std::shared_ptr<const DrawnBody>& body = body_of_[key];
    if (body == nullptr) {
      BodyDrawer drawer;
      for (const PreparedPart& part : object.geometry->parts) {
        if (std::holds_alternative<HalfSpace>(part.shape)) continue;
        const absl::Status added = drawer.Add(part, MaterialKindOf(object, part), check_cancelled_);
        if (!added.ok()) return added;
      }
      body = bodies_.Share(drawer.Finish());
    }
    for (const PreparedPart& part : object.geometry->parts) {
      if (std::holds_alternative<HalfSpace>(part.shape)) {
        notes_.Add("a half-space is left out, it has no end", object.name);
      }
    }
    return Add({.name = object.name,
                .robot = {},
                .X_WB = object.X_WO,
                .body = body,
                .properties = PropertiesOf(object)});
  }

  absl::Status Add(const collision::WorldRobot& robot) {
    const collision::RobotGeometry& geometry = *robot.robot;
    const std::vector<collision::ModelLink>& links = geometry.model->links;
    std::vector<BodyDrawer> drawers(links.size());
    for (std::size_t k = 0; k < geometry.geometry->parts.size(); ++k) {
      BodyDrawer& drawer = drawers[static_cast<std::size_t>(geometry.link_of_part[k])];
      const absl::Status added =
          drawer.Add(geometry.geometry->parts[k], MaterialKind::kRobot, check_cancelled_);
      if (!added.ok()) return added;
    }
    for (std::size_t i = 0; i < links.size(); ++i) {
      const absl::Status added = Add({.name = links[i].name,
                                      .robot = robot.name,
                                      .X_WB = robot.X_WL[i],
                                      .body = bodies_.Share(drawers[i].Finish())});
      if (!added.ok()) return added;
    }
    return absl::OkStatus();
  }

  DrawnWorld Finish() {
    notes_.AppendTo(world_.warnings);
    return std::move(world_);
  }

 private:
  using Key = std::tuple<const PreparedModel*, collision::ObjectKind, collision::Owner>;

  absl::Status Add(DrawnItem item) {
    for (const DrawnMesh& piece : *item.body) {
      triangles_ += static_cast<std::int64_t>(piece.mesh.triangles.size());
    }
    if (triangles_ > max_triangles_) {
      return MakeError(absl::StatusCode::kResourceExhausted,
                       absl::StrCat("what is drawn up to ", item.name, " has ", triangles_,
                                    " triangles, must have at most ", max_triangles_, " together"),
                       {.reason = "GEOMETRY_TOO_LARGE"});
    }
    if (!item.body->empty()) world_.items.push_back(std::move(item));
    return check_cancelled_();
  }

  const std::int64_t max_triangles_;
  const CancellationCheck& check_cancelled_;
  std::int64_t triangles_ = 0;
  std::map<Key, std::shared_ptr<const DrawnBody>> body_of_;
  SharedBodies bodies_;
  Notes notes_;
  DrawnWorld world_;
};

}  // namespace

std::string_view NameOf(MaterialKind material) {
  switch (material) {
    case MaterialKind::kSupport:
      return "support";
    case MaterialKind::kObject:
      return "object";
    case MaterialKind::kCompleted:
      return "completed";
    case MaterialKind::kSurface:
      return "surface";
    case MaterialKind::kHandle:
      return "handle";
    case MaterialKind::kUnseen:
      return "unseen";
    case MaterialKind::kUser:
      return "user";
    case MaterialKind::kRobot:
      return "robot";
    case MaterialKind::kMover:
      return "mover";
  }
  return "?";
}

std::array<std::uint8_t, 4> ColourOf(MaterialKind material) {
  switch (material) {
    case MaterialKind::kSupport:
      return {176, 168, 153, 255};
    case MaterialKind::kObject:
      return {66, 122, 194, 255};
    case MaterialKind::kCompleted:
      return {158, 189, 224, 255};
    case MaterialKind::kSurface:
      return {203, 128, 74, 255};
    case MaterialKind::kHandle:
      return {214, 168, 45, 255};
    case MaterialKind::kUnseen:
      return {128, 128, 140, 64};
    case MaterialKind::kUser:
      return {92, 158, 106, 255};
    case MaterialKind::kRobot:
      return {224, 224, 228, 255};
    case MaterialKind::kMover:
      return {204, 82, 92, 255};
  }
  return {255, 255, 255, 255};
}

absl::StatusOr<DrawnWorld> DrawWorld(const collision::WorldSnapshot& snapshot,
                                     std::int64_t max_triangles,
                                     const CancellationCheck& check_cancelled) {
  WorldDrawer drawer(max_triangles, check_cancelled);
  for (const collision::WorldObjectPtr& object : snapshot.objects()) {
    if (absl::Status added = drawer.Add(*object); !added.ok()) return added;
  }
  for (const collision::WorldRobotPtr& robot : snapshot.robots()) {
    if (absl::Status added = drawer.Add(*robot); !added.ok()) return added;
  }
  return drawer.Finish();
}

}  // namespace cwm::server
