// One flipped bit anywhere in a store is told, or has no effect: no other payload is ever served.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "server/store/sqlite/head_file.h"
#include "server/store/sqlite/store_directory.h"
#include "tests/server/store/sqlite_directory.h"
#include "tests/server/store/store_stories.h"

namespace cwm::server {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
namespace fs = std::filesystem;

constexpr int kWorldCount = 2;
constexpr std::int64_t kPageBytes = 4096;

// All that a store can be asked for.
struct Content {
  std::vector<StoredRecord> records = {};
  std::vector<std::vector<StoredRecord>> records_of_worlds = {};
  std::vector<StoredSnapshot> snapshots = {};
  std::int64_t last_sequence = 0;
  friend bool operator==(const Content&, const Content&) = default;
};

std::string WorldName(int index) { return absl::StrCat("world-", index); }

absl::StatusOr<Content> ReadContent(Store& store) {
  Content content;
  auto records = store.Follow("", 0, kWithoutLimit);
  if (!records.ok()) return records.status();
  content.records = *std::move(records);
  for (int i = 0; i < kWorldCount; ++i) {
    auto of_world = store.Follow(WorldName(i), 0, kWithoutLimit);
    if (!of_world.ok()) return of_world.status();
    content.records_of_worlds.push_back(*std::move(of_world));
  }
  auto snapshots = store.Snapshots();
  if (!snapshots.ok()) return snapshots.status();
  content.snapshots = *std::move(snapshots);
  content.last_sequence = store.last_sequence();
  return content;
}

// A small store of two worlds: records in the database and in the log, a snapshot, records that it
// replaced. It was not closed, as after kill -9.
class DamagedStore : public testing::Test {
 protected:
  void SetUp() override {
    original_ = directory_ / "original";
    const std::unique_ptr<Store> store = OpenForTest(original_);
    ASSERT_NE(store, nullptr);
    Append(*store, 12, 200);
    ASSERT_TRUE(store
                    ->PutSnapshot({.sequence = 5,
                                   .world_uid = WorldName(0),
                                   .revision = 5,
                                   .payload = RandomBytes(3000, 77)})
                    .ok());
    ASSERT_TRUE(store->Maintain().ok());  // deletes the rows that the snapshot replaced
    ASSERT_TRUE(store->Maintain().ok());  // moves the log into the database
    Append(*store, 6, 200);
    Append(*store, 1, 9000);
    for (int i = 0; i < 4; ++i) Append(*store, 1, 150);
    content_ = *ReadContent(*store);
  }

  static void Append(Store& store, int count, std::size_t size) {
    std::vector<StoredRecord> records = NextRecords(store, "", 1, count, size);
    for (StoredRecord& record : records) {
      record.world_uid = WorldName(static_cast<int>(record.sequence) % kWorldCount);
    }
    ASSERT_TRUE(store.Append(records, Durability::kDurable).ok());
  }

  // Copies the store, flips a bit and opens the copy.
  absl::StatusOr<Content> OpenWithFlippedBit(const std::string& name, std::int64_t offset,
                                             int bit) {
    const std::string copy = directory_ / "copy";
    fs::remove_all(copy);
    fs::create_directory(copy);
    for (const char* file : {"store.db", "store.db-wal", "head"}) {
      fs::copy_file(fs::path(original_) / file, fs::path(copy) / file);
    }
    FlipBit(absl::StrCat(copy, "/", name), offset, bit);
    absl::StatusOr<std::unique_ptr<Store>> store = OpenSqliteStore(TestOptions(copy));
    if (!store.ok()) return store.status();
    return ReadContent(**store);
  }

  TemporaryDirectory directory_ = TemporaryDirectory(FastFolder());
  std::string original_;
  Content content_;
};

// Counts what came of flipped bits at every `stride`th byte of a file.
struct Outcomes {
  int told = 0;
  int without_effect = 0;
};

class FlippedBits : public DamagedStore, public testing::WithParamInterface<const char*> {};

TEST_P(FlippedBits, AreToldOrHaveNoEffect) {
  const std::string name = GetParam();
  const auto size = static_cast<std::int64_t>(fs::file_size(original_ + "/" + name));
  ASSERT_GT(size, 0);
  // chosen: 1,500 places in each file, every byte of headers.
  const std::int64_t stride = std::max<std::int64_t>(1, size / 1500);
  std::mt19937 random(7);
  Outcomes outcomes;
  for (std::int64_t offset = 0; offset < size; offset += offset < 100 ? 1 : stride) {
    const int bit = static_cast<int>(random() % 8);
    const absl::StatusOr<Content> read = OpenWithFlippedBit(name, offset, bit);
    SCOPED_TRACE(absl::StrCat(name, ", byte ", offset, ", bit ", bit));
    if (read.ok()) {
      ++outcomes.without_effect;
      ASSERT_EQ(*read, content_);
    } else {
      ++outcomes.told;
      const std::string reason = ReasonOf(read.status());
      ASSERT_TRUE(reason == "STORE_DAMAGED" || reason == "STORE_FOREIGN" ||
                  reason == "STORE_NEWER" || reason == "STORE_NOT_WRITABLE")
          << read.status();
    }
  }
  RecordProperty("told", outcomes.told);
  RecordProperty("without_effect", outcomes.without_effect);
  EXPECT_GT(outcomes.told, 0);
}

INSTANTIATE_TEST_SUITE_P(Files, FlippedBits, testing::Values("store.db", "store.db-wal", "head"),
                         [](const auto& info) {
                           std::string name = info.param;
                           std::replace_if(
                               name.begin(), name.end(),
                               [](char c) { return c == '.' || c == '-'; }, '_');
                           return name;
                         });

TEST_F(DamagedStore, TellsAFlippedBitInABlob) {
  const std::string bytes = RandomBytes(500, 4);
  const std::string hash = Sha256Hex(bytes);
  {
    const std::unique_ptr<Store> store = OpenForTest(original_);
    ASSERT_TRUE(store->PutBlob(hash, bytes, Durability::kDurable).ok());
  }
  const std::string file = absl::StrCat(original_, "/blobs/", hash.substr(0, 2), "/", hash);
  for (std::int64_t offset = 0; offset < 500; offset += 7) {
    FlipBit(file, offset, static_cast<int>(offset % 8));
    const std::unique_ptr<Store> store = OpenForTest(original_);
    EXPECT_EQ(ReasonOf(store->GetBlob(hash).status()), "STORE_DAMAGED");
    FlipBit(file, offset, static_cast<int>(offset % 8));
  }
}

// The trap of SQLite's log: what follows a damaged frame is dropped without a word.
TEST_F(DamagedStore, TellsHowManyAcknowledgedRecordsAreMissingAndGoesOnIfAskedTo) {
  fs::resize_file(original_ + "/store.db-wal",
                  fs::file_size(original_ + "/store.db-wal") - 3 * kPageBytes);
  SqliteOptions options = TestOptions(original_);
  const absl::Status status = OpenSqliteStore(options).status();
  EXPECT_EQ(ReasonOf(status), "STORE_DAMAGED");
  EXPECT_THAT(status.message(), HasSubstr("acknowledged records after record"));
  const auto files = FilesOf(original_);
  EXPECT_EQ(ReasonOf(OpenSqliteStore(options).status()), "STORE_DAMAGED");
  EXPECT_EQ(FilesOf(original_), files) << "a refusal changes nothing";

  options.accept_loss = true;
  std::vector<std::string> warnings;
  options.warn = [&](const std::string& text) { warnings.push_back(text); };
  {
    const auto store = OpenSqliteStore(options);
    ASSERT_TRUE(store.ok()) << store.status();
    ASSERT_FALSE(warnings.empty());
    EXPECT_THAT(warnings.back(), HasSubstr("/lost-1"));
    const absl::StatusOr<Content> left = ReadContent(**store);
    ASSERT_TRUE(left.ok());
    ASSERT_LT(left->records.size(), content_.records.size());
    for (std::size_t i = 0; i < left->records.size(); ++i) {
      EXPECT_EQ(left->records[i], content_.records[i]);
    }
    Append(**store, 3, 100);
  }
  EXPECT_EQ(FilesOf(original_)[original_ + "/lost-1/store.db-wal"],
            files.at(original_ + "/store.db-wal"));
  EXPECT_TRUE(OpenForTest(original_)->may_lack_durable()) << "the loss was accepted";
  EXPECT_THAT(CheckStore(original_)->faults, IsEmpty());
}

TEST_F(DamagedStore, NamesThePlaceOnceAndOneRecordAsOne) {
  {
    const std::unique_ptr<Store> store = OpenForTest(original_);
    ASSERT_TRUE(store->Maintain().ok());
  }
  const std::int64_t last = OpenForTest(original_)->last_sequence();
  absl::StatusOr<HeadFile> head = HeadFile::Open(original_ + "/head");
  ASSERT_TRUE(head.ok());
  ASSERT_TRUE(head->Write({.last = last + 1, .durable = last + 1}).ok());
  const std::string message(OpenSqliteStore(TestOptions(original_)).status().message());
  EXPECT_THAT(message, testing::StartsWith(
                           absl::StrCat(original_, ": 1 acknowledged record after record ", last,
                                        " is missing (faults found: 1); restore a backup")));
  ASSERT_TRUE(head->Write({.last = last + 2, .durable = last + 2}).ok());
  EXPECT_THAT(
      std::string(OpenSqliteStore(TestOptions(original_)).status().message()),
      HasSubstr(absl::StrCat("2 acknowledged records after record ", last, " are missing")));
}

TEST_F(DamagedStore, GoesOnWithoutTheRecordsBehindADamagedOneIfAskedTo) {
  { ASSERT_TRUE(OpenForTest(original_)->Close().ok()); }
  const std::string payload = content_.records[8].payload;
  const std::string bytes = FilesOf(original_)[original_ + "/store.db"];
  // Pages that were split keep older copies in their unused parts.
  int copies = 0;
  for (std::size_t place = bytes.find(payload); place != std::string::npos;
       place = bytes.find(payload, place + 1)) {
    FlipBit(original_ + "/store.db", static_cast<std::int64_t>(place) + 50, 2);
    ++copies;
  }
  ASSERT_GT(copies, 0);
  SqliteOptions options = TestOptions(original_);
  const absl::Status status = OpenSqliteStore(options).status();
  EXPECT_THAT(status.message(),
              HasSubstr(absl::StrCat("record ", content_.records[8].sequence, " of world ",
                                     content_.records[8].world_uid)));
  EXPECT_EQ(CheckStore(original_)->fault_count, 1);
  options.accept_loss = true;
  std::vector<StoredRecord> expected;
  for (const StoredRecord& record : content_.records) {
    const bool is_lost = record.sequence >= content_.records[8].sequence &&
                         record.world_uid == content_.records[8].world_uid;
    if (!is_lost) expected.push_back(record);
  }
  for (int i = 0; i < 2; ++i) {
    const auto store = OpenSqliteStore(options);
    ASSERT_TRUE(store.ok()) << store.status();
    EXPECT_EQ(*(*store)->Follow("", 0, kWithoutLimit), expected);
    EXPECT_EQ((*store)->last_sequence(), content_.last_sequence);
    options.accept_loss = false;
  }
  EXPECT_TRUE(fs::exists(original_ + "/lost-1/store.db"));
}

// Damage of SQLite's pages: with the loss accepted, the store goes on with the rest, and nothing
// else is served.
TEST_F(DamagedStore, GoesOnWithTheRowsThatCanBeReadIfAskedTo) {
  { ASSERT_TRUE(OpenForTest(original_)->Close().ok()); }
  const auto size = static_cast<std::int64_t>(fs::file_size(original_ + "/store.db"));
  const auto contains = [this](const StoredRecord& record) {
    return std::find(content_.records.begin(), content_.records.end(), record) !=
           content_.records.end();
  };
  int opened = 0;
  for (std::int64_t page = 1; page < size / kPageBytes; ++page) {
    SCOPED_TRACE(page);
    const std::string copy = directory_ / absl::StrCat("page-", page);
    fs::copy(original_, copy, fs::copy_options::recursive);
    std::fstream file(copy + "/store.db", std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(page * kPageBytes);
    file << RandomBytes(kPageBytes, static_cast<std::uint32_t>(page));
    file.close();
    SqliteOptions options = TestOptions(copy);
    if (OpenSqliteStore(options).ok()) continue;  // a page without use
    options.accept_loss = true;
    const auto store = OpenSqliteStore(options);
    if (!store.ok()) {  // the page that names the others
      EXPECT_EQ(ReasonOf(store.status()), "STORE_DAMAGED") << store.status();
      continue;
    }
    ++opened;
    EXPECT_TRUE(fs::exists(copy + "/lost-1/store.db"));
    const auto records = (*store)->Follow("", 0, kWithoutLimit);
    ASSERT_TRUE(records.ok()) << records.status();
    for (const StoredRecord& record : *records) EXPECT_TRUE(contains(record));
    Append(**store, 2, 100);
    ASSERT_TRUE((*store)->Close().ok());
    EXPECT_NE(OpenForTest(copy), nullptr);
    EXPECT_THAT(CheckStore(copy)->faults, IsEmpty());
  }
  EXPECT_GT(opened, 0);
}

TEST_F(DamagedStore, IsReportedByACheck) {
  EXPECT_THAT(CheckStore(original_)->faults, IsEmpty());
  FlipBit(original_ + "/head", 3, 1);
  const auto report = CheckStore(original_);
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_EQ(report->fault_count, 1);
  EXPECT_THAT(report->faults[0], HasSubstr("/head"));
  EXPECT_FALSE(report->was_closed);
}

}  // namespace
}  // namespace cwm::server
