// Processes that are killed while they write: what was acknowledged is there, and nothing twice.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/wait.h>

#include <csignal>
#include <functional>
#include <random>
#include <thread>

#include "server/core/failpoint.h"
#include "server/store/sqlite/store_directory.h"
#include "tests/server/store/sqlite_directory.h"
#include "tests/server/store/store_stories.h"

namespace cwm::server {
namespace {

using testing::IsEmpty;
namespace fs = std::filesystem;

// Tells the parent, by a pipe, what a child had acknowledged.
class Acknowledgements {
 public:
  Acknowledgements() {
    if (pipe(ends_.data()) != 0) ADD_FAILURE() << "no pipe";
  }
  ~Acknowledgements() {
    close(ends_[0]);
    if (ends_[1] >= 0) close(ends_[1]);
  }
  Acknowledgements(const Acknowledgements&) = delete;
  Acknowledgements& operator=(const Acknowledgements&) = delete;
  void Tell(std::int64_t sequence) const {
    if (write(ends_[1], &sequence, sizeof(sequence)) != sizeof(sequence)) _exit(3);
  }
  // The last one that was told; 0 for none. The child has ended.
  std::int64_t Last() {
    close(ends_[1]);
    ends_[1] = -1;
    std::int64_t last = 0;
    for (std::int64_t sequence = 0; read(ends_[0], &sequence, sizeof(sequence)) > 0;) {
      last = sequence;
    }
    return last;
  }

 private:
  std::array<int, 2> ends_ = {-1, -1};
};

// The payload of each record follows from its number, so that any process can tell what it must be.
StoredRecord RecordAt(std::int64_t sequence, std::int64_t epoch, const std::string& blob) {
  return {.sequence = sequence,
          .epoch = epoch,
          .world_uid = sequence % 3 == 0 ? "kitchen" : "shelf",
          .revision = sequence,
          .payload = RandomBytes(50 + sequence % 400, static_cast<std::uint32_t>(sequence)),
          .blobs = {blob}};
}

// Writes for ever: blobs, records of both kinds, snapshots, upkeep, backups.
void WriteUntilKilled(const SqliteOptions& options, std::uint32_t seed,
                      const Acknowledgements& acknowledged) {
  const absl::StatusOr<std::unique_ptr<Store>> opened = OpenSqliteStore(options);
  if (!opened.ok()) _exit(2);
  Store& store = **opened;
  std::mt19937 random(seed);
  std::unique_ptr<Store::BackupRun> backup;
  for (int i = 0;; ++i) {
    const Durability durability = random() % 2 == 0 ? Durability::kDurable : Durability::kObserved;
    const std::string bytes = RandomBytes(100, random() % 50);
    const std::string blob = Sha256Hex(bytes);
    if (!store.PutBlob(blob, bytes, durability).ok()) _exit(2);
    std::vector<StoredRecord> records;
    for (std::int64_t n = random() % 4; n >= 0; --n) {
      records.push_back(RecordAt(store.last_sequence() + 1 + static_cast<int>(records.size()),
                                 store.epoch(), blob));
    }
    const auto result = store.Append(records, durability);
    if (!result.ok() || *result != AppendResult::kDurable) _exit(2);
    acknowledged.Tell(store.last_sequence());
    if (i % 7 == 0) {
      const StoredSnapshot snapshot = {.sequence = store.last_sequence() - 1,
                                       .world_uid = i % 2 == 0 ? "kitchen" : "shelf",
                                       .revision = store.last_sequence(),
                                       .payload = std::to_string(store.last_sequence() - 1)};
      if (!store.PutSnapshot(snapshot).ok()) _exit(2);
    }
    if (i % 5 == 0 && !store.Maintain().ok()) _exit(2);
    if (i % 11 == 0 && !store.CheckRoom().ok()) _exit(2);
    if (backup == nullptr) backup = *store.StartBackup();
    const auto step = backup->Step();
    if (!step.ok()) _exit(2);
    if (*step != nullptr) backup.reset();
  }
}

// Every record is there that was acknowledged, as it was written, and its blob.
void ExpectWhole(const SqliteOptions& options, std::int64_t acknowledged) {
  const auto opened = OpenSqliteStore(options);
  ASSERT_TRUE(opened.ok()) << opened.status();
  Store& store = **opened;
  EXPECT_FALSE(store.may_lack_observed());
  EXPECT_GE(store.last_sequence(), acknowledged);
  std::map<std::string, std::int64_t> folded;
  const auto snapshots = store.Snapshots();
  ASSERT_TRUE(snapshots.ok());
  for (const StoredSnapshot& snapshot : *snapshots) {
    EXPECT_EQ(snapshot.payload, std::to_string(snapshot.sequence));
    folded[snapshot.world_uid] = snapshot.sequence;
  }
  std::map<std::int64_t, StoredRecord> records;
  const auto followed = store.Follow("", 0, kWithoutLimit);
  ASSERT_TRUE(followed.ok()) << followed.status();
  for (const StoredRecord& record : *followed) {
    EXPECT_TRUE(records.emplace(record.sequence, record).second) << "twice";
    EXPECT_EQ(record, RecordAt(record.sequence, record.epoch, record.blobs.at(0)));
    EXPECT_TRUE(store.GetBlob(record.blobs[0]).ok());
  }
  for (std::int64_t sequence = 1; sequence <= store.last_sequence(); ++sequence) {
    const std::string world = RecordAt(sequence, 1, "").world_uid;
    EXPECT_EQ(records.contains(sequence), sequence > folded[world]) << sequence;
  }
}

// The signal that ended a child that does the work; 0 if it ended by itself.
int RunChild(const std::function<void()>& work, std::chrono::microseconds kill_after = {}) {
  const pid_t child = fork();
  if (child == 0) {
    work();
    _exit(0);
  }
  if (kill_after.count() > 0) {
    std::this_thread::sleep_for(kill_after);
    kill(child, SIGKILL);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

TEST(SqliteCrash, LosesNothingThatWasAcknowledgedWhenItIsKilledAtAnyMoment) {
  const TemporaryDirectory directory(FastFolder());
  SqliteOptions options = TestOptions(directory / "store");
  options.blob_grace = std::chrono::seconds(0);
  std::mt19937 random(1);
  std::int64_t acknowledged = 0;
  for (std::uint32_t kill = 0; kill < 40; ++kill) {
    Acknowledgements told;
    const std::chrono::microseconds moment(1000 + random() % 60'000);
    ASSERT_EQ(RunChild([&] { WriteUntilKilled(options, kill, told); }, moment), SIGKILL);
    acknowledged = std::max(acknowledged, told.Last());
    ExpectWhole(options, acknowledged);
    if (HasFailure()) break;
  }
  EXPECT_GT(acknowledged, 0);
  EXPECT_THAT(CheckStore(options.path)->faults, IsEmpty());
}

class KilledAtFailPoint : public testing::TestWithParam<const char*> {};

TEST_P(KilledAtFailPoint, LosesNothingThatWasAcknowledged) {
  const TemporaryDirectory directory(FastFolder());
  SqliteOptions options = TestOptions(directory / "store");
  options.blob_grace = std::chrono::seconds(0);
  std::int64_t acknowledged = 0;
  for (std::uint32_t pass = 1; pass <= 12; ++pass) {
    Acknowledgements told;
    const int signal = RunChild([&] {
      if (!SetFailPoint(absl::StrCat(GetParam(), ":", pass))) _exit(1);
      WriteUntilKilled(options, pass, told);
    });
    ASSERT_EQ(signal, SIGKILL);
    acknowledged = std::max(acknowledged, told.Last());
    ExpectWhole(options, acknowledged);
    if (HasFailure()) break;
  }
  EXPECT_THAT(CheckStore(options.path)->faults, IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(Places, KilledAtFailPoint,
                         testing::Values("before-record", "after-commit", "blob-renamed",
                                         "checkpoint", "compaction", "backup"),
                         [](const auto& info) {
                           std::string name = info.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

// SQLite's writes, to its log and, while the log is moved, to its database. The last one of a
// process is cut off in the middle.
std::int64_t writes_left = 0;

ssize_t WriteUntilCutOff(int fd, const void* bytes, std::size_t size, off64_t offset) {
  if (--writes_left > 0) return pwrite64(fd, bytes, size, offset);
  [[maybe_unused]] const ssize_t half = pwrite64(fd, bytes, size / 2, offset);
  std::raise(SIGKILL);
  return -1;
}

TEST(SqliteCrash, LosesNothingThatWasAcknowledgedWhenAnyWriteIsCutOff) {
  const TemporaryDirectory directory(FastFolder());
  SqliteOptions options = TestOptions(directory / "store");
  options.blob_grace = std::chrono::seconds(0);
  std::int64_t acknowledged = 0;
  // chosen: an opening makes about 10 writes, a round of the story with its checkpoint about 20.
  for (std::uint32_t count = 1; count <= 120; ++count) {
    Acknowledgements told;
    const int signal = RunChild([&] {
      writes_left = count;
      sqlite3_vfs* const vfs = sqlite3_vfs_find(nullptr);
      for (const char* name : {"pwrite", "pwrite64"}) {
        vfs->xSetSystemCall(vfs, name, reinterpret_cast<sqlite3_syscall_ptr>(&WriteUntilCutOff));
      }
      WriteUntilKilled(options, count, told);
    });
    ASSERT_EQ(signal, SIGKILL);
    acknowledged = std::max(acknowledged, told.Last());
    ExpectWhole(options, acknowledged);
    if (HasFailure()) break;
  }
  EXPECT_GT(acknowledged, 100);
  EXPECT_THAT(CheckStore(options.path)->faults, IsEmpty());
}

TEST(SqliteCrash, MigratesAgainAfterItWasKilledMidway) {
  for (int pass = 1; pass <= 4; ++pass) {
    const TemporaryDirectory directory(FastFolder());
    SqliteOptions options = TestOptions(directory / "store");
    std::vector<StoredRecord> records;
    {
      const std::unique_ptr<Store> store = OpenForTest(options.path);
      records = NextRecords(*store, "kitchen", 1, 50);
      ASSERT_TRUE(store->Append(records, Durability::kDurable).ok());
    }
    options.migrations = {"ALTER TABLE meta ADD COLUMN a TEXT NOT NULL DEFAULT ''",
                          "ALTER TABLE meta ADD COLUMN b TEXT NOT NULL DEFAULT ''"};
    ASSERT_EQ(RunChild([&] {
                SetFailPoint(absl::StrCat("migration:", pass));
                (void)OpenSqliteStore(options);
              }),
              SIGKILL);
    const auto store = OpenSqliteStore(options);
    ASSERT_TRUE(store.ok()) << store.status();
    EXPECT_EQ(*(*store)->Follow("", 0, kWithoutLimit), records);
  }
}

TEST(SqliteCrash, MakesTheStoreAgainAfterItWasKilledWhileItWasMade) {
  std::mt19937 random(3);
  const TemporaryDirectory directory(FastFolder());
  for (int i = 0; i < 25; ++i) {
    const std::string path = directory / absl::StrCat("store-", i);
    RunChild([&] { (void)OpenSqliteStore(TestOptions(path)); },
             std::chrono::microseconds(200 + random() % 8000));
    const std::unique_ptr<Store> store = OpenForTest(path);
    ASSERT_NE(store, nullptr);
    ASSERT_TRUE(store->Append(NextRecords(*store, "w", 1, 1), Durability::kDurable).ok());
  }
}

}  // namespace
}  // namespace cwm::server
