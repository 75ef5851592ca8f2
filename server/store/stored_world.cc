#include "server/store/stored_world.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "server/store/decode_fault.h"
#include "server/store/encode_entry.h"

namespace cwm::server {
namespace {

std::string PlaceOf(const StoredSnapshot& snapshot) {
  return absl::StrCat("snapshot of world ", snapshot.world_uid);
}

void AddBlob(const store::v1::Mesh& mesh, BlobHashes& blobs) {
  if (mesh.has_blob()) blobs.insert(mesh.blob().sha256());
}

}  // namespace

std::string PlaceOf(const StoredRecord& record) {
  return absl::StrCat("record ", record.sequence, " of world ", record.world_uid);
}

absl::StatusOr<store::v1::Record> ParseRecord(const StoredRecord& stored) {
  store::v1::Record record;
  if (!record.ParseFromString(stored.payload)) return Damaged(PlaceOf(stored), "is no record");
  if (record.world_uid() != stored.world_uid || record.revision() != stored.revision) {
    return Damaged(PlaceOf(stored), "holds another record");
  }
  return record;
}

absl::StatusOr<WorldFold> FoldOf(const StoredSnapshot& stored, const Retention& retention) {
  store::v1::WorldSnapshot snapshot;
  if (!snapshot.ParseFromString(stored.payload)) {
    return Damaged(PlaceOf(stored), "is no snapshot");
  }
  if (snapshot.world_uid() != stored.world_uid || snapshot.revision() != stored.revision) {
    return Damaged(PlaceOf(stored), "holds another snapshot");
  }
  absl::StatusOr<WorldFold> fold = WorldFold::FromSnapshot(std::move(snapshot), retention);
  if (!fold.ok()) return DamagedAt(PlaceOf(stored), fold.status());
  return fold;
}

absl::Status AddBlobs(const store::v1::WorldSnapshot& snapshot, const Store& store,
                      BlobHashes& blobs) {
  for (const store::v1::Object& object : snapshot.objects()) {
    const store::v1::Model& model = object.model();
    for (const store::v1::ShapePart& part : model.shapes()) {
      if (part.shape().has_mesh()) AddBlob(part.shape().mesh(), blobs);
      if (part.shape().has_convex()) AddBlob(part.shape().convex(), blobs);
    }
    for (const store::v1::SurfacePart& part : model.surfaces()) AddBlob(part.surface(), blobs);
    for (const store::v1::Handle& handle : model.handles()) AddBlob(handle.surface(), blobs);
  }
  for (const store::v1::Robot& robot : snapshot.robots()) {
    const absl::Status status = AddRobotBlobs(robot.files().sha256(), store, blobs);
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace cwm::server
