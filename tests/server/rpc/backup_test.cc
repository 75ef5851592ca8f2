// AdminService.BackUp over a socket, of a store whose copy is a folder of files.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "proto/transfer/sha256.h"
#include "server/core/error.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

namespace fs = std::filesystem;

// A copy of a store in a folder of its own, which goes with it.
class FolderBackup final : public Backup {
 public:
  explicit FolderBackup(const std::map<std::string, std::string>& contents) {
    for (const auto& [path, content] : contents) {
      const std::string source = scratch_ / path;
      fs::create_directories(fs::path(source).parent_path());
      std::ofstream(source, std::ios::binary) << content;
      files_.push_back({path, source});
    }
  }
  const std::vector<BackupFile>& files() const override { return files_; }
  std::int64_t sequence() const override { return 42; }
  std::string folder() const { return scratch_.path(); }

 private:
  testing::ScratchDirectory scratch_;
  std::vector<BackupFile> files_;
};

// Hands its copies over when the test says so.
class HeldStore final : public StoreAdmin {
 public:
  StoreInfo info() const override { return {.sequence = 42, .epoch = 3, .refuses_writes = "full"}; }
  void StartBackup(BackupDone done) override {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(done));
    asked_.notify_all();
  }
  // Waits until a client has asked for a copy; false if none does within the time.
  bool WaitUntilAsked(std::chrono::milliseconds time = std::chrono::seconds(30)) {
    std::unique_lock lock(mutex_);
    return asked_.wait_for(lock, time, [this] { return !waiting_.empty(); });
  }
  void HandOver(const absl::StatusOr<std::shared_ptr<const Backup>>& backup) {
    ASSERT_TRUE(WaitUntilAsked());
    {
      const std::lock_guard lock(mutex_);
      called_ = std::move(waiting_.front());
      waiting_.pop_front();
    }
    called_(backup);
  }

 private:
  std::mutex mutex_;
  std::condition_variable asked_;
  std::deque<BackupDone> waiting_;
  BackupDone called_;  // kept, as a store may do
};

class BackupTest : public RunningServer {
 protected:
  BackupTest() {
    application_.store = "sqlite:/somewhere";
    application_.store_admin = &store_;
  }
  ~BackupTest() override { server_->Stop(std::chrono::milliseconds(0)); }

  HeldStore store_;
};

struct Received {
  std::map<std::string, std::string> contents;
  v1::BackUpEnd end;
  std::int64_t largest_piece = 0;
};

Received ReadAll(grpc::ClientReader<v1::BackUpResponse>& reader) {
  Received received;
  v1::BackUpResponse piece;
  v1::BackUpFile file;
  const auto check_file = [&] {
    const std::string& content = received.contents[file.path()];
    EXPECT_EQ(file.size_bytes(), static_cast<std::int64_t>(content.size())) << file.path();
    EXPECT_EQ(file.sha256(), Sha256Hex(content)) << file.path();
  };
  while (reader.Read(&piece)) {
    const bool is_data = piece.has_data();
    if (!is_data && !file.path().empty()) check_file();
    if (piece.has_file()) {
      file = piece.file();
      received.contents[file.path()];
    }
    if (piece.has_end()) received.end = piece.end();
    if (!is_data) continue;
    received.contents[file.path()] += piece.data();
    received.largest_piece =
        std::max(received.largest_piece, static_cast<std::int64_t>(piece.data().size()));
  }
  return received;
}

// Calls that were cancelled end just after their clients have the status.
void ExpectGone(const std::string& folder) {
  for (int i = 0; i < 10'000 && fs::exists(folder); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_FALSE(fs::exists(folder));
}

std::string Bytes(std::size_t count) {
  std::string bytes(count, '\0');
  for (std::size_t i = 0; i < count; ++i) bytes[i] = static_cast<char>(i * i >> 3);
  return bytes;
}

TEST_F(BackupTest, SendsEveryFileWithItsHashAndThenTheEnd) {
  const std::map<std::string, std::string> contents = {
      {"blobs/ab/abcd", "a mesh"},
      {"empty", ""},
      {"head", "0123456789abcdef"},
      {"store.db", Bytes((17 << 20) + 3)}};  // more than one step hashes
  Call call;
  const auto reader = admin_->BackUp(&call, {});
  auto backup = std::make_shared<FolderBackup>(contents);
  const std::string folder = backup->folder();
  store_.HandOver(std::shared_ptr<const Backup>(std::move(backup)));
  const Received received = ReadAll(*reader);
  ASSERT_TRUE(reader->Finish().ok());
  EXPECT_EQ(received.contents, contents);
  EXPECT_EQ(received.end.file_count(), 4);
  EXPECT_EQ(received.end.bytes(), (17 << 20) + 3 + 6 + 16);
  EXPECT_EQ(received.end.sequence(), 42);
  EXPECT_LE(received.largest_piece, kMaxChunkBytes);
  EXPECT_FALSE(fs::exists(folder));
}

TEST_F(BackupTest, IsTakenOneAtATime) {
  Call first_call;
  const auto first = admin_->BackUp(&first_call, {});
  ASSERT_TRUE(store_.WaitUntilAsked());
  Call second_call;
  const auto second = admin_->BackUp(&second_call, {});
  v1::BackUpResponse piece;
  EXPECT_FALSE(second->Read(&piece));
  const grpc::Status refused = second->Finish();
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(ReasonIn(refused), "BACKUP_UNDER_WAY");
  EXPECT_TRUE(DetailsIn(refused).has_retry);
  const std::map<std::string, std::string> nothing;
  store_.HandOver(std::make_shared<FolderBackup>(nothing));
  ReadAll(*first);
  EXPECT_TRUE(first->Finish().ok());
  Call third_call;
  const auto third = admin_->BackUp(&third_call, {});
  EXPECT_TRUE(store_.WaitUntilAsked()) << "the first one has ended";
  third_call.TryCancel();
  third->Finish();
}

TEST_F(BackupTest, TellsWhyTheStoreCannotBeCopied) {
  Call call;
  const auto reader = admin_->BackUp(&call, {});
  store_.HandOver(Overloaded("no room for a copy", "DISK_FULL", 1));
  v1::BackUpResponse piece;
  EXPECT_FALSE(reader->Read(&piece));
  EXPECT_EQ(ReasonIn(reader->Finish()), "DISK_FULL");
}

TEST_F(BackupTest, EndsWithAServerThatDrainsThoughTheStoreNeverAnswers) {
  Call call;
  const auto reader = admin_->BackUp(&call, {});
  ASSERT_TRUE(store_.WaitUntilAsked());
  const auto begun = Clock::now();
  server_->Stop(std::chrono::seconds(20));
  EXPECT_LT(Clock::now() - begun, std::chrono::seconds(10));
  v1::BackUpResponse piece;
  EXPECT_FALSE(reader->Read(&piece));
  EXPECT_EQ(ReasonIn(reader->Finish()), "SERVER_DRAINING");
}

TEST_F(BackupTest, EndsWithAClientThatCancelsWhileTheStoreMakesItsCopy) {
  Call call;
  const auto reader = admin_->BackUp(&call, {});
  ASSERT_TRUE(store_.WaitUntilAsked());
  call.TryCancel();
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::CANCELLED);
  // A copy that comes later is dropped.
  const std::map<std::string, std::string> contents = {{"head", "x"}};
  auto late = std::make_shared<FolderBackup>(contents);
  const std::string folder = late->folder();
  store_.HandOver(std::shared_ptr<const Backup>(std::move(late)));
  ExpectGone(folder);
}

TEST_F(BackupTest, ServerInfoDescribesTheStore) {
  Call call;
  v1::GetServerInfoResponse info;
  ASSERT_TRUE(admin_->GetServerInfo(&call, {}, &info).ok());
  EXPECT_EQ(info.store(), "sqlite:/somewhere");
  EXPECT_EQ(info.store_info().sequence(), 42);
  EXPECT_EQ(info.store_info().epoch(), 3);
  EXPECT_EQ(info.store_info().replayed(), 1);
  EXPECT_EQ(info.store_info().refuses_writes(), "full");
}

class MemoryBackupTest : public RunningServer {};

TEST_F(MemoryBackupTest, IsRefusedAndServerInfoSaysMemory) {
  Call call;
  const auto reader = admin_->BackUp(&call, {});
  v1::BackUpResponse piece;
  EXPECT_FALSE(reader->Read(&piece));
  const grpc::Status status = reader->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(ReasonIn(status), "STORE_IN_MEMORY");
  Call info_call;
  v1::GetServerInfoResponse info;
  ASSERT_TRUE(admin_->GetServerInfo(&info_call, {}, &info).ok());
  EXPECT_EQ(info.store(), "memory");
  EXPECT_FALSE(info.has_store_info());
}

}  // namespace
}  // namespace cwm::server
