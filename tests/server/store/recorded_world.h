// A world whose journal is a store in memory, and what a restart makes of it.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "collision/world/model_equality.h"
#include "server/core/world.h"
#include "server/store/encode_entry.h"
#include "server/store/keep_blobs.h"
#include "server/store/memory_store.h"
#include "server/store/replay.h"
#include "server/wire/objects.h"
#include "server/wire/pair_rules.h"
#include "server/wire/robots.h"
#include "server/wire/watch_events.h"
#include "tests/collision/world/test_arm.h"

namespace cwm::server {

// Appends each entry at once.
class RecordingJournal final : public Journal {
 public:
  explicit RecordingJournal(Store& store) : store_(store) {}

  void Append(const JournalEntry& entry, Done done) override {
    absl::StatusOr<EncodedEntry> encoded = EncodeEntry(entry, store_);
    ASSERT_TRUE(encoded.ok()) << encoded.status();
    const StoredRecord record{.sequence = store_.last_sequence() + 1,
                              .epoch = store_.epoch(),
                              .world_uid = entry.world_uid,
                              .revision = entry.revision.value,
                              .payload = std::move(encoded->payload),
                              .blobs = std::move(encoded->blobs)};
    const auto appended = store_.Append({&record, 1}, entry.durability);
    ASSERT_TRUE(appended.ok()) << appended.status();
    done(absl::OkStatus());
  }
  absl::Status KeepGeometry(std::span<const PreparedModelPtr> models,
                            Durability durability) override {
    return server::KeepGeometry(store_, models, durability);
  }
  absl::StatusOr<std::string> KeepRobotFiles(const RobotFiles& files) override {
    return server::KeepRobotFiles(store_, files);
  }

 private:
  Store& store_;
};

// Keeps the newest snapshots, however fast they are made, so that a world that lives and one that
// is restored keep the same ones.
inline Retention KeepOnlyTheLast(std::int64_t count) {
  return {.exact_snapshots = count, .recent_time = std::chrono::hours(1), .recent_snapshots = 0};
}

// The arm of test_arm.h as it is read from files that the store keeps.
inline std::shared_ptr<const collision::RobotGeometry> KeptArm(Journal& journal,
                                                               const std::string& radius = "0.1") {
  RobotFiles files{.urdf = collision::testing::ArmUrdf("arm", radius),
                   .srdf = collision::testing::ArmSrdf()};
  files.spheres = collision::testing::Robot(collision::testing::Ball("base"));
  files.meshes["package://unused/file.bin"] = std::string("\0\xff\n", 3);
  files.settings.padding_m = {{.link = "tip", .value = 0.01}};
  files.settings.scale = {{.link = "tip", .value = 1.5}};
  files.settings.tools = {
      {.name = "finger", .link = "tip", .X_LT = MakeTranslation(0, 0, 0.1), .group = "reach"}};
  const absl::StatusOr<std::string> hash = journal.KeepRobotFiles(files);
  EXPECT_TRUE(hash.ok()) << hash.status();
  files.files_hash = *hash;
  auto robot = ReadRobot(std::move(files), {}, {});
  EXPECT_TRUE(robot.ok()) << robot.status();
  return *std::move(robot);
}

inline std::shared_ptr<World> MakeRecordedWorld(const std::string& name, const std::string& uid,
                                                Journal& journal, const Retention& retention = {}) {
  return std::make_shared<World>(name, uid, retention, Clock::now,
                                 WorldServices{.journal = &journal});
}
inline std::shared_ptr<World> Restore(WorldImage image, Journal& journal,
                                      const Retention& retention = {}) {
  return std::make_shared<World>(std::move(image), retention, Clock::now,
                                 WorldServices{.journal = &journal});
}

// All that clients are told of a snapshot, as bytes.
inline std::vector<std::string> AnswersOf(const collision::WorldSnapshot& snapshot,
                                          const World& world) {
  GeometryStore store(1 << 30);
  std::vector<std::string> answers = {std::to_string(snapshot.revision().value)};
  for (const auto& object : snapshot.objects()) {
    const Observation observation = world.observations().Get(object->name);
    answers.push_back(ObjectToProto(*object, View::kFull, observation, store).SerializeAsString());
    BlobHashes blobs;  // what clients are not told, bit by bit
    answers.push_back(EncodeModel(object->model(), blobs).SerializeAsString());
    answers.push_back(EncodePose(object->X_WO).SerializeAsString());
  }
  for (const auto& robot : snapshot.robots()) {
    v1::GetRobotLinksResponse links;
    SetLinks(*robot, LinkShapes::kAll, store, &links);
    answers.push_back(RobotToProto(*robot).SerializeAsString());
    answers.push_back(links.SerializeAsString());
    answers.push_back(EncodePose(robot->X_WB).SerializeAsString());
  }
  for (const auto& rule : snapshot.pair_rules()) {
    answers.push_back(PairRuleToProto(rule).SerializeAsString());
  }
  return answers;
}

// The events of a watch from the revision, as bytes; the error that ends it.
inline std::vector<std::string> WatchFrom(World& world, collision::Revision from) {
  GeometryStore store(1 << 30);
  std::vector<std::string> events;
  const auto watch = world.Watch({.from_revision = from}, [] {});
  if (!watch.ok()) return {std::string(watch.status().message())};
  while (true) {
    const auto step = (*watch)->Next();
    if (!step.ok()) return {std::string(step.status().message())};
    if (!step->has_value()) return events;
    std::size_t next = 0;
    const v1::WatchWorldResponse event =
        EventsPiece(**step, {.world = world, .view = View::kFull, .store = store}, &next);
    events.push_back(event.SerializeAsString());
  }
}

// Expects that no client can tell the worlds apart, from the newest revision to the oldest that is
// kept.
inline void ExpectSameWorld(World& live, World& restored) {
  EXPECT_EQ(live.name(), restored.name());
  EXPECT_EQ(live.uid(), restored.uid());
  const collision::Revision latest = live.Snapshot()->revision();
  ASSERT_EQ(restored.Snapshot()->revision(), latest);
  EXPECT_EQ(live.oldest_exact(), restored.oldest_exact());
  EXPECT_EQ(live.oldest_watch(), restored.oldest_watch());
  for (collision::Revision r = live.oldest_exact(); r <= latest; ++r.value) {
    const auto expected = live.At(Exactly{r}, Clock::now(), {});
    const auto actual = restored.At(Exactly{r}, Clock::now(), {});
    ASSERT_EQ(expected.ok(), actual.ok()) << "at " << r.value << ": " << actual.status();
    if (!expected.ok()) continue;  // a power cut took it
    ASSERT_EQ(AnswersOf(**expected, live), AnswersOf(**actual, restored)) << "at " << r.value;
    EXPECT_EQ((*expected)->weight(), (*actual)->weight());
    EXPECT_EQ((*expected)->attached().size(), (*actual)->attached().size());
    EXPECT_EQ((*expected)->with_hidden().size(), (*actual)->with_hidden().size());
    EXPECT_EQ((*expected)->has_caps(), (*actual)->has_caps());
    EXPECT_EQ((*expected)->max_margin_m(), (*actual)->max_margin_m());
    for (const auto& robot : (*expected)->robots()) {
      const auto other = (*actual)->FindRobot(robot->name);
      EXPECT_TRUE(collision::SameRobot(*robot->robot, *other->robot));
      EXPECT_EQ(robot->robot->files_hash, other->robot->files_hash);
    }
  }
  const std::vector<std::string> events = WatchFrom(live, live.oldest_watch());
  EXPECT_EQ(events.empty(), latest == live.oldest_watch());
  EXPECT_EQ(WatchFrom(restored, live.oldest_watch()), events);
}

}  // namespace cwm::server
