#include "clients/cli/backup_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include "tests/support/process.h"

namespace cwm::cli {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using testing::ScratchDirectory;

v1::BackUpResponse FilePiece(const std::string& path, const std::string& content) {
  v1::BackUpResponse piece;
  piece.mutable_file()->set_path(path);
  piece.mutable_file()->set_size_bytes(static_cast<std::int64_t>(content.size()));
  piece.mutable_file()->set_sha256(Sha256Hex(content));
  return piece;
}

v1::BackUpResponse DataPiece(const std::string& bytes) {
  v1::BackUpResponse piece;
  piece.set_data(bytes);
  return piece;
}

v1::BackUpResponse EndPiece(std::int64_t files, std::int64_t bytes) {
  v1::BackUpResponse piece;
  piece.mutable_end()->set_file_count(files);
  piece.mutable_end()->set_bytes(bytes);
  piece.mutable_end()->set_sequence(7);
  return piece;
}

std::string TextOf(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

// Takes the pieces until one is refused; then tries to finish.
absl::Status Write(BackupWriter& writer, const std::vector<v1::BackUpResponse>& pieces) {
  for (const v1::BackUpResponse& piece : pieces) {
    if (absl::Status taken = writer.Take(piece); !taken.ok()) return taken;
  }
  return writer.Finish().status();
}

class BackupWriterTest : public ::testing::Test {
 protected:
  BackupWriter Create() {
    auto writer = BackupWriter::Create(directory_);
    EXPECT_TRUE(writer.ok()) << writer.status();
    return *std::move(writer);
  }
  bool IsScratchEmpty() const { return fs::is_empty(scratch_.path()); }
  void ExpectRefused(const std::vector<v1::BackUpResponse>& pieces, const std::string& why) {
    {
      BackupWriter writer = Create();
      const absl::Status status = Write(writer, pieces);
      EXPECT_TRUE(absl::IsDataLoss(status)) << status;
      EXPECT_THAT(std::string(status.message()), HasSubstr(why));
    }
    EXPECT_TRUE(IsScratchEmpty()) << "an incomplete copy must not stay";
  }

  ScratchDirectory scratch_;
  fs::path directory_ = scratch_ / "copy";
};

TEST_F(BackupWriterTest, WritesAllFilesUnderTheirNames) {
  BackupWriter writer = Create();
  const absl::Status status =
      Write(writer, {FilePiece("store.db", "database"), DataPiece("data"), DataPiece("base"),
                     FilePiece("head", ""), FilePiece("blobs/ab/abcd", "blob"), DataPiece("blob"),
                     EndPiece(3, 12)});
  ASSERT_TRUE(status.ok()) << status;
  EXPECT_EQ(TextOf(directory_ / "store.db"), "database");
  EXPECT_EQ(TextOf(directory_ / "head"), "");
  EXPECT_EQ(TextOf(directory_ / "blobs/ab/abcd"), "blob");
}

TEST_F(BackupWriterTest, DirectoryHasItsNameOnlyWhenComplete) {
  BackupWriter writer = Create();
  ASSERT_TRUE(writer.Take(FilePiece("store.db", "")).ok());
  ASSERT_TRUE(writer.Take(EndPiece(1, 0)).ok());
  EXPECT_FALSE(fs::exists(directory_));
  ASSERT_TRUE(writer.Finish().ok());
  EXPECT_TRUE(fs::exists(directory_));
}

TEST_F(BackupWriterTest, RefusesADirectoryThatExists) {
  fs::create_directory(directory_);
  const auto refused = BackupWriter::Create(directory_.string() + "/");
  EXPECT_TRUE(absl::IsInvalidArgument(refused.status()));
  EXPECT_THAT(std::string(refused.status().message()), HasSubstr("exists, must be new"));
}

TEST_F(BackupWriterTest, KeepsADirectoryThatHasComeMeanwhile) {
  BackupWriter writer = Create();
  fs::create_directory(directory_);
  EXPECT_FALSE(Write(writer, {FilePiece("store.db", ""), EndPiece(1, 0)}).ok());
  EXPECT_TRUE(fs::is_empty(directory_));
}

TEST_F(BackupWriterTest, RefusesChangedBytes) {
  ExpectRefused({FilePiece("store.db", "database"), DataPiece("databasf")}, "SHA-256");
}

TEST_F(BackupWriterTest, RefusesMissingAndSurplusBytes) {
  ExpectRefused({FilePiece("store.db", "database"), DataPiece("data"), FilePiece("head", "")},
                "has 8 bytes, 4 arrived");
  ExpectRefused({FilePiece("store.db", "data"), DataPiece("database")}, "more bytes than its 4");
  ExpectRefused({DataPiece("data")}, "more bytes");
}

TEST_F(BackupWriterTest, RefusesACopyWithoutItsEndOrWithAnotherOne) {
  ExpectRefused({FilePiece("store.db", "")}, "no end");
  ExpectRefused({FilePiece("store.db", ""), EndPiece(2, 0)}, "2 files");
  ExpectRefused({FilePiece("store.db", ""), EndPiece(1, 0), FilePiece("head", "")},
                "goes on after its end");
}

TEST_F(BackupWriterTest, WritesNoFileOutsideOfTheDirectory) {
  for (const char* path : {"../head", "/tmp/head", "a/../../head", "", "."}) {
    SCOPED_TRACE(path);
    ExpectRefused({FilePiece(path, "")}, "is no file of a store");
  }
}

}  // namespace
}  // namespace cwm::cli
