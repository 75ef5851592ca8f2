// Records, blobs and temporary directories for tests of stores.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "proto/transfer/sha256.h"
#include "server/core/error.h"
#include "server/store/store.h"

namespace cwm::server {

inline bool operator==(const StoredRecord& a, const StoredRecord& b) {
  return a.sequence == b.sequence && a.epoch == b.epoch && a.world_uid == b.world_uid &&
         a.revision == b.revision && a.payload == b.payload && a.blobs == b.blobs;
}
inline bool operator==(const StoredSnapshot& a, const StoredSnapshot& b) {
  return a.sequence == b.sequence && a.world_uid == b.world_uid && a.revision == b.revision &&
         a.payload == b.payload && a.blobs == b.blobs;
}
inline void PrintTo(const StoredRecord& record, std::ostream* out) {
  *out << "record " << record.sequence << " of " << record.world_uid << ", epoch " << record.epoch
       << ", revision " << record.revision << ", " << record.payload.size() << " bytes, "
       << record.blobs.size() << " blobs";
}

// Where syncs cost nothing, for tests that no power cut is part of: what a killed process wrote
// survives in memory alike.
inline std::filesystem::path FastFolder() {
  const std::filesystem::path shared_memory = "/dev/shm";
  return access(shared_memory.c_str(), W_OK) == 0 ? shared_memory
                                                  : std::filesystem::temp_directory_path();
}

// A directory that is removed with what is in it.
class TemporaryDirectory {
 public:
  explicit TemporaryDirectory(
      const std::filesystem::path& parent = std::filesystem::temp_directory_path()) {
    std::string pattern = (parent / "cwm_store_XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) ADD_FAILURE() << "cannot create " << pattern;
    path_ = pattern;
  }
  ~TemporaryDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

inline std::string RandomBytes(std::size_t size, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::string bytes(size, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random());
  return bytes;
}

// The next records of a world, behind the newest one of the store.
inline std::vector<StoredRecord> NextRecords(const Store& store, const std::string& world,
                                             std::int64_t first_revision, int count,
                                             std::size_t payload_size = 300) {
  std::vector<StoredRecord> records;
  for (int i = 0; i < count; ++i) {
    const std::int64_t sequence = store.last_sequence() + 1 + i;
    records.push_back({.sequence = sequence,
                       .epoch = store.epoch(),
                       .world_uid = world,
                       .revision = first_revision + i,
                       .payload = RandomBytes(payload_size, static_cast<std::uint32_t>(sequence))});
  }
  return records;
}

inline std::string ReasonOf(const absl::Status& status) { return DetailsOf(status).reason; }

inline constexpr std::int64_t kWithoutLimit = std::int64_t{1} << 40;

}  // namespace cwm::server
