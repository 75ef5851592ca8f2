// What SQLite's store promises besides the contract: refusals, migration, blobs, backups, and what
// is done to its directory offline.
#include "server/store/sqlite/sqlite_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <fstream>
#include <thread>

#include "server/store/sqlite/store_directory.h"
#include "tests/server/store/sqlite_directory.h"
#include "tests/server/store/store_stories.h"

namespace cwm::server {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
namespace fs = std::filesystem;

// The status of opening the directory.
absl::Status OpenStatus(const SqliteOptions& options) { return OpenSqliteStore(options).status(); }

TEST(SqliteStore, NamesTheProcessThatHoldsTheLock) {
  const TemporaryDirectory directory(FastFolder());
  const std::unique_ptr<Store> store = OpenForTest(directory / "store");
  ASSERT_NE(store, nullptr);
  const absl::Status status = OpenStatus(TestOptions(directory / "store"));
  EXPECT_EQ(ReasonOf(status), "STORE_LOCKED");
  EXPECT_THAT(status.message(), HasSubstr(absl::StrCat("process ", getpid(), " ")));
  EXPECT_EQ(ReasonOf(CheckStore(directory / "store").status()), "STORE_LOCKED");
}

TEST(SqliteStore, RefusesADatabaseThatAnotherProgramHasOpen) {
  const TemporaryDirectory directory(FastFolder());
  const std::string path = directory / "store";
  ASSERT_NE(OpenForTest(path), nullptr);
  const pid_t child = fork();
  if (child == 0) {
    sqlite3* other = nullptr;
    sqlite3_open((path + "/store.db").c_str(), &other);
    sqlite3_exec(other, "PRAGMA locking_mode=EXCLUSIVE; SELECT count(*) FROM record", nullptr,
                 nullptr, nullptr);
    std::ofstream(directory / "ready") << "x";
    pause();
  }
  while (!fs::exists(directory / "ready")) std::this_thread::yield();
  const absl::Status status = OpenStatus(TestOptions(path));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_EQ(ReasonOf(status), "STORE_LOCKED") << status;
  EXPECT_NE(OpenForTest(path), nullptr);
}

TEST(SqliteStore, RefusesWhatIsNoStoreAndLeavesItAlone) {
  const TemporaryDirectory directory(FastFolder());
  fs::create_directory(directory / "photos");
  std::ofstream(directory / "photos/holiday.jpg") << "a picture";
  fs::create_directory(directory / "other");
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open((directory / "other/store.db").c_str(), &other), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(other, "CREATE TABLE t(a)", nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(other);
  fs::create_directory(directory / "text");
  std::ofstream(directory / "text/store.db")
      << "no database, but longer than a header" << std::string(100, '.');
  std::ofstream(directory / "file") << "no directory";
  for (const char* name : {"photos", "other", "text", "file"}) {
    const absl::Status status = OpenStatus(TestOptions(directory / name));
    EXPECT_EQ(ReasonOf(status), "STORE_FOREIGN") << name << ": " << status;
    EXPECT_THAT(status.message(), HasSubstr(directory / name));
  }
  EXPECT_FALSE(fs::exists(directory / "photos/store.db"));
  EXPECT_FALSE(fs::exists(directory / "photos/lock"));
}

TEST(SqliteStore, NeedsAParentDirectoryThatExists) {
  const TemporaryDirectory directory(FastFolder());
  const absl::Status status = OpenStatus(TestOptions(directory / "no/such/store"));
  EXPECT_EQ(ReasonOf(status), "STORE_NOT_WRITABLE") << status;
  EXPECT_EQ(ReasonOf(OpenStatus(TestOptions(""))), "INVALID_FIELD");
  EXPECT_NE(OpenForTest((directory / "with-slash") + "/"), nullptr);
}

TEST(SqliteStore, RefusesAStoreWhoseDatabaseIsGone) {
  const TemporaryDirectory directory(FastFolder());
  const std::string path = directory / "store";
  {
    const std::unique_ptr<Store> store = OpenForTest(path);
    ASSERT_TRUE(store->Append(NextRecords(*store, "w", 1, 1), Durability::kDurable).ok());
    ASSERT_TRUE(store->Close().ok());
  }
  fs::remove(path + "/store.db");
  EXPECT_EQ(ReasonOf(OpenStatus(TestOptions(path))), "STORE_DAMAGED");
}

TEST(SqliteStore, WarnsOfAFileSystemInMemory) {
  if (!fs::exists("/dev/shm")) GTEST_SKIP() << "needs /dev/shm";
  const TemporaryDirectory directory("/dev/shm");
  SqliteOptions options = TestOptions(directory / "store");
  std::vector<std::string> warnings;
  options.warn = [&](const std::string& text) { warnings.push_back(text); };
  EXPECT_TRUE(OpenStatus(options).ok());
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("in memory")));
}

// Version 2 of a later program: a column that is not there today.
SqliteOptions OptionsOfVersion2(const std::string& path) {
  SqliteOptions options = TestOptions(path);
  options.migrations = {"ALTER TABLE meta ADD COLUMN remark TEXT NOT NULL DEFAULT 'none'"};
  return options;
}

TEST(SqliteStore, MigratesAndKeepsACopyAndIsRefusedByTheOlderProgram) {
  const TemporaryDirectory directory(FastFolder());
  const std::string path = directory / "store";
  std::vector<StoredRecord> records;
  {
    const std::unique_ptr<Store> store = OpenForTest(path);
    records = NextRecords(*store, "kitchen", 1, 40);
    ASSERT_TRUE(store->Append(records, Durability::kDurable).ok());
  }
  {
    const auto store = OpenSqliteStore(OptionsOfVersion2(path));
    ASSERT_TRUE(store.ok()) << store.status();
    EXPECT_EQ(*(*store)->Follow("", 0, kWithoutLimit), records);
  }
  EXPECT_TRUE(OpenStatus(OptionsOfVersion2(path)).ok());
  for (bool accept_loss : {false, true}) {
    SqliteOptions older = TestOptions(path);
    older.accept_loss = accept_loss;
    EXPECT_EQ(ReasonOf(OpenStatus(older)), "STORE_NEWER");
  }
  // The copy is what the older program goes on with.
  fs::rename(path + "/store.db.v1.bak", path + "/store.db");
  fs::remove(path + "/store.db-wal");
  const std::unique_ptr<Store> store = OpenForTest(path);
  ASSERT_NE(store, nullptr);
  EXPECT_EQ(*store->Follow("", 0, kWithoutLimit), records);
}

TEST(SqliteStore, ChangesNothingIfAMigrationFails) {
  const TemporaryDirectory directory(FastFolder());
  const std::string path = directory / "store";
  std::vector<StoredRecord> records;
  {
    const std::unique_ptr<Store> store = OpenForTest(path);
    records = NextRecords(*store, "kitchen", 1, 4);
    ASSERT_TRUE(store->Append(records, Durability::kDurable).ok());
  }
  SqliteOptions options = TestOptions(path);
  options.migrations = {"DELETE FROM record", "no SQL"};
  EXPECT_FALSE(OpenStatus(options).ok());
  const std::unique_ptr<Store> store = OpenForTest(path);
  ASSERT_NE(store, nullptr);
  EXPECT_EQ(*store->Follow("", 0, kWithoutLimit), records);
}

TEST(SqliteStore, RemovesUnusedBlobsAfterTheirGraceAlone) {
  const TemporaryDirectory directory(FastFolder());
  const std::string hash = Sha256Hex("unused");
  SqliteOptions options = TestOptions(directory / "store");
  options.blob_grace = std::chrono::minutes(10);
  {
    const std::unique_ptr<Store> store = *OpenSqliteStore(options);
    ASSERT_TRUE(store->PutBlob(hash, "unused", Durability::kDurable).ok());
    ASSERT_TRUE(store->Maintain().ok());
    EXPECT_TRUE(store->GetBlob(hash).ok());
  }
  options.blob_grace = std::chrono::seconds(0);
  const std::unique_ptr<Store> store = *OpenSqliteStore(options);
  EXPECT_EQ(store->stats().blob_count, 1);
  ASSERT_TRUE(store->Maintain().ok());
  EXPECT_EQ(ReasonOf(store->GetBlob(hash).status()), "BLOB_MISSING");
  EXPECT_EQ(store->stats().blob_count, 0);
}

TEST(SqliteStore, RemovesHalfWrittenFilesWhenItIsOpened) {
  const TemporaryDirectory directory(FastFolder());
  const std::string path = directory / "store";
  ASSERT_NE(OpenForTest(path), nullptr);
  const std::string half = path + "/blobs/ab/ab12.new7";
  fs::create_directory(path + "/blobs/ab");
  std::ofstream(half) << "half";
  fs::create_directories(path + "/backup-3/blobs");
  std::ofstream(path + "/store.db.new") << "half";
  ASSERT_NE(OpenForTest(path), nullptr);
  EXPECT_FALSE(fs::exists(half));
  EXPECT_FALSE(fs::exists(path + "/backup-3"));
  EXPECT_FALSE(fs::exists(path + "/store.db.new"));
}

TEST(SqliteStore, ReplacesABlobWhoseFileIsNotWhole) {
  const TemporaryDirectory directory(FastFolder());
  const std::string path = directory / "store";
  const std::string bytes = RandomBytes(5000, 1);
  const std::string hash = Sha256Hex(bytes);
  {
    const std::unique_ptr<Store> store = OpenForTest(path);
    ASSERT_TRUE(store->PutBlob(hash, bytes, Durability::kObserved).ok());
  }
  // As after a power cut: the name is there, the bytes are not.
  const std::string file = absl::StrCat(path, "/blobs/", hash.substr(0, 2), "/", hash, ".observed");
  fs::resize_file(file, 100);
  for (const Durability durability : {Durability::kObserved, Durability::kDurable}) {
    const std::unique_ptr<Store> store = OpenForTest(path);
    if (durability == Durability::kObserved) {
      EXPECT_EQ(ReasonOf(store->GetBlob(hash).status()), "BLOB_MISSING");
    }
    ASSERT_TRUE(store->PutBlob(hash, bytes, durability).ok());
    EXPECT_EQ(*store->GetBlob(hash), bytes);
  }
  EXPECT_FALSE(fs::exists(file));
}

TEST(SqliteStore, MakesObservedBlobsDurableWhenItIsClosed) {
  const TemporaryDirectory directory(FastFolder());
  const std::string path = directory / "store";
  const std::string hash = Sha256Hex("observed");
  const std::string file = absl::StrCat(path, "/blobs/", hash.substr(0, 2), "/", hash);
  {
    const std::unique_ptr<Store> store = OpenForTest(path);
    EXPECT_FALSE(store->HasDurableBlob(hash));
    ASSERT_TRUE(store->PutBlob(hash, "observed", Durability::kObserved).ok());
    EXPECT_FALSE(store->HasDurableBlob(hash));
    EXPECT_TRUE(fs::exists(file + ".observed"));
  }
  {
    // This process has not put it, but read it.
    const std::unique_ptr<Store> store = OpenForTest(path);
    EXPECT_TRUE(store->GetBlob(hash).ok());
    EXPECT_FALSE(store->HasDurableBlob(hash));
    ASSERT_TRUE(store->Close().ok());
    EXPECT_FALSE(fs::exists(file + ".observed"));
  }
  {
    const std::unique_ptr<Store> store = OpenForTest(path);
    EXPECT_EQ(*store->GetBlob(hash), "observed");
    EXPECT_TRUE(store->HasDurableBlob(hash));
  }
  fs::resize_file(file, 3);
  const std::unique_ptr<Store> store = OpenForTest(path);
  EXPECT_EQ(ReasonOf(store->GetBlob(hash).status()), "STORE_DAMAGED") << "no power cut can be why";
  EXPECT_FALSE(store->HasDurableBlob(hash)) << "it must be put again";
}

TEST(SqliteStore, KeepsABlobThatWasFoundDurableAsIfItWerePutAgain) {
  const TemporaryDirectory directory(FastFolder());
  SqliteOptions options = TestOptions(directory / "store");
  options.blob_grace = std::chrono::seconds(1);
  const std::unique_ptr<Store> store = *OpenSqliteStore(options);
  const std::string hash = Sha256Hex("x");
  ASSERT_TRUE(store->PutBlob(hash, "x", Durability::kDurable).ok());
  std::this_thread::sleep_for(options.blob_grace);
  EXPECT_TRUE(store->HasDurableBlob(hash));
  ASSERT_TRUE(store->Maintain().ok());
  EXPECT_TRUE(store->GetBlob(hash).ok());
}

TEST(SqliteStore, PutsTheSameBlobFromManyThreads) {
  const TemporaryDirectory directory(FastFolder());
  const std::unique_ptr<Store> store = OpenForTest(directory / "store");
  std::vector<std::string> blobs;
  for (std::uint32_t i = 0; i < 8; ++i) blobs.push_back(RandomBytes(2000 + i, i));
  std::vector<std::jthread> threads;
  for (unsigned t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (unsigned i = 0; i < 40; ++i) {
        const std::string& bytes = blobs[(t + i) % blobs.size()];
        const std::string hash = Sha256Hex(bytes);
        const auto durability = (t + i) % 3 == 0 ? Durability::kDurable : Durability::kObserved;
        EXPECT_TRUE(store->PutBlob(hash, bytes, durability).ok());
        EXPECT_EQ(*store->GetBlob(hash), bytes);
        EXPECT_LE(store->stats().blob_count, 8);
      }
    });
  }
  threads.clear();
  EXPECT_EQ(store->stats().blob_count, 8);
}

TEST(SqliteStore, RefusesToBeUsedAfterItWasClosed) {
  const TemporaryDirectory directory(FastFolder());
  const std::unique_ptr<Store> store = OpenForTest(directory / "store");
  ASSERT_TRUE(store->Close().ok());
  EXPECT_EQ(ReasonOf(store->Append(NextRecords(*store, "w", 1, 1), Durability::kDurable).status()),
            "STORE_FAILED");
  EXPECT_EQ(ReasonOf(store->Follow("", 0, 1).status()), "STORE_FAILED");
  EXPECT_EQ(ReasonOf(store->Maintain()), "STORE_FAILED");
}

TEST(SqliteStore, MakesOneBackupAtATime) {
  const TemporaryDirectory directory(FastFolder());
  const std::string path = directory / "store";
  const std::unique_ptr<Store> store = OpenForTest(path);
  auto run = store->StartBackup();
  ASSERT_TRUE(run.ok()) << run.status();
  EXPECT_EQ(ReasonOf(store->StartBackup().status()), "BACKUP_RUNNING");
  run->reset();
  run = store->StartBackup();
  ASSERT_TRUE(run.ok()) << run.status();
  ASSERT_TRUE(store->Close().ok());
  EXPECT_EQ(ReasonOf((*run)->Step().status()), "BACKUP_ENDED");
  for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
    EXPECT_FALSE(entry.path().filename().string().starts_with("backup-")) << entry.path();
  }
}

// A store with two worlds, a snapshot and blobs of both kinds.
class BackedUpStore : public testing::Test {
 protected:
  void SetUp() override {
    store_ = OpenForTest(directory_ / "store");
    ASSERT_NE(store_, nullptr);
    const std::string durable = RandomBytes(70'000, 1);
    const std::string observed = RandomBytes(80'000, 2);
    durable_hash_ = Sha256Hex(durable);
    observed_hash_ = Sha256Hex(observed);
    ASSERT_TRUE(store_->PutBlob(durable_hash_, durable, Durability::kDurable).ok());
    ASSERT_TRUE(store_->PutBlob(observed_hash_, observed, Durability::kObserved).ok());
    Append("kitchen", 20, {durable_hash_});
    Append("shelf", 20, {observed_hash_});
    ASSERT_TRUE(store_
                    ->PutSnapshot({.sequence = 10,
                                   .world_uid = "kitchen",
                                   .revision = 10,
                                   .payload = "ten records",
                                   .blobs = {durable_hash_}})
                    .ok());
    ASSERT_TRUE(store_->Maintain().ok());
  }

  void Append(const std::string& world, int count, const std::vector<std::string>& blobs) {
    std::vector<StoredRecord> records = NextRecords(*store_, world, 1, count, 2000);
    for (StoredRecord& record : records) record.blobs = blobs;
    ASSERT_TRUE(store_->Append(records, Durability::kDurable).ok());
  }

  // Copies a complete backup to a folder, as the command line does.
  void BackUpTo(const std::string& folder) {
    auto run = store_->StartBackup();
    ASSERT_TRUE(run.ok()) << run.status();
    std::unique_ptr<Backup> backup;
    while (backup == nullptr) {
      auto step = (*run)->Step();
      ASSERT_TRUE(step.ok()) << step.status();
      backup = *std::move(step);
    }
    for (const BackupFile& file : backup->files()) {
      const fs::path copy = fs::path(folder) / file.path;
      fs::create_directories(copy.parent_path());
      fs::copy_file(file.source, copy);
    }
  }

  TemporaryDirectory directory_ = TemporaryDirectory(FastFolder());
  std::unique_ptr<Store> store_;
  std::string durable_hash_;
  std::string observed_hash_;
};

TEST_F(BackedUpStore, IsRestoredAsItWas) {
  BackUpTo(directory_ / "backup");
  const std::vector<StoredRecord> records = *store_->Follow("", 0, kWithoutLimit);
  const std::vector<StoredSnapshot> snapshots = *store_->Snapshots();
  const std::int64_t last = store_->last_sequence();
  Append("kitchen", 7, {});  // not in the backup
  const auto report = RestoreStore(directory_ / "backup", directory_ / "restored");
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_EQ(report->last_sequence, last);
  EXPECT_EQ(report->world_count, 2);
  EXPECT_EQ(report->record_count, 30);
  EXPECT_EQ(report->snapshot_count, 1);
  EXPECT_EQ(report->blob_count, 2);
  EXPECT_EQ(report->missing_blob_count, 0);
  EXPECT_TRUE(report->was_closed);
  EXPECT_THAT(report->faults, IsEmpty());
  const std::unique_ptr<Store> restored = OpenForTest(directory_ / "restored");
  ASSERT_NE(restored, nullptr);
  EXPECT_EQ(*restored->Follow("", 0, kWithoutLimit), records);
  EXPECT_EQ(*restored->Snapshots(), snapshots);
  EXPECT_TRUE(restored->GetBlob(durable_hash_).ok());
  EXPECT_TRUE(restored->GetBlob(observed_hash_).ok());
  EXPECT_FALSE(restored->may_lack_observed());
  EXPECT_TRUE(restored->may_lack_durable()) << "the store may have gone on after the backup";
  EXPECT_FALSE(store_->may_lack_durable());
  ASSERT_TRUE(restored->RecoveryDone().ok());
  EXPECT_FALSE(restored->may_lack_durable());
}

TEST_F(BackedUpStore, IsToldToLackRecordsAtEachOpeningUntilItsReaderHasRecovered) {
  BackUpTo(directory_ / "backup");
  ASSERT_TRUE(RestoreStore(directory_ / "backup", directory_ / "restored").ok());
  for (const std::string name : {"backup", "restored"}) {
    for (int i = 0; i < 2; ++i) {
      EXPECT_TRUE(OpenForTest(directory_ / name)->may_lack_durable()) << name;
    }
    ASSERT_TRUE(OpenForTest(directory_ / name)->RecoveryDone().ok());
    EXPECT_FALSE(OpenForTest(directory_ / name)->may_lack_durable()) << name;
  }
}

TEST_F(BackedUpStore, CanBeCheckedWithoutAChange) {
  BackUpTo(directory_ / "backup");
  const auto before = FilesOf(directory_ / "backup");
  const auto report = CheckStore(directory_ / "backup");
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_THAT(report->faults, IsEmpty());
  EXPECT_EQ(FilesOf(directory_ / "backup"), before);
}

TEST_F(BackedUpStore, IsNotRestoredOverAnything) {
  BackUpTo(directory_ / "backup");
  fs::create_directory(directory_ / "full");
  std::ofstream(directory_ / "full/file") << "x";
  EXPECT_EQ(ReasonOf(RestoreStore(directory_ / "backup", directory_ / "full").status()),
            "STORE_EXISTS");
  EXPECT_EQ(ReasonOf(RestoreStore(directory_ / "nothing", directory_ / "new").status()),
            "STORE_MISSING");
  fs::create_directory(directory_ / "empty");
  EXPECT_TRUE(RestoreStore(directory_ / "backup", directory_ / "empty").ok());
}

TEST_F(BackedUpStore, IsNotRestoredIfItIsDamaged) {
  BackUpTo(directory_ / "backup");
  const std::vector<std::string> names = {
      "store.db", "head", absl::StrCat("blobs/", durable_hash_.substr(0, 2), "/", durable_hash_)};
  for (const std::string& name : names) {
    const std::string file = (directory_ / "backup") + "/" + name;
    const std::int64_t offset = static_cast<std::int64_t>(fs::file_size(file)) / 2;
    FlipBit(file, offset, 3);
    const absl::Status status = RestoreStore(directory_ / "backup", directory_ / "new").status();
    EXPECT_EQ(ReasonOf(status), "STORE_DAMAGED") << name << ": " << status;
    EXPECT_FALSE(fs::exists(directory_ / "new"));
    FlipBit(file, offset, 3);
  }
  EXPECT_TRUE(RestoreStore(directory_ / "backup", directory_ / "new").ok());
}

TEST_F(BackedUpStore, TellsMissingBlobsAndUnusedOnes) {
  ASSERT_TRUE(store_->PutBlob(Sha256Hex("x"), "x", Durability::kDurable).ok());
  ASSERT_TRUE(store_->Close().ok());
  store_.reset();
  const std::string path = directory_ / "store";
  fs::remove(absl::StrCat(path, "/blobs/", observed_hash_.substr(0, 2), "/", observed_hash_));
  for (const auto& report : {CheckStore(path), StatStore(path)}) {
    ASSERT_TRUE(report.ok()) << report.status();
    EXPECT_EQ(report->missing_blob_count, 1);
    EXPECT_EQ(report->unused_blob_count, 1);
    EXPECT_EQ(report->blob_count, 2);
    EXPECT_EQ(report->fault_count, 0);
  }
}

}  // namespace
}  // namespace cwm::server
