#include "server/store/encode_entry.h"

#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/store/decode_fault.h"

namespace cwm::server {
namespace {

using collision::ObjectDelta;
using collision::RobotDelta;
using collision::WorldObject;
using collision::WorldRobot;

// Apply keeps the geometry of an object that is put again with an equal model.
bool HasSameModel(const ObjectDelta& delta) {
  return delta.before != nullptr && delta.before->geometry == delta.after->geometry;
}

void SetObject(const WorldObject& object, store::v1::Object* encoded) {
  encoded->set_name(object.name);
  encoded->set_margin_m(object.margin_m);
  *encoded->mutable_x_wo() = EncodePose(object.X_WO);
  if (const collision::Attachment* const attachment = object.attachment.get()) {
    store::v1::Attachment* const added = encoded->mutable_attachment();
    added->set_robot(attachment->robot);
    added->set_link(attachment->link);
    *added->mutable_x_lo() = EncodePose(attachment->X_LO);
    for (const std::string& link : attachment->touch_links) added->add_touch_links(link);
  }
  encoded->set_supported_by(object.supported_by);
  encoded->set_create_revision(object.create_revision.value);
  encoded->set_geometry_revision(object.geometry_revision.value);
  encoded->set_pose_revision(object.pose_revision.value);
  encoded->set_kind(static_cast<int>(object.kind));
  encoded->set_owner(static_cast<int>(object.owner));
  encoded->set_state(static_cast<int>(object.state));
}

void AddObjectChange(const ObjectDelta& delta, BlobHashes& blobs, store::v1::Write& write) {
  store::v1::ObjectChange* const change = write.add_objects();
  change->set_name((delta.after != nullptr ? delta.after : delta.before)->name);
  if (delta.after == nullptr) return;
  SetObject(*delta.after, change->mutable_after());
  if (HasSameModel(delta)) return;
  *change->mutable_after()->mutable_model() = EncodeModel(delta.after->model(), blobs);
}

absl::Status AddRobotChange(const RobotDelta& delta, const Store& store, BlobHashes& blobs,
                            store::v1::Write& write) {
  store::v1::RobotChange* const change = write.add_robots();
  change->set_name((delta.after != nullptr ? delta.after : delta.before)->name);
  if (delta.after == nullptr) return absl::OkStatus();
  const WorldRobot& robot = *delta.after;
  store::v1::Robot* const encoded = change->mutable_after();
  encoded->set_name(robot.name);
  *encoded->mutable_x_wb() = EncodePose(robot.X_WB);
  encoded->mutable_state()->Assign(robot.state.begin(), robot.state.end());
  encoded->set_create_revision(robot.create_revision.value);
  encoded->set_state_revision(robot.state_revision.value);
  if (delta.before != nullptr && delta.before->robot == robot.robot) return absl::OkStatus();
  const std::string& hash = robot.robot->files_hash;
  if (hash.empty()) {
    return absl::InternalError(absl::StrCat("the files of robot '", robot.name, "' were not kept"));
  }
  encoded->mutable_files()->set_sha256(hash);
  return AddRobotBlobs(hash, store, blobs);
}

absl::Status SetWrite(const WorldWrite& write, const Store& store, BlobHashes& blobs,
                      store::v1::Write& encoded) {
  encoded.set_makes_revision(write.event != nullptr);
  if (write.event != nullptr) {
    for (const ObjectDelta& delta : write.event->deltas) AddObjectChange(delta, blobs, encoded);
    for (const RobotDelta& delta : write.event->robot_deltas) {
      const absl::Status status = AddRobotChange(delta, store, blobs, encoded);
      if (!status.ok()) return status;
    }
    for (const collision::PairRuleDelta& delta : write.event->rule_deltas) {
      *encoded.add_rules() = EncodeRule(delta.after);
    }
  }
  for (const Sighting& sighting : write.facts.sightings) {
    store::v1::Sighting* const added = encoded.add_sightings();
    added->set_name(sighting.name);
    if (sighting.reachable) added->set_reachable(*sighting.reachable);
    added->set_is_new(sighting.is_new);
  }
  if (!write.facts.sightings.empty()) encoded.set_seen_at_ns(NanosecondsOf(write.facts.seen_at));
  if (const auto& named = write.facts.sensor_pose) {
    *encoded.mutable_sensor_pose() = EncodeSensorPose(named->sensor, named->pose);
  }
  if (write.request) {
    store::v1::Request* const request = encoded.mutable_request();
    request->set_id(write.request->id);
    request->set_digest(write.request->digest);
    request->set_is_ingest(write.request->is_ingest);
  }
  for (const auto& [stem, number] : write.last_numbers) {
    store::v1::LastNumber* const added = encoded.add_last_numbers();
    added->set_stem(stem);
    added->set_number(number);
  }
  return absl::OkStatus();
}

void SetThing(const collision::NamedThing& thing, store::v1::NamedThing* encoded) {
  encoded->set_name(thing.name);
  encoded->set_link(thing.link);
}

}  // namespace

std::int64_t NanosecondsOf(collision::WallTime time) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
}

store::v1::PairRule EncodeRule(const collision::PairRule& rule) {
  store::v1::PairRule encoded;
  SetThing(rule.pair.a, encoded.mutable_a());
  SetThing(rule.pair.b, encoded.mutable_b());
  encoded.set_allowed(rule.allowed);
  if (rule.expires) encoded.set_expires_ns(NanosecondsOf(rule.expires->wall_time));
  if (rule.margin_m) encoded.set_margin_m(*rule.margin_m);
  encoded.set_check(rule.check);
  return encoded;
}

store::v1::SensorPose EncodeSensorPose(const std::string& sensor, const SensorPose& pose) {
  store::v1::SensorPose encoded;
  encoded.set_sensor(sensor);
  *encoded.mutable_x_wc() = EncodePose(pose.X_WC);
  encoded.set_given(pose.given);
  return encoded;
}

absl::Status AddRobotBlobs(const std::string& files_hash, const Store& store, BlobHashes& blobs) {
  if (blobs.contains(files_hash)) return absl::OkStatus();
  const absl::StatusOr<std::string> bytes = store.GetBlob(files_hash);
  if (!bytes.ok()) return bytes.status();
  store::v1::RobotFiles files;
  if (!files.ParseFromString(*bytes)) return Damaged("blob " + files_hash, "is no list of files");
  blobs.insert(files_hash);
  blobs.insert(files.urdf().sha256());
  if (files.has_srdf()) blobs.insert(files.srdf().sha256());
  if (files.has_spheres()) blobs.insert(files.spheres().sha256());
  for (const auto& [uri, blob] : files.meshes()) blobs.insert(blob.sha256());
  return absl::OkStatus();
}

absl::StatusOr<EncodedEntry> EncodeEntry(const JournalEntry& entry, const Store& store) {
  store::v1::Record record;
  record.set_world_uid(entry.world_uid);
  record.set_revision(entry.revision.value);
  record.set_when_ns(NanosecondsOf(entry.when));
  record.set_observed(entry.durability == Durability::kObserved);
  if (entry.created_name) record.set_created_name(*entry.created_name);
  BlobHashes blobs;
  if (const auto* const deletion = std::get_if<WorldDeletion>(&entry.what)) {
    record.mutable_deletion()->set_requested_uid(deletion->requested_uid);
    record.mutable_deletion()->set_request_id(deletion->request_id);
  } else {
    const absl::Status status =
        SetWrite(std::get<WorldWrite>(entry.what), store, blobs, *record.mutable_write());
    if (!status.ok()) return status;
  }
  EncodedEntry encoded{.payload = {}, .blobs = {blobs.begin(), blobs.end()}};
  if (!record.SerializeToString(&encoded.payload)) {  // protobuf writes at most 2 GiB
    return absl::ResourceExhaustedError("a write has more than 2 GiB, must have at most so many");
  }
  return encoded;
}

}  // namespace cwm::server
