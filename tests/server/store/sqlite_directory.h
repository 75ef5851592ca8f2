// Directories of stores on SQLite in tests: opened, copied, damaged.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>

#include "server/store/sqlite/sqlite_store.h"

namespace cwm::server {

inline SqliteOptions TestOptions(const std::string& path) {
  SqliteOptions options;
  options.path = path;
  options.ballast_bytes = 0;
  options.low_water_bytes = 0;
  return options;
}

inline std::unique_ptr<Store> OpenForTest(const std::string& path) {
  absl::StatusOr<std::unique_ptr<Store>> store = OpenSqliteStore(TestOptions(path));
  EXPECT_TRUE(store.ok()) << store.status();
  return store.ok() ? *std::move(store) : nullptr;
}

// The files of a folder and below, with their bytes.
inline std::map<std::string, std::string> FilesOf(const std::string& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream in(entry.path(), std::ios::binary);
    files[entry.path().string()] = std::string(std::istreambuf_iterator<char>(in), {});
  }
  return files;
}

inline void FlipBit(const std::string& file, std::int64_t offset, int bit) {
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  stream.seekg(offset);
  const int byte = stream.get();
  ASSERT_GE(byte, 0) << file << " has no byte " << offset;
  stream.seekp(offset);
  stream.put(static_cast<char>(byte ^ (1 << bit)));
}

}  // namespace cwm::server
