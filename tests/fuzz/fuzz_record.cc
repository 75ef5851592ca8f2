#include <google/protobuf/stubs/logging.h>

#include <memory>
#include <string>
#include <vector>

#include "cwm/store/v1/record.pb.h"
#include "proto/transfer/mesh_bytes.h"
#include "server/core/error.h"
#include "server/store/compaction.h"
#include "server/store/memory_store.h"
#include "server/store/replay.h"
#include "tests/fuzz/fuzz_target.h"

namespace {

using cwm::server::MemoryDisk;

// The disk of a store whose only world has the records.
MemoryDisk DiskOf(const std::vector<cwm::store::v1::Record>& records) {
  MemoryDisk disk;
  for (const cwm::store::v1::Record& record : records) {
    const std::int64_t sequence = ++disk.last_sequence;
    disk.records[sequence] = {.sequence = sequence,
                              .epoch = 1,
                              .world_uid = record.world_uid(),
                              .revision = record.revision(),
                              .payload = record.SerializeAsString(),
                              .blobs = {}};
  }
  return disk;
}

// Creates the world with one object.
cwm::store::v1::Record FirstRecord() {
  cwm::store::v1::Record record;
  record.set_world_uid("uid");
  record.set_created_name("w");
  record.set_revision(1);
  record.mutable_write()->set_makes_revision(true);
  cwm::store::v1::ObjectChange* const change = record.mutable_write()->add_objects();
  change->set_name("a");
  cwm::store::v1::Object* const object = change->mutable_after();
  object->set_name("a");
  for (const double number : {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}) {
    object->mutable_x_wo()->add_matrix(number);
  }
  object->set_create_revision(1);
  object->set_geometry_revision(1);
  object->set_pose_revision(1);
  cwm::store::v1::ShapePart* const part = object->mutable_model()->add_shapes();
  *part->mutable_x_os() = object->x_wo();
  part->mutable_shape()->set_sphere_radius_m(0.1);
  return record;
}

void CheckReplay(const MemoryDisk& disk) {
  cwm::server::MemoryStore store(std::make_shared<MemoryDisk>(disk));
  const auto replayed = cwm::server::Replay(store, {.threads = 1});
  const bool is_told = cwm::server::DetailsOf(replayed.status()).reason == "STORE_DAMAGED";
  cwm::fuzz::Check(replayed.ok() || is_told, "records are read, or are damaged");
}

}  // namespace

// Restores a world from a record that creates it and one of the bytes; and from a snapshot of the
// bytes.
void cwm::fuzz::TestBytes(std::string_view bytes) {
  static const google::protobuf::LogSilencer silencer;  // of names that are not UTF-8
  store::v1::Record record;
  if (record.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    record.set_world_uid("uid");
    CheckReplay(DiskOf({FirstRecord(), record}));
  }
  store::v1::WorldSnapshot snapshot;
  if (!snapshot.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return;
  MemoryDisk disk;
  disk.last_sequence = 1;
  disk.snapshots[snapshot.world_uid()] = {.sequence = 1,
                                          .world_uid = snapshot.world_uid(),
                                          .revision = snapshot.revision(),
                                          .payload = std::string(bytes),
                                          .blobs = {}};
  CheckReplay(disk);
}
