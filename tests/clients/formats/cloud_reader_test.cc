#include "clients/formats/cloud_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "clients/formats/file_bytes.h"

namespace cwm::formats {
namespace {

using ::testing::HasSubstr;

std::string Scratch(const std::string& name) { return ::testing::TempDir() + "cwm_" + name; }

TEST(ReadCloud, TellsFormatsApartByTheirContent) {
  const std::string path = Scratch("really_a_ply.pcd");
  ASSERT_TRUE(WriteFileBytes(path,
                             "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                             "property float y\nproperty float z\nend_header\n1 2 3\n")
                  .ok());
  const auto cloud = ReadCloud(path);
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_EQ(cloud->size(), 1);
  std::filesystem::remove(path);
}

TEST(ReadCloud, NamesWhatItCannotRead) {
  EXPECT_EQ(ReadCloud(Scratch("absent.pcd")).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(ReadCloud(::testing::TempDir()).status().message()),
              HasSubstr("not a regular file"));
  const std::string path = Scratch("text.pcd");
  ASSERT_TRUE(WriteFileBytes(path, "hello").ok());
  EXPECT_THAT(std::string(ReadCloud(path).status().message()),
              HasSubstr("first line is hello, must be that of a PCD"));
  ASSERT_TRUE(WriteFileBytes(path,
                             "VERSION 0.7\nFIELDS x y\nSIZE 4 4\nTYPE F F\nWIDTH 0\nHEIGHT 1\n"
                             "DATA ascii\n")
                  .ok());
  EXPECT_THAT(std::string(ReadCloud(path).status().message()), HasSubstr("field z is missing"));
  std::filesystem::remove(path);
}

TEST(WriteFileBytes, ReplacesTheFileAndNamesAFolderThatIsNotThere) {
  const std::string path = Scratch("bytes");
  ASSERT_TRUE(WriteFileBytes(path, "first").ok());
  ASSERT_TRUE(WriteFileBytes(path, "second").ok());
  EXPECT_EQ(*ReadFileBytes(path), "second");
  EXPECT_FALSE(ReadFileBytes(path, 5).ok());
  std::filesystem::remove(path);
  const auto status = WriteFileBytes(Scratch("no_such_folder/file"), "x");
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("no_such_folder/file"));
}

}  // namespace
}  // namespace cwm::formats
