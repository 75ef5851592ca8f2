// Damaged records and snapshots: told with their place, and never a crash. The engines' checksums
// find damage before; these are the last line.
#include <gmock/gmock.h>
#include <google/protobuf/stubs/logging.h>
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "server/core/error.h"
#include "server/store/compaction.h"
#include "tests/server/core/test_objects.h"
#include "tests/server/store/recorded_world.h"
#include "tests/server/store/story.h"

namespace cwm::server {
namespace {

using ::testing::HasSubstr;

// The records of a story, and the blobs that they need.
MemoryDisk DiskOfStory(unsigned seed, int writes) {
  auto disk = std::make_shared<MemoryDisk>();
  MemoryStore store(disk);
  RecordingJournal journal(store);
  const auto world = MakeRecordedWorld("w", "uid", journal);
  Story story(journal, seed);
  for (int i = 0; i < writes; ++i) story.WriteTo(*world);
  return *disk;
}

absl::Status ReplayStatus(const MemoryDisk& disk, const Retention& retention = {}) {
  MemoryStore store(std::make_shared<MemoryDisk>(disk));
  return Replay(store, {.retention = retention, .threads = 1}).status();
}

void Mutate(std::string& bytes, std::mt19937& random) {
  const auto at = [&] {
    return std::uniform_int_distribution<std::size_t>(0, bytes.size() - 1)(random);
  };
  switch (random() % 4) {
    case 0:
      bytes[at()] = static_cast<char>(random());
      break;
    case 1:
      bytes[at()] ^= static_cast<char>(1 << (random() % 8));
      break;
    case 2:
      bytes.erase(at(), 1 + random() % 8);
      break;
    default:
      bytes.insert(at(), 1 + random() % 8, static_cast<char>(random()));
  }
}

TEST(DamagedRecords, MutatedBytesAreReadOrRefusedButNeverCrash) {
  const MemoryDisk sound = DiskOfStory(2, 60);
  ASSERT_TRUE(ReplayStatus(sound).ok());
  const google::protobuf::LogSilencer silencer;  // of names that are no longer UTF-8
  std::mt19937 random(1);
  int told = 0;
  for (int i = 0; i < 3'000; ++i) {
    MemoryDisk disk = sound;
    auto record = std::next(disk.records.begin(), random() % disk.records.size());
    for (auto count = 1 + random() % 3; count > 0; --count) Mutate(record->second.payload, random);
    const absl::Status status = ReplayStatus(disk);
    if (status.ok()) continue;  // a number that may be another one, an unknown field
    ++told;
    ASSERT_EQ(DetailsOf(status).reason, "STORE_DAMAGED") << status;
  }
  EXPECT_GT(told, 1'500);
}

TEST(DamagedRecords, MutatedSnapshotsAndBlobsAreReadOrRefusedButNeverCrash) {
  MemoryDisk sound = DiskOfStory(4, 80);
  {
    auto shared = std::make_shared<MemoryDisk>(sound);
    MemoryStore store(shared);
    Compaction compaction("uid", store.last_sequence(), {});
    while (!compaction.done()) ASSERT_TRUE(compaction.Step(store).ok());
    sound = *shared;
  }
  ASSERT_TRUE(ReplayStatus(sound).ok());
  ASSERT_FALSE(sound.blobs.empty());
  const google::protobuf::LogSilencer silencer;
  std::mt19937 random(2);
  int told = 0;
  for (int i = 0; i < 2'000; ++i) {
    MemoryDisk disk = sound;
    auto& payload = disk.snapshots.begin()->second.payload;
    auto blob = std::next(disk.blobs.begin(), random() % disk.blobs.size());
    std::string& bytes = i % 4 == 0 ? blob->second : payload;
    for (auto count = 1 + random() % 3; count > 0 && !bytes.empty(); --count) {
      Mutate(bytes, random);
    }
    const absl::Status status = ReplayStatus(disk);
    if (status.ok()) continue;
    ++told;
    ASSERT_EQ(DetailsOf(status).reason, "STORE_DAMAGED") << status;
  }
  EXPECT_GT(told, 1'000);
}

using Edit = std::function<void(store::v1::Record& record)>;

// The error of a log of two records (a put of "a", a move of it) whose second is edited.
std::string FaultOf(const Edit& edit) {
  auto disk = std::make_shared<MemoryDisk>();
  MemoryStore store(disk);
  RecordingJournal journal(store);
  const auto world = MakeRecordedWorld("w", "uid", journal);
  const std::vector<collision::Change> put = {Put("a")}, move = {Move("a", 1)};
  EXPECT_TRUE(world->Apply(put, {}).ok());
  EXPECT_TRUE(world->Apply(move, {}).ok());
  StoredRecord& stored = disk->records.at(2);
  store::v1::Record record;
  EXPECT_TRUE(record.ParseFromString(stored.payload));
  edit(record);
  stored.payload = record.SerializeAsString();
  stored.revision = record.revision();
  const absl::Status status = ReplayStatus(*disk);
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss) << status;
  EXPECT_EQ(DetailsOf(status).reason, "STORE_DAMAGED");
  return std::string(status.message());
}

store::v1::Object& After(store::v1::Record& record) {
  return *record.mutable_write()->mutable_objects(0)->mutable_after();
}

TEST(DamagedRecords, TheErrorNamesThePlaceAndTheRule) {
  struct Case {
    Edit edit;
    std::string fault;
  };
  const std::vector<Case> cases = {
      {[](auto& r) { r.set_revision(4); }, "record 2 of world uid: revision: is 4, must be 2"},
      {[](auto& r) { r.set_revision(1 + kRevisionsLostAtMost); }, "revision: is 65537, must be 2"},
      {[](auto& r) { r.set_created_name("w"); }, "created_name: came twice"},
      {[](auto& r) { r.clear_write(); }, "write: must be given"},
      {[](auto& r) { r.mutable_deletion(); }, "write: must be given, or deletion"},
      {[](auto& r) {
         r.mutable_write()->mutable_objects(0)->set_name("b");
         After(r).set_name("b");
       },
       "write.objects.after.model: of 'b' is absent: it is new"},
      {[](auto& r) {
         r.mutable_write()->mutable_objects(0)->set_name("b");
         r.mutable_write()->mutable_objects(0)->clear_after();
       },
       "write.objects.name: 'b' does not exist"},
      {[](auto& r) { After(r).set_name("b"); }, "write.objects.after.name: must be the name"},
      {[](auto& r) { After(r).set_kind(6); }, "object 'a': kind: is 6, must be from 0 to 5"},
      {[](auto& r) { After(r).set_owner(-1); }, "object 'a': owner: is -1, must be from 0 to 1"},
      {[](auto& r) { After(r).set_state(3); }, "object 'a': state: is 3, must be from 0 to 2"},
      {[](auto& r) { After(r).set_margin_m(-1); }, "object 'a': margin_m: must be finite"},
      {[](auto& r) { After(r).set_pose_revision(0); }, "object 'a': revisions: must be positive"},
      {[](auto& r) { After(r).mutable_x_wo()->set_matrix(0, 0.5); },
       "object 'a': x_wo.matrix: must be a rotation"},
      {[](auto& r) { After(r).mutable_x_wo()->add_matrix(0); },
       "object 'a': x_wo.matrix: has 13 numbers, must have 12"},
      {[](auto& r) {
         auto& box = *After(r).mutable_model()->add_shapes();
         *box.mutable_x_os() = EncodePose(Pose::Identity());
         for (double size : {1.0, -1.0, 1.0}) box.mutable_shape()->mutable_box()->add_values(size);
       },
       "world 'w' (uid): object 'a': shapes[0].shape.size_y_m: is -1, must be positive"},
      {[](auto& r) {
         auto& part = *After(r).mutable_model()->add_shapes();
         *part.mutable_x_os() = EncodePose(Pose::Identity());
         part.mutable_shape()->mutable_mesh()->set_mesh_f64("12345678");
       },
       "shapes[0].shape.mesh_f64: has 8 bytes"},
      {[](auto& r) {
         auto& rule = *r.mutable_write()->add_rules();
         rule.mutable_a()->set_name("b");
         rule.mutable_b()->set_name("a");
         rule.set_allowed(true);
       },
       "rules.pair: must be in order"},
      {[](auto& r) { r.mutable_write()->mutable_sensor_pose()->set_sensor("s"); },
       "sensor_poses.x_wc.matrix: has 0 numbers"},
      {[](auto& r) {
         auto& robot = *r.mutable_write()->add_robots();
         robot.set_name("arm");
         robot.mutable_after()->set_name("arm");
       },
       "write.robots.after.files: of 'arm' are absent"},
      {[](auto& r) {
         auto& robot = *r.mutable_write()->add_robots();
         robot.set_name("a");
         robot.mutable_after()->set_name("a");
         robot.mutable_after()->mutable_files()->set_sha256("00");
       },
       "'a', the name of a robot"}};
  for (const Case& each : cases) EXPECT_THAT(FaultOf(each.edit), HasSubstr(each.fault));
}

TEST(DamagedRecords, ARecordOfAnotherPlaceIsTold) {
  MemoryDisk disk = DiskOfStory(5, 20);
  std::swap(disk.records.at(3).payload, disk.records.at(4).payload);
  const absl::Status status = ReplayStatus(disk);
  EXPECT_EQ(DetailsOf(status).reason, "STORE_DAMAGED");
  EXPECT_THAT(std::string(status.message()), HasSubstr("record 3 of world uid"));
}

}  // namespace
}  // namespace cwm::server
