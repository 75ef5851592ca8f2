// Disks that are full or broken, and what a power cut leaves.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/syscall.h>

#include <atomic>
#include <cerrno>

#include "server/store/sqlite/store_directory.h"
#include "tests/server/store/sqlite_directory.h"
#include "tests/server/store/store_stories.h"

namespace {

// Calls of fdatasync that still succeed; negative: all.
std::atomic<int> syncs_left = -1;
// The error of the next writes of SQLite; 0: none.
std::atomic<int> write_error = 0;

ssize_t WriteOrFail(int fd, const void* bytes, std::size_t size, off64_t offset) {
  if (write_error != 0) {
    errno = write_error;
    return -1;
  }
  return pwrite64(fd, bytes, size, offset);
}

// Replaces the function with which SQLite writes, while it exists.
class FailingWrites {
 public:
  FailingWrites() { Set(reinterpret_cast<sqlite3_syscall_ptr>(&WriteOrFail)); }
  ~FailingWrites() {
    write_error = 0;
    Set(nullptr);
  }
  FailingWrites(const FailingWrites&) = delete;
  FailingWrites& operator=(const FailingWrites&) = delete;

 private:
  static void Set(sqlite3_syscall_ptr function) {
    sqlite3_vfs* const vfs = sqlite3_vfs_find(nullptr);
    for (const char* name : {"pwrite", "pwrite64"}) vfs->xSetSystemCall(vfs, name, function);
  }
};

}  // namespace

// Takes the place of the C library's function, for SQLite and for the engine.
extern "C" int fdatasync(int fd) {
  if (syncs_left == 0) {
    errno = EIO;
    return -1;
  }
  if (syncs_left > 0) --syncs_left;
  return static_cast<int>(syscall(SYS_fdatasync, fd));
}

namespace cwm::server {
namespace {

namespace fs = std::filesystem;

class FaultyDisk : public testing::Test {
 protected:
  ~FaultyDisk() override { syncs_left = -1; }
  TemporaryDirectory directory_;
};

TEST_F(FaultyDisk, RollsBackWhatFindsNoRoomAndGoesOn) {
  const FailingWrites writes;
  const std::string path = directory_ / "store";
  std::vector<StoredRecord> all;
  for (const int error : {ENOSPC, EDQUOT}) {
    const std::unique_ptr<Store> store = OpenForTest(path);
    for (int i = 0; i < 5; ++i) {
      const std::vector<StoredRecord> records = NextRecords(*store, "kitchen", 1, 20, 3000);
      write_error = error;
      const auto refused = store->Append(records, Durability::kDurable);
      EXPECT_EQ(ReasonOf(refused.status()), "DISK_FULL") << refused.status();
      EXPECT_TRUE(DetailsOf(refused.status()).retry_after_s.has_value());
      EXPECT_EQ(*store->Follow("", 0, kWithoutLimit), all);
      EXPECT_EQ(ReasonOf(store->PutBlob(Sha256Hex("x"), "x", Durability::kDurable)), "");
      write_error = 0;
      ASSERT_TRUE(store->Append(records, Durability::kDurable).ok());
      all.insert(all.end(), records.begin(), records.end());
    }
  }
  const std::unique_ptr<Store> store = OpenForTest(path);
  EXPECT_EQ(*store->Follow("", 0, kWithoutLimit), all);
}

TEST_F(FaultyDisk, IsUsedNoMoreAfterAWriteFailed) {
  const FailingWrites writes;
  const std::unique_ptr<Store> store = OpenForTest(directory_ / "store");
  write_error = EIO;
  const auto failed = store->Append(NextRecords(*store, "w", 1, 1), Durability::kObserved);
  EXPECT_EQ(ReasonOf(failed.status()), "STORE_FAILED") << failed.status();
  EXPECT_EQ(failed.status().code(), absl::StatusCode::kUnavailable);
  write_error = 0;
  for (const absl::Status& status :
       {store->Append(NextRecords(*store, "w", 1, 1), Durability::kDurable).status(),
        store->Follow("", 0, 1).status(), store->Maintain(), store->CheckRoom(), store->Close()}) {
    EXPECT_EQ(ReasonOf(status), "STORE_FAILED");
  }
}

TEST_F(FaultyDisk, IsUsedNoMoreAfterABlobCouldNotBeSynced) {
  const std::unique_ptr<Store> store = OpenForTest(directory_ / "store");
  syncs_left = 0;
  EXPECT_EQ(ReasonOf(store->PutBlob(Sha256Hex("x"), "x", Durability::kDurable)), "STORE_FAILED");
  syncs_left = -1;
  EXPECT_EQ(ReasonOf(store->Append(NextRecords(*store, "w", 1, 1), Durability::kDurable).status()),
            "STORE_FAILED");
}

// Forbids this process to open files, while it exists.
class NoMoreFiles {
 public:
  NoMoreFiles() {
    getrlimit(RLIMIT_NOFILE, &before_);
    rlimit none = before_;
    none.rlim_cur = 0;
    setrlimit(RLIMIT_NOFILE, &none);
  }
  ~NoMoreFiles() { setrlimit(RLIMIT_NOFILE, &before_); }
  NoMoreFiles(const NoMoreFiles&) = delete;
  NoMoreFiles& operator=(const NoMoreFiles&) = delete;

 private:
  rlimit before_ = {};
};

TEST_F(FaultyDisk, RefusesBlobsWithoutFileDescriptorsAndTakesThemLater) {
  const std::unique_ptr<Store> store = OpenForTest(directory_ / "store");
  ASSERT_TRUE(store->PutBlob(Sha256Hex("old"), "old", Durability::kObserved).ok());
  const auto put_all = [&] {
    return std::vector<absl::Status>{
        store->PutBlob(Sha256Hex("old"), "old", Durability::kDurable),
        store->PutBlob(Sha256Hex("new"), "new", Durability::kDurable),
        store->PutBlob(Sha256Hex("other"), "other", Durability::kObserved),
        store->GetBlob(Sha256Hex("old")).status()};
  };
  std::vector<absl::Status> refused;
  {
    const NoMoreFiles no_more_files;
    refused = put_all();
  }
  for (const absl::Status& status : refused) {
    EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
    EXPECT_EQ(ReasonOf(status), "OUT_OF_FILES") << status;
    EXPECT_TRUE(DetailsOf(status).retry_after_s.has_value());
  }
  EXPECT_FALSE(store->HasDurableBlob(Sha256Hex("old")));
  for (const absl::Status& status : put_all()) EXPECT_TRUE(status.ok()) << status;
  EXPECT_TRUE(store->HasDurableBlob(Sha256Hex("old")));
  EXPECT_EQ(*store->GetBlob(Sha256Hex("new")), "new");
  EXPECT_TRUE(store->Append(NextRecords(*store, "w", 1, 1), Durability::kDurable).ok());
}

int ShortRows(sqlite3* database, char** /*message*/, const void* /*functions*/) {
  sqlite3_limit(database, SQLITE_LIMIT_LENGTH, 20'000);
  return SQLITE_OK;
}

TEST(RowsOfSqlite, RefuseASnapshotThatIsTooLargeAndTheStoreGoesOn) {
  const TemporaryDirectory directory(FastFolder());
  const auto extension = reinterpret_cast<void (*)()>(&ShortRows);
  sqlite3_auto_extension(extension);
  const std::unique_ptr<Store> store = OpenForTest(directory / "store");
  sqlite3_cancel_auto_extension(extension);
  ASSERT_NE(store, nullptr);
  ASSERT_TRUE(store->Append(NextRecords(*store, "w", 1, 3), Durability::kDurable).ok());
  StoredSnapshot snapshot = {.sequence = 3, .world_uid = "w", .revision = 3};
  // The payload is too large, or the payload with the columns beside it.
  for (const std::size_t size : {20'001, 19'990}) {
    snapshot.payload = std::string(size, 'x');
    const absl::Status status = store->PutSnapshot(snapshot);
    EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
    EXPECT_EQ(ReasonOf(status), "SNAPSHOT_TOO_LARGE") << status;
    EXPECT_THAT(std::string(status.message()), testing::HasSubstr("at most 20000 bytes"));
    EXPECT_EQ(*store->SnapshotOf("w"), std::nullopt);
    EXPECT_EQ(store->Follow("w", 0, kWithoutLimit)->size(), 3U);
  }
  snapshot.payload = std::string(10'000, 'x');
  EXPECT_TRUE(store->PutSnapshot(snapshot).ok());
  EXPECT_TRUE(store->Append(NextRecords(*store, "w", 4, 1), Durability::kDurable).ok());
}

// Whichever sync of an opening, an append, a checkpoint or a blob fails, the store stops; what it
// acknowledged before is there when it is opened again.
TEST_F(FaultyDisk, LosesNothingThatWasAcknowledgedWhenAnySyncFails) {
  bool all_succeeded = false;
  for (int count = 0; count < 200 && !all_succeeded; ++count) {
    const std::string path = directory_ / absl::StrCat("store-", count);
    std::int64_t acknowledged = 0;
    absl::Status failure;
    {
      syncs_left = count;
      const auto store = OpenSqliteStore(TestOptions(path));
      failure = store.status();
      for (int i = 0; failure.ok() && i < 3; ++i) {
        const std::string bytes = RandomBytes(100, static_cast<std::uint32_t>(i));
        failure = (*store)->PutBlob(Sha256Hex(bytes), bytes, Durability::kDurable);
        if (!failure.ok()) break;
        failure = (*store)
                      ->Append(NextRecords(**store, "w", i, 2),
                               i == 1 ? Durability::kObserved : Durability::kDurable)
                      .status();
        if (failure.ok()) acknowledged = (*store)->last_sequence();
        if (failure.ok()) failure = (*store)->Maintain();
      }
      if (failure.ok()) failure = (*store)->Close();
      all_succeeded = failure.ok();
    }
    syncs_left = -1;
    if (!failure.ok()) {
      EXPECT_EQ(ReasonOf(failure), "STORE_FAILED") << failure;
    }
    const std::unique_ptr<Store> store = OpenForTest(path);
    ASSERT_NE(store, nullptr) << "after " << count << " syncs";
    const auto records = store->Follow("", 0, kWithoutLimit);
    ASSERT_TRUE(records.ok());
    EXPECT_GE(static_cast<std::int64_t>(records->size()), acknowledged);
    for (const StoredRecord& record : *records) {
      EXPECT_EQ(record.payload, RandomBytes(300, static_cast<std::uint32_t>(record.sequence)));
    }
  }
  EXPECT_TRUE(all_succeeded) << "more syncs than tried";
}

// A file system in memory of its own, of a few MiB. Needs root.
class SmallDisk : public testing::Test {
 protected:
  void SetUp() override {
    if (mount("tmpfs", directory_ / "", "tmpfs", 0, "size=8m") != 0) {
      GTEST_SKIP() << "needs root to mount a small file system";
    }
    is_mounted_ = true;
    options_ = TestOptions(directory_ / "store");
    options_.ballast_bytes = 1 << 20;
    options_.low_water_bytes = 256 << 10;
  }
  void TearDown() override {
    store_.reset();
    if (is_mounted_) umount2(directory_ / "", MNT_DETACH);
  }
  struct MountPoint : TemporaryDirectory {
    const char* operator/(const char* name) {
      path = TemporaryDirectory::operator/(name);
      return path.c_str();
    }
    std::string path;
  };
  void Fill(std::int64_t bytes_left) {
    const fs::space_info space = fs::space(options_.path);
    std::ofstream out(directory_ / "filler", std::ios::binary | std::ios::app);
    const std::int64_t size = static_cast<std::int64_t>(space.available) - bytes_left;
    if (size > 0) out << std::string(static_cast<std::size_t>(size), 'x');
  }

  MountPoint directory_;
  bool is_mounted_ = false;
  SqliteOptions options_;
  std::unique_ptr<Store> store_;
};

TEST_F(SmallDisk, RefusesRecordsWhenItIsFullAndTakesThemWhenThereIsRoom) {
  store_ = *OpenSqliteStore(options_);
  EXPECT_TRUE(fs::exists(options_.path + "/ballast"));
  EXPECT_TRUE(store_->CheckRoom().ok());
  std::vector<StoredRecord> all;
  const auto append = [&] {
    const std::vector<StoredRecord> records = NextRecords(*store_, "kitchen", 1, 8, 4000);
    const auto result = store_->Append(records, Durability::kDurable);
    if (result.ok()) all.insert(all.end(), records.begin(), records.end());
    return result.status();
  };
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(append().ok());
  // Opened again, so that its log is empty and has no room to give.
  store_.reset();
  store_ = *OpenSqliteStore(options_);
  Fill(200'000);
  EXPECT_EQ(ReasonOf(store_->CheckRoom()), "DISK_FULL");
  EXPECT_EQ(*store_->Follow("", 0, kWithoutLimit), all) << "reads go on";
  Fill(0);
  ASSERT_TRUE(fs::exists(options_.path + "/ballast"));
  ASSERT_TRUE(append().ok()) << "what is appended all the same takes the place of the ballast";
  EXPECT_FALSE(fs::exists(options_.path + "/ballast"));
  EXPECT_EQ(ReasonOf(store_->CheckRoom()), "DISK_FULL");

  // The ballast lets records be folded, and the log be moved.
  const StoredSnapshot snapshot = {
      .sequence = all[39].sequence, .world_uid = "kitchen", .revision = 40, .payload = "folded"};
  ASSERT_TRUE(store_->PutSnapshot(snapshot).ok());
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(store_->Maintain().ok());
  EXPECT_EQ(ReasonOf(store_->CheckRoom()), "DISK_FULL");
  all.erase(all.begin(), all.begin() + 40);
  EXPECT_EQ(*store_->Follow("", 0, kWithoutLimit), all);

  // A server that starts on a full disk can be read.
  store_.reset();
  auto opened = OpenSqliteStore(options_);
  ASSERT_TRUE(opened.ok()) << opened.status();
  store_ = *std::move(opened);
  EXPECT_EQ(*store_->Follow("", 0, kWithoutLimit), all);

  fs::remove(directory_ / "filler");
  ASSERT_TRUE(store_->CheckRoom().ok());
  ASSERT_TRUE(store_->Maintain().ok());
  EXPECT_TRUE(fs::exists(options_.path + "/ballast"));
  ASSERT_TRUE(append().ok());
  ASSERT_TRUE(store_->Close().ok());
  store_ = *OpenSqliteStore(options_);
  EXPECT_EQ(*store_->Follow("", 0, kWithoutLimit), all);
  EXPECT_THAT(*store_->Snapshots(), testing::ElementsAre(snapshot));
}

TEST_F(SmallDisk, RefusesBlobsBelowTheLowWaterMark) {
  store_ = *OpenSqliteStore(options_);
  const std::string old = RandomBytes(100'000, 1);
  ASSERT_TRUE(store_->PutBlob(Sha256Hex(old), old, Durability::kDurable).ok());
  Fill(options_.low_water_bytes + 300'000);
  for (const Durability durability : {Durability::kObserved, Durability::kDurable}) {
    const std::string large = RandomBytes(350'000, 2);
    const absl::Status status = store_->PutBlob(Sha256Hex(large), large, durability);
    EXPECT_EQ(ReasonOf(status), "DISK_FULL") << status;
    EXPECT_EQ(ReasonOf(store_->GetBlob(Sha256Hex(large)).status()), "BLOB_MISSING");
  }
  EXPECT_TRUE(store_->CheckRoom().ok()) << "small changes are taken";
  EXPECT_TRUE(store_->PutBlob(Sha256Hex("small"), "small", Durability::kDurable).ok());
  Fill(options_.low_water_bytes - 20'000);
  EXPECT_EQ(ReasonOf(store_->PutBlob(Sha256Hex("x"), "x", Durability::kDurable)), "DISK_FULL");
  EXPECT_TRUE(store_->PutBlob(Sha256Hex(old), old, Durability::kDurable).ok()) << "it is there";
  fs::remove(directory_ / "filler");
  EXPECT_TRUE(store_->PutBlob(Sha256Hex("x"), "x", Durability::kDurable).ok());
}

// A directory on another file system: what was not synced there is gone, as after a power cut.
class PowerCut : public testing::Test {
 protected:
  void SetUp() override {
    if (FastFolder() == fs::temp_directory_path()) GTEST_SKIP() << "needs /dev/shm";
    const std::unique_ptr<Store> store = OpenForTest(before_ / "store");
    ASSERT_NE(store, nullptr);
    ASSERT_TRUE(store->Append(NextRecords(*store, "w", 1, 4), Durability::kDurable).ok());
    fs::copy_file(before_ / "store/store.db-wal", before_ / "synced-log");
    ASSERT_TRUE(store->Append(NextRecords(*store, "w", 5, 3), Durability::kObserved).ok());
  }
  // Copies the store as it is on the disk, with the log as it was when it was last synced.
  void LoseWhatWasNotSynced() {
    fs::copy(before_ / "store", after_ / "store", fs::copy_options::recursive);
    fs::copy_file(before_ / "synced-log", after_ / "store/store.db-wal",
                  fs::copy_options::overwrite_existing);
  }

  TemporaryDirectory before_ = TemporaryDirectory(FastFolder());
  TemporaryDirectory after_;
};

TEST_F(PowerCut, MayTakeObservedRecordsAndNothingElse) {
  LoseWhatWasNotSynced();
  const std::unique_ptr<Store> store = OpenForTest(after_ / "store");
  ASSERT_NE(store, nullptr);
  EXPECT_TRUE(store->may_lack_observed());
  EXPECT_EQ(store->last_sequence(), 4);
}

TEST_F(PowerCut, IsToldAtEachOpeningUntilTheReaderHasRecovered) {
  LoseWhatWasNotSynced();
  for (const bool is_closed : {false, true, false}) {
    const std::unique_ptr<Store> store = OpenForTest(after_ / "store");
    ASSERT_NE(store, nullptr);
    EXPECT_TRUE(store->may_lack_observed());
    EXPECT_FALSE(store->may_lack_durable());
    if (is_closed) {
      ASSERT_TRUE(store->Close().ok());
    }
  }
  {
    const std::unique_ptr<Store> store = OpenForTest(after_ / "store");
    EXPECT_TRUE(store->may_lack_observed());
    ASSERT_TRUE(store->RecoveryDone().ok());
    EXPECT_FALSE(store->may_lack_observed());
  }
  EXPECT_FALSE(OpenForTest(after_ / "store")->may_lack_observed());
}

TEST_F(PowerCut, IsToldFromTheEndOfAProcess) {
  {
    const std::unique_ptr<Store> store = OpenForTest(before_ / "store");
    EXPECT_FALSE(store->may_lack_observed());
    EXPECT_EQ(store->last_sequence(), 7);
    ASSERT_TRUE(store->Close().ok());
  }
  fs::copy(before_ / "store", after_ / "store", fs::copy_options::recursive);
  const std::unique_ptr<Store> store = OpenForTest(after_ / "store");
  EXPECT_FALSE(store->may_lack_observed()) << "it was closed";
}

TEST_F(PowerCut, IsNoExcuseForLostObservedRecordsIfThereWasNone) {
  fs::copy_file(before_ / "synced-log", before_ / "store/store.db-wal",
                fs::copy_options::overwrite_existing);
  EXPECT_EQ(ReasonOf(OpenSqliteStore(TestOptions(before_ / "store")).status()), "STORE_DAMAGED");
}

}  // namespace
}  // namespace cwm::server
