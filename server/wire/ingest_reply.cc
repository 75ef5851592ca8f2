// The reply to an ingest; declared in clouds.h.
#include <string>
#include <utility>
#include <vector>

#include "server/wire/clouds.h"
#include "server/wire/objects.h"
#include "server/wire/poses.h"

namespace cwm::server {
namespace {

void SetNames(const std::vector<std::string>& names,
              google::protobuf::RepeatedPtrField<std::string>* proto) {
  proto->Assign(names.begin(), names.end());
}

void SetReport(const IngestOutcome& outcome, v1::IngestCloudResponse* response) {
  const perception::InterpretReport& report = outcome.report;
  v1::IngestReport* proto = response->mutable_report();
  proto->set_unchanged_view(outcome.unchanged_view);
  proto->set_points_in(static_cast<std::int64_t>(report.points_in));
  proto->set_points_finite(static_cast<std::int64_t>(report.points_finite));
  proto->set_points_explained(static_cast<std::int64_t>(report.points_explained));
  proto->set_points_rejected(static_cast<std::int64_t>(report.points_rejected));
  SetNames(report.warnings, proto->mutable_warnings());
  for (const perception::StageTime& time : report.stages) {
    v1::StageTime* stage = response->add_stages();
    stage->set_stage(time.stage);
    stage->set_elapsed_ms(time.elapsed_ms);
  }
}

void SetChanges(const IngestOutcome& outcome, v1::IngestChanges* changes) {
  SetNames(outcome.added, changes->mutable_added());
  SetNames(outcome.moved, changes->mutable_moved());
  SetNames(outcome.replaced, changes->mutable_replaced());
  SetNames(outcome.removed, changes->mutable_removed());
  SetNames(outcome.kept, changes->mutable_kept());
  SetNames(outcome.occluded, changes->mutable_occluded());
}

// A provisional object belongs to no world; a world's object of the same name is another one.
Observation ObservationOf(const collision::WorldObject& object, const World& world) {
  return object.create_revision.value == 0 ? Observation{} : world.observations().Get(object.name);
}

absl::Status StoreMesh(const std::shared_ptr<const TriangleMesh>& mesh, GeometryStore& store) {
  if (mesh == nullptr || mesh->triangles.empty()) return absl::OkStatus();
  return store.Put(BlobFormat::kMeshF64, EncodeMesh(*mesh)).status();
}

// The meshes of a provisional object would be freed with it. They are stored like labels, so that
// the client can read the hashes in the reply.
absl::Status StoreMeshes(const collision::WorldObject& object, GeometryStore& store) {
  if (object.create_revision.value != 0 || object.geometry == nullptr) return absl::OkStatus();
  for (const ShapePart& part : object.model().shapes) {
    const auto* mesh = std::get_if<Mesh>(&part.shape);  // a vessel's wall
    if (mesh == nullptr) continue;
    if (absl::Status stored = StoreMesh(mesh->mesh, store); !stored.ok()) return stored;
  }
  for (const SurfacePart& part : object.model().surfaces) {
    if (absl::Status stored = StoreMesh(part.surface.mesh, store); !stored.ok()) return stored;
  }
  for (const Handle& handle : object.model().handles) {
    if (absl::Status stored = StoreMesh(handle.surface.mesh, store); !stored.ok()) return stored;
  }
  return absl::OkStatus();
}

absl::Status SetObjects(const IngestReply& reply, GeometryStore& store,
                        v1::IngestCloudResponse* response) {
  const IngestOutcome& outcome = reply.outcome;
  for (std::size_t i = 0; i < outcome.supports.size(); ++i) {
    const collision::WorldObject& support = *outcome.supports[i];
    v1::Object* proto = response->add_supports();
    *proto = ObjectToProto(support, View::kFull, ObservationOf(support, reply.world), store);
    if (i < outcome.support_reachable.size() && outcome.support_reachable[i].has_value()) {
      proto->set_reachable(*outcome.support_reachable[i]);
    }
    if (absl::Status stored = StoreMeshes(support, store); !stored.ok()) return stored;
  }
  for (const collision::WorldObjectPtr& object : outcome.objects) {
    v1::Object* proto = response->add_objects();  // stays empty if a user's object explains it
    if (object == nullptr) continue;
    *proto = ObjectToProto(*object, View::kFull, ObservationOf(*object, reply.world), store);
    if (absl::Status stored = StoreMeshes(*object, store); !stored.ok()) return stored;
  }
  return absl::OkStatus();
}

absl::Status SetLabels(const std::vector<std::uint32_t>& labels, const Limits& limits,
                       GeometryStore& store, v1::IngestCloudResponse* response) {
  std::string bytes(reinterpret_cast<const char*>(labels.data()),
                    labels.size() * sizeof(std::uint32_t));
  if (static_cast<std::int64_t>(bytes.size()) <= limits.max_inline_bytes) {
    response->set_labels(std::move(bytes));
    return absl::OkStatus();
  }
  auto stored = store.Put(BlobFormat::kLabelsU32, std::move(bytes));
  if (!stored.ok()) return stored.status();
  response->set_labels_hash(stored->hash);
  return absl::OkStatus();
}

}  // namespace

absl::Status IngestReplyToProto(const IngestReply& reply, const Limits& limits,
                                GeometryStore& store, v1::IngestCloudResponse* response) {
  response->set_world_uid(reply.world.uid());
  response->set_revision(reply.outcome.revision.value);
  *response->mutable_x_world_sensor() = PoseToProto(reply.outcome.X_WC);
  SetReport(reply.outcome, response);
  if (absl::Status status = SetObjects(reply, store, response); !status.ok()) return status;
  SetChanges(reply.outcome, response->mutable_changes());
  if (!reply.want_point_labels) return absl::OkStatus();
  return SetLabels(reply.outcome.labels, limits, store, response);
}

}  // namespace cwm::server
