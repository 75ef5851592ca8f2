#include "clients/formats/cloud_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <random>

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

TEST(ParseCloud, TellsPointsInTextFromOtherText) {
  EXPECT_EQ(DetectCloudFormat("# made by hand\n0.1, 0.2, 0.3\n"), CloudFormat::kXyz);
  EXPECT_EQ(DetectCloudFormat("# .PCD v0.7\n"), CloudFormat::kPcd);
  EXPECT_EQ(DetectCloudFormat("\x93NUMPY\x01"), CloudFormat::kNpy);
  EXPECT_EQ(DetectCloudFormat("ply\n"), CloudFormat::kPly);
  EXPECT_EQ(DetectCloudFormat("name: shelf\n"), std::nullopt);
  EXPECT_EQ(ParseCloud("1 2 3\n", "a.pcd")->size(), 1);
}

TEST(ParseCloud, SkipsTheMarkOfUtf8) {
  const std::string mark = "\xEF\xBB\xBF";
  EXPECT_EQ(ParseCloud(mark + "1 2 3\n", "a.xyz")->size(), 1);
  EXPECT_EQ(ParseCloud(mark + "# .PCD v.7\nVERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n"
                              "WIDTH 1\nHEIGHT 1\nDATA ascii\n1 2 3\n",
                       "a.pcd")
                ->size(),
            1);
}

// The version is missing from PCDs of many programs; the first line names the format.
TEST(ParseCloud, ReadsAPcdWithoutVersion) {
  const auto cloud = ParseCloud(
      "# .PCD v.7 - Point Cloud Data file format\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n"
      "WIDTH 1\nHEIGHT 1\nDATA ascii\n1 2 3\n",
      "a.pcd");
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_EQ(cloud->size(), 1);
}

TEST(ParseCloud, SaysWhatAFileIsThatIsNoCloud) {
  const auto refusal = [](const std::string& bytes) {
    return std::string(ParseCloud(bytes, "file").status().message());
  };
  EXPECT_THAT(refusal("PK\x03\x04 ..."), HasSubstr("zip archive or .npz"));
  EXPECT_THAT(refusal("# Octomap OcTree binary file\nid OcTree\nsize 5\n"), HasSubstr("OctoMap"));
  EXPECT_THAT(refusal("\n<!DOCTYPE html>\n<html>"), HasSubstr("web page"));
  EXPECT_THAT(refusal("\x89PNG\r\n"), HasSubstr("is an image: a depth image needs"));
}

// Any input gives a cloud whose bytes match its points, or an error.
TEST(ParseCloud, ReadsOrRefusesFilesWithBytesChangedAtRandom) {
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
      "property float z\nend_header\n1 2 3\n4 5 6\n";
  const std::string pcd =
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nHEIGHT 1\nDATA ascii\n1 2 3\n4 "
      "5 "
      "6\n";
  const std::string dictionary =
      "{'descr': [('x', '<f4'), ('', '|V1'), ('y', '>i2'), ('z', '|i1', (1,))], "
      "'fortran_order': False, 'shape': (1, 2), }\n";
  std::string npy = "\x93NUMPY";
  npy += {'\1', '\0', static_cast<char>(dictionary.size()), '\0'};
  npy += dictionary + std::string(16, 'a');
  std::mt19937 random(11);
  for (const std::string& bytes : {ply, pcd, npy, std::string("x,y,z,nx\n1,2,3,4\n5,6,7,8\n")}) {
    ASSERT_TRUE(ParseCloud(bytes, "whole").ok()) << ParseCloud(bytes, "whole").status();
    for (int round = 0; round < 3000; ++round) {
      std::string changed = bytes;
      for (int i = 0; i < 1 + round % 4; ++i) {
        changed[random() % changed.size()] = static_cast<char>(random() % 256);
      }
      if (round % 10 == 0) changed.resize(random() % changed.size());
      const auto cloud = ParseCloud(changed, "changed");
      if (cloud.ok()) {
        ASSERT_EQ(cloud->bytes.size(), static_cast<std::size_t>(cloud->size()) * cloud->point_step);
      } else {
        ASSERT_THAT(std::string(cloud.status().message()), ::testing::StartsWith("changed: "));
      }
    }
  }
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
