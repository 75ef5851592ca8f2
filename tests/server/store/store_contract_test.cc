// The contract of store.h, for every engine: SQLite, memory, and a store whose replies get lost and
// which other servers append to. The file is long because the suite is one: each engine runs all of
// it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <set>

#include "server/store/memory_store.h"
#include "server/store/sqlite/sqlite_store.h"
#include "tests/server/store/store_stories.h"
#include "tests/server/store/store_wrapper.h"

namespace cwm::server {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// Opens one and the same store again and again.
class TestedEngine {
 public:
  virtual ~TestedEngine() = default;
  virtual std::unique_ptr<Store> Open() = 0;
};

class TestedSqlite final : public TestedEngine {
 public:
  std::unique_ptr<Store> Open() override {
    SqliteOptions options;
    options.path = directory_ / "store";
    options.ballast_bytes = 0;
    options.blob_grace = std::chrono::seconds(0);
    absl::StatusOr<std::unique_ptr<Store>> store = OpenSqliteStore(options);
    EXPECT_TRUE(store.ok()) << store.status();
    return store.ok() ? *std::move(store) : nullptr;
  }

 private:
  TemporaryDirectory directory_ = TemporaryDirectory(FastFolder());
};

class TestedMemory final : public TestedEngine {
 public:
  std::unique_ptr<Store> Open() override { return std::make_unique<MemoryStore>(disk_); }

 private:
  std::shared_ptr<MemoryDisk> disk_ = std::make_shared<MemoryDisk>();
};

struct OwnedMemory {
  MemoryStore memory;
};

// A store on which another server appends first now and then, and whose replies get lost: with what
// was asked for done, or not.
class UnreliableStore final : private OwnedMemory, public StoreWrapper {
 public:
  UnreliableStore(std::shared_ptr<MemoryDisk> disk, std::uint32_t seed)
      : OwnedMemory{MemoryStore(std::move(disk))}, StoreWrapper(memory), random_(seed) {}

  absl::StatusOr<AppendResult> Append(std::span<const StoredRecord> records,
                                      Durability durability) override {
    switch (random_() % 4) {
      case 0:
        return StoreWrapper::Append(records, durability);
      case 1: {
        std::vector<StoredRecord> stranger = NextRecords(memory, "of-another-server", 1, 1);
        (void)StoreWrapper::Append(stranger, durability);
        return StoreWrapper::Append(records, durability);
      }
      case 2: {
        absl::StatusOr<AppendResult> result = StoreWrapper::Append(records, durability);
        if (result.ok() && *result == AppendResult::kDurable) return AppendResult::kUnknown;
        return result;
      }
      default:
        return AppendResult::kUnknown;
    }
  }

 private:
  std::mt19937 random_;
};

class TestedUnreliable final : public TestedEngine {
 public:
  std::unique_ptr<Store> Open() override {
    return std::make_unique<UnreliableStore>(disk_, ++seed_);
  }

 private:
  std::shared_ptr<MemoryDisk> disk_ = std::make_shared<MemoryDisk>();
  std::uint32_t seed_ = 0;
};

struct EngineCase {
  std::string name;
  std::function<std::unique_ptr<TestedEngine>()> make;
};

void PrintTo(const EngineCase& engine, std::ostream* out) { *out << engine.name; }

class StoreContract : public testing::TestWithParam<EngineCase> {
 protected:
  void SetUp() override {
    engine_ = GetParam().make();
    store_ = engine_->Open();
    ASSERT_NE(store_, nullptr);
  }

  // Ends the use of the store and opens it again.
  void Reopen(bool close = false) {
    if (close) {
      ASSERT_TRUE(store_->Close().ok());
    }
    store_.reset();
    store_ = engine_->Open();
    ASSERT_NE(store_, nullptr);
  }

  // Appends the records as a journal does: what was superseded is appended behind what came first,
  // and what is unknown is looked up. Returns them as they are in the store.
  std::vector<StoredRecord> Write(std::vector<StoredRecord> records,
                                  Durability durability = Durability::kDurable) {
    for (int attempt = 0; attempt < 1000; ++attempt) {
      const std::int64_t before = store_->last_sequence();
      std::int64_t sequence = before;
      for (StoredRecord& record : records) record.sequence = ++sequence;
      const absl::StatusOr<AppendResult> result = store_->Append(records, durability);
      EXPECT_TRUE(result.ok()) << result.status();
      if (!result.ok() || *result == AppendResult::kDurable) return records;
      if (*result != AppendResult::kUnknown) continue;
      const auto found = store_->Follow(records.front().world_uid, before, kWithoutLimit);
      EXPECT_TRUE(found.ok()) << found.status();
      if (found.ok() && *found == records) return records;
      EXPECT_THAT(*found, IsEmpty()) << "a part was appended";
    }
    ADD_FAILURE() << "nothing was appended in 1,000 attempts";
    return {};
  }
  std::vector<StoredRecord> WriteNext(const std::string& world, std::int64_t revision, int count,
                                      std::size_t payload_size = 300) {
    return Write(NextRecords(*store_, world, revision, count, payload_size));
  }

  std::vector<StoredRecord> FollowAll(const std::string& world, std::int64_t after = 0) {
    const auto records = store_->Follow(world, after, kWithoutLimit);
    EXPECT_TRUE(records.ok()) << records.status();
    return records.ok() ? *records : std::vector<StoredRecord>();
  }

  std::string Put(const std::string& bytes) {
    const std::string hash = Sha256Hex(bytes);
    const absl::Status status = store_->PutBlob(hash, bytes, Durability::kDurable);
    EXPECT_TRUE(status.ok()) << status;
    return hash;
  }

  std::unique_ptr<TestedEngine> engine_;
  std::unique_ptr<Store> store_;
};

TEST_P(StoreContract, FindsTheSnapshotOfOneWorldAndDurableBlobs) {
  WriteNext("kitchen", 1, 3);
  WriteNext("cellar", 1, 2);
  EXPECT_EQ(*store_->SnapshotOf("kitchen"), std::nullopt);
  const StoredSnapshot snapshot = {
      .sequence = 2, .world_uid = "kitchen", .revision = 2, .payload = "folded"};
  ASSERT_TRUE(store_->PutSnapshot(snapshot).ok());
  EXPECT_FALSE(store_->HasDurableBlob(Sha256Hex("x")));
  const std::string hash = Put("x");
  EXPECT_TRUE(store_->HasDurableBlob(hash));
  for (int i = 0; i < 2; ++i) {
    const absl::StatusOr<std::optional<StoredSnapshot>> found = store_->SnapshotOf("kitchen");
    ASSERT_TRUE(found.ok() && found->has_value()) << found.status();
    EXPECT_EQ(**found, snapshot);
    EXPECT_EQ(*store_->SnapshotOf("cellar"), std::nullopt);
    EXPECT_EQ(*store_->SnapshotOf("attic"), std::nullopt);
    Reopen();
  }
  ASSERT_TRUE(store_->DropWorld("kitchen", store_->last_sequence()).ok());
  EXPECT_EQ(*store_->SnapshotOf("kitchen"), std::nullopt);
}

TEST_P(StoreContract, ReturnsRecordsInOrderAsTheyWereAppended) {
  std::vector<StoredRecord> written = WriteNext("kitchen", 1, 3);
  for (const StoredRecord& record : WriteNext("kitchen", 4, 5)) written.push_back(record);
  EXPECT_EQ(FollowAll("kitchen"), written);
  Reopen();
  EXPECT_EQ(FollowAll("kitchen"), written);
  EXPECT_GE(store_->last_sequence(), written.back().sequence);
}

TEST_P(StoreContract, NumbersAllWorldsTogetherWithoutHoles) {
  for (int i = 0; i < 20; ++i) WriteNext(i % 3 == 0 ? "kitchen" : "shelf", i + 1, 1 + i % 4);
  std::int64_t expected = 0;
  for (const StoredRecord& record : FollowAll("")) EXPECT_EQ(record.sequence, ++expected);
  EXPECT_EQ(expected, store_->last_sequence());
}

TEST_P(StoreContract, KeepsAnyBytesAndAnyNumbers) {
  std::vector<StoredRecord> records = NextRecords(*store_, "kitchen", 1, 4);
  records[0].payload = "";
  records[1].payload = std::string("\0a\xFF\0", 4);
  records[2].payload = RandomBytes(3'000'000, 1);
  records[2].revision = std::int64_t{1} << 60;
  records[3].blobs = {Sha256Hex("a"), Sha256Hex("b")};
  records = Write(records);
  Reopen();
  EXPECT_EQ(FollowAll("kitchen"), records);
}

TEST_P(StoreContract, AppendsNoneOfRecordsThatLeaveAHole) {
  WriteNext("kitchen", 1, 2);
  const std::int64_t last = store_->last_sequence();
  std::vector<StoredRecord> late = NextRecords(*store_, "kitchen", 3, 2);
  for (StoredRecord& record : late) record.sequence += 10;
  std::vector<StoredRecord> holed = NextRecords(*store_, "kitchen", 3, 3);
  holed[2].sequence += 1;
  if (GetParam().name == "Unreliable") return;  // may not even look at them
  for (const auto& records : {late, holed}) {
    EXPECT_EQ(ReasonOf(store_->Append(records, Durability::kDurable).status()), "STORE_MISUSED");
  }
  EXPECT_EQ(store_->last_sequence(), last);
  EXPECT_EQ(FollowAll("").size(), 2u);
}

TEST_P(StoreContract, AppendsNoneOfRecordsThatWereSuperseded) {
  WriteNext("kitchen", 1, 5);
  std::vector<StoredRecord> late = NextRecords(*store_, "kitchen", 4, 3);
  for (StoredRecord& record : late) record.sequence -= 2;
  const std::vector<StoredRecord> before = FollowAll("kitchen");
  const absl::StatusOr<AppendResult> result = store_->Append(late, Durability::kDurable);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_NE(*result, AppendResult::kDurable);
  EXPECT_EQ(FollowAll("kitchen"), before);
}

TEST_P(StoreContract, FollowsOneWorldOrAllFromASequenceOn) {
  const std::vector<StoredRecord> a = WriteNext("kitchen", 1, 3);
  const std::vector<StoredRecord> b = WriteNext("shelf", 1, 3);
  const std::vector<StoredRecord> c = WriteNext("kitchen", 4, 1);
  EXPECT_THAT(FollowAll("kitchen", a[1].sequence), ElementsAre(a[2], c[0]));
  EXPECT_THAT(FollowAll("shelf", b[2].sequence), IsEmpty());
  EXPECT_THAT(FollowAll("unknown"), IsEmpty());
  std::vector<StoredRecord> all;
  for (const StoredRecord& record : FollowAll("", a[2].sequence)) {
    if (record.world_uid != "of-another-server") all.push_back(record);
  }
  EXPECT_THAT(all, ElementsAre(b[0], b[1], b[2], c[0]));
}

TEST_P(StoreContract, FollowsInStepsOfAsManyBytesAsAskedForAndOneRecordAtLeast) {
  const std::vector<StoredRecord> written = WriteNext("kitchen", 1, 7, 100);
  for (const auto& [max_bytes, count] : {std::pair{0, 1u}, {100, 1u}, {299, 2u}, {300, 3u}}) {
    for (const char* world : {"kitchen", ""}) {
      const auto step = store_->Follow(world, written[0].sequence - 1, max_bytes);
      ASSERT_TRUE(step.ok());
      EXPECT_EQ(step->size(), count) << world << ", " << max_bytes;
    }
  }
  std::vector<StoredRecord> stepped;
  for (std::int64_t after = 0;;) {
    const auto step = store_->Follow("kitchen", after, 250);
    ASSERT_TRUE(step.ok());
    if (step->empty()) break;
    stepped.insert(stepped.end(), step->begin(), step->end());
    after = stepped.back().sequence;
  }
  EXPECT_EQ(stepped, written);
}

TEST_P(StoreContract, ReplacesTheRecordsOfAWorldBySnapshots) {
  const std::vector<StoredRecord> kitchen = WriteNext("kitchen", 1, 6);
  const std::vector<StoredRecord> shelf = WriteNext("shelf", 1, 3);
  StoredSnapshot snapshot = {.sequence = kitchen[3].sequence,
                             .world_uid = "kitchen",
                             .revision = 4,
                             .payload = RandomBytes(100'000, 5)};
  ASSERT_TRUE(store_->PutSnapshot(snapshot).ok());
  for (int i = 0; i < 2; ++i) {
    EXPECT_THAT(FollowAll("kitchen"), ElementsAre(kitchen[4], kitchen[5]));
    EXPECT_EQ(FollowAll("shelf"), shelf);
    EXPECT_THAT(*store_->Snapshots(), ElementsAre(snapshot));
    Reopen();
  }
  const std::vector<StoredRecord> more = WriteNext("kitchen", 7, 2);
  EXPECT_THAT(FollowAll("kitchen"), ElementsAre(kitchen[4], kitchen[5], more[0], more[1]));
  snapshot.sequence = more[0].sequence;
  snapshot.revision = 7;
  snapshot.payload = "the newer one";
  ASSERT_TRUE(store_->PutSnapshot(snapshot).ok());
  ASSERT_TRUE(store_->Maintain().ok());
  Reopen();
  EXPECT_THAT(FollowAll("kitchen"), ElementsAre(more[1]));
  EXPECT_THAT(*store_->Snapshots(), ElementsAre(snapshot));
}

TEST_P(StoreContract, RefusesSnapshotsThatGoBackOrAhead) {
  const std::vector<StoredRecord> written = WriteNext("kitchen", 1, 4);
  StoredSnapshot snapshot = {
      .sequence = written[2].sequence, .world_uid = "kitchen", .revision = 3, .payload = "x"};
  ASSERT_TRUE(store_->PutSnapshot(snapshot).ok());
  StoredSnapshot older = snapshot;
  older.sequence = written[1].sequence;
  StoredSnapshot newer = snapshot;
  newer.sequence = store_->last_sequence() + 1;
  for (const StoredSnapshot& bad : {older, newer}) {
    EXPECT_EQ(ReasonOf(store_->PutSnapshot(bad)), "STORE_MISUSED");
  }
  EXPECT_THAT(*store_->Snapshots(), ElementsAre(snapshot));
}

TEST_P(StoreContract, DropsAWorldAndGoesOnCounting) {
  const std::vector<StoredRecord> kitchen = WriteNext("kitchen", 1, 5);
  ASSERT_TRUE(store_
                  ->PutSnapshot({.sequence = kitchen[1].sequence,
                                 .world_uid = "kitchen",
                                 .revision = 2,
                                 .payload = "x"})
                  .ok());
  const std::int64_t last = store_->last_sequence();
  ASSERT_TRUE(store_->DropWorld("kitchen", last).ok());
  ASSERT_TRUE(store_->DropWorld("unknown", last).ok());
  for (int i = 0; i < 3; ++i) {
    EXPECT_THAT(FollowAll("kitchen"), IsEmpty());
    EXPECT_THAT(*store_->Snapshots(), IsEmpty());
    EXPECT_EQ(store_->last_sequence(), last);
    ASSERT_TRUE(store_->Maintain().ok());
    Reopen(i == 1);
  }
  const std::vector<StoredRecord> shelf = WriteNext("shelf", 1, 1);
  Reopen();
  EXPECT_EQ(FollowAll("shelf"), shelf);
}

TEST_P(StoreContract, KeepsTheRecordsOfADroppedWorldThatCameLater) {
  const std::vector<StoredRecord> kitchen = WriteNext("kitchen", 1, 5);
  ASSERT_TRUE(store_->DropWorld("kitchen", kitchen[2].sequence).ok());
  for (int i = 0; i < 3; ++i) {
    EXPECT_THAT(FollowAll("kitchen"), ElementsAre(kitchen[3], kitchen[4]));
    ASSERT_TRUE(store_->Maintain().ok());
    Reopen();
  }
}

TEST_P(StoreContract, KeepsBlobsByHash) {
  const std::string large = RandomBytes(2'000'000, 9);
  const std::string empty_hash = Put("");
  const std::string large_hash = Put(large);
  EXPECT_EQ(Put(large), large_hash);
  Write([&] {
    std::vector<StoredRecord> records = NextRecords(*store_, "kitchen", 1, 1);
    records[0].blobs = {empty_hash, large_hash};
    return records;
  }());
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(*store_->GetBlob(empty_hash), "");
    EXPECT_EQ(*store_->GetBlob(large_hash), large);
    EXPECT_EQ(store_->stats().blob_count, 2);
    Reopen();
  }
  EXPECT_EQ(ReasonOf(store_->GetBlob(Sha256Hex("never put")).status()), "BLOB_MISSING");
}

TEST_P(StoreContract, TakesAnObservedBlobThatIsPutDurablyLater) {
  const std::string bytes = RandomBytes(10'000, 3);
  const std::string hash = Sha256Hex(bytes);
  ASSERT_TRUE(store_->PutBlob(hash, bytes, Durability::kObserved).ok());
  EXPECT_EQ(*store_->GetBlob(hash), bytes);
  Reopen();
  ASSERT_TRUE(store_->PutBlob(hash, bytes, Durability::kDurable).ok());
  ASSERT_TRUE(store_->PutBlob(hash, bytes, Durability::kObserved).ok());
  EXPECT_EQ(*store_->GetBlob(hash), bytes);
  EXPECT_EQ(store_->stats().blob_count, 1);
}

TEST_P(StoreContract, RefusesNamesOfBlobsThatAreNoHashes) {
  for (const char* name : {"", "abc", "../../../../etc/passwd",
                           "E3B0C44298FC1C149AFBF4C8996FB92427AE41E4649B934CA495991B7852B855"}) {
    EXPECT_EQ(ReasonOf(store_->PutBlob(name, "x", Durability::kDurable)), "STORE_MISUSED");
  }
}

TEST_P(StoreContract, TellsThatABlobHasNotItsHash) {
  const std::string hash = Sha256Hex("right");
  ASSERT_TRUE(store_->PutBlob(hash, "wrong", Durability::kDurable).ok());
  EXPECT_EQ(ReasonOf(store_->GetBlob(hash).status()), "STORE_DAMAGED");
}

TEST_P(StoreContract, NeverDropsABlobThatARecordOrASnapshotNames) {
  const std::string of_record = Put("of a record");
  const std::string of_snapshot = Put("of a snapshot");
  std::vector<StoredRecord> records = NextRecords(*store_, "kitchen", 1, 2);
  records[0].blobs = {of_record, of_snapshot};
  records = Write(records);
  const auto expect_both = [&] {
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(store_->Maintain().ok());
    EXPECT_TRUE(store_->GetBlob(of_record).ok());
    EXPECT_TRUE(store_->GetBlob(of_snapshot).ok());
  };
  expect_both();
  Reopen();
  expect_both();
  ASSERT_TRUE(store_
                  ->PutSnapshot({.sequence = records[0].sequence,
                                 .world_uid = "kitchen",
                                 .revision = 1,
                                 .payload = "x",
                                 .blobs = {of_snapshot}})
                  .ok());
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 3; ++j) ASSERT_TRUE(store_->Maintain().ok());
    EXPECT_TRUE(store_->GetBlob(of_snapshot).ok());
    Reopen();
  }
}

TEST_P(StoreContract, BacksUpWhileItIsAppendedTo) {
  const std::string blob = Put(RandomBytes(200'000, 8));
  std::vector<StoredRecord> records = NextRecords(*store_, "kitchen", 1, 50, 20'000);
  records[0].blobs = {blob};
  Write(records);
  absl::StatusOr<std::unique_ptr<Store::BackupRun>> run = store_->StartBackup();
  ASSERT_TRUE(run.ok()) << run.status();
  std::unique_ptr<Backup> backup;
  for (int step = 0; backup == nullptr; ++step) {
    ASSERT_LT(step, 10'000);
    WriteNext("kitchen", 51 + step, 1);
    absl::StatusOr<std::unique_ptr<Backup>> stepped = (*run)->Step();
    ASSERT_TRUE(stepped.ok()) << stepped.status();
    backup = *std::move(stepped);
  }
  EXPECT_GE(backup->sequence(), 50);
  EXPECT_LE(backup->sequence(), store_->last_sequence());
  std::map<std::string, std::string> digests;
  const auto digest_of = [](const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return Sha256Hex(std::string(std::istreambuf_iterator<char>(in), {}));
  };
  for (const BackupFile& file : backup->files()) {
    EXPECT_TRUE(std::filesystem::is_regular_file(file.source)) << file.source;
    digests[file.path] = digest_of(file.source);
  }
  EXPECT_EQ(digests.size(), backup->files().size());
  // The files do not change while the store goes on, not even when it drops all that is in them.
  ASSERT_TRUE(store_->DropWorld("kitchen", store_->last_sequence()).ok());
  WriteNext("shelf", 1, 5);
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(store_->Maintain().ok());
  for (const BackupFile& file : backup->files()) {
    EXPECT_EQ(digest_of(file.source), digests[file.path]) << file.path;
  }
  const std::string source = backup->files().front().source;
  backup.reset();
  EXPECT_FALSE(std::filesystem::exists(source));
}

TEST_P(StoreContract, CountsHowOftenItWasOpened) {
  for (std::int64_t epoch = store_->epoch(), i = 0; i < 4; ++i) {
    Reopen(i % 2 == 0);
    EXPECT_EQ(store_->epoch(), ++epoch);
    EXPECT_FALSE(store_->may_lack_observed());
  }
}

TEST_P(StoreContract, CountsWhatItKeeps) {
  WriteNext("kitchen", 1, 10, 100);
  std::int64_t strangers = 0;
  std::int64_t their_bytes = 0;
  for (const StoredRecord& record : FollowAll("of-another-server")) {
    ++strangers;
    their_bytes += static_cast<std::int64_t>(record.payload.size());
  }
  for (int i = 0; i < 2; ++i) {
    const StoreStats stats = store_->stats();
    EXPECT_EQ(stats.record_count - strangers, 10);
    EXPECT_EQ(stats.record_bytes - their_bytes, 1000);
    EXPECT_GE(stats.bytes, 1000);
    EXPECT_FALSE(stats.location.empty());
    Reopen(true);
  }
}

// What a store must hold, kept as plain values.
struct Expected {
  std::map<std::string, std::vector<StoredRecord>> records;  // by world
  std::map<std::string, StoredSnapshot> snapshots;
};

TEST_P(StoreContract, HoldsWhatAPlainModelHoldsAfterARandomStory) {
  std::mt19937 random(20240611);
  Expected expected;
  const std::vector<std::string> worlds = {"a", "b", "c", "d"};
  for (int step = 0; step < 400; ++step) {
    const std::string& world = worlds[random() % worlds.size()];
    std::vector<StoredRecord>& records = expected.records[world];
    switch (random() % 12) {
      default: {
        const Durability durability =
            random() % 2 == 0 ? Durability::kDurable : Durability::kObserved;
        const std::size_t size = random() % 8 == 0 ? random() % 30'000 : random() % 300;
        const int count = 1 + static_cast<int>(random() % 5);
        for (const StoredRecord& record :
             Write(NextRecords(*store_, world, step, count, size), durability)) {
          records.push_back(record);
        }
        break;
      }
      case 8: {
        if (records.empty()) break;
        const std::size_t folded = random() % records.size() + 1;
        const StoredSnapshot snapshot = {.sequence = records[folded - 1].sequence,
                                         .world_uid = world,
                                         .revision = step,
                                         .payload = RandomBytes(random() % 5000, random())};
        ASSERT_TRUE(store_->PutSnapshot(snapshot).ok());
        records.erase(records.begin(), records.begin() + static_cast<std::ptrdiff_t>(folded));
        expected.snapshots[world] = snapshot;
        break;
      }
      case 9:
        if (random() % 4 != 0) break;
        ASSERT_TRUE(store_->DropWorld(world, store_->last_sequence()).ok());
        records.clear();
        expected.snapshots.erase(world);
        break;
      case 10:
        ASSERT_TRUE(store_->Maintain().ok());
        break;
      case 11:
        Reopen(random() % 2 == 0);
        break;
    }
    if (step % 20 != 0) continue;
    for (const std::string& each : worlds) {
      ASSERT_EQ(FollowAll(each), expected.records[each]) << "step " << step;
    }
    const auto snapshots = store_->Snapshots();
    ASSERT_TRUE(snapshots.ok());
    std::map<std::string, StoredSnapshot> found;
    for (const StoredSnapshot& snapshot : *snapshots) found[snapshot.world_uid] = snapshot;
    ASSERT_EQ(found, expected.snapshots) << "step " << step;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Engines, StoreContract,
    testing::Values(EngineCase{"Sqlite", [] { return std::make_unique<TestedSqlite>(); }},
                    EngineCase{"Memory", [] { return std::make_unique<TestedMemory>(); }},
                    EngineCase{"Unreliable", [] { return std::make_unique<TestedUnreliable>(); }}),
    [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace cwm::server
