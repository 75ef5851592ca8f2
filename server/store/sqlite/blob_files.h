// Blobs as files by hash: blobs/ab/abcd..., and abcd....observed while they are not synced. The
// name tells after a power cut which of them may be incomplete.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/core/file_descriptor.h"
#include "server/core/journal.h"

namespace cwm::server {

// The path of a blob relative to the store's directory.
std::string BlobPath(const std::string& hash, bool is_durable);

struct BlobName {
  std::string hash;
  std::string path;  // relative to the store's directory
  std::int64_t size = 0;
};
// All blobs of a store's directory in the order of their hashes. Removes files that are not
// complete if asked to.
absl::StatusOr<std::vector<BlobName>> ListBlobs(const std::string& directory,
                                                bool remove_incomplete);
// Makes the folder of all blobs, durably.
absl::Status MakeBlobFolder(const std::string& directory);
// Makes the folder in which the path of a blob lies, if there is none.
absl::Status MakeFolderOf(const std::string& blob_path);

// Thread safe.
class BlobFiles {
 public:
  static absl::StatusOr<std::unique_ptr<BlobFiles>> Open(const std::string& directory);

  // As Store::PutBlob and Store::GetBlob.
  absl::Status Put(const std::string& hash, std::string_view bytes, Durability durability);
  absl::StatusOr<std::string> Get(const std::string& hash);

  // True if the blob is kept as asked for already: then this counts as another Put.
  bool Renew(const std::string& hash, Durability durability);

  // Syncs the blobs that are not synced yet; from then on they are durable.
  absl::Status SyncObserved();

  // Counts the records and snapshots that name a blob.
  void AddUses(const std::vector<std::string>& hashes);
  void DropUses(const std::vector<std::string>& hashes);
  // True if there are blobs without uses that were not put during the last `grace`.
  bool HasUnused(std::chrono::steady_clock::duration grace) const;
  // Removes at most `count` of them. What dropped their uses must be on the disk.
  void RemoveUnused(std::chrono::steady_clock::duration grace, int count);

  // The blobs with uses that are there.
  std::vector<BlobName> Used() const;
  std::int64_t count() const;
  std::int64_t bytes() const;

 private:
  struct Entry {
    bool is_there = false;
    bool is_durable = false;
    bool is_checked = false;  // put by this process, or read and found whole
    std::int64_t size = 0;
    int uses = 0;
    std::chrono::steady_clock::time_point last_put = {};
  };

  explicit BlobFiles(std::string directory) : directory_(std::move(directory)) {}
  std::string FullPath(const std::string& hash, bool is_durable) const;
  absl::Status Write(const std::string& hash, std::string_view bytes, bool durable);
  absl::Status MakeDurable(const std::string& hash);
  // Opens the folder of a blob's file, whose own name is on the disk then. What could fail for want
  // of descriptors precedes the renaming.
  absl::StatusOr<FileDescriptor> OpenFolderOf(const std::string& path);
  // Gives a file its name, durably if there is a folder to sync.
  absl::Status Name(const std::string& from, const std::string& to, const FileDescriptor& folder);
  absl::Status PutAlone(const std::string& hash, std::string_view bytes, bool durable,
                        Entry& entry);

  const std::string directory_;
  mutable std::mutex mutex_;
  std::condition_variable put_ended_;
  std::set<std::string> being_put_;  // at most one thread puts a blob
  std::map<std::string, Entry> entries_;
  std::set<std::string> synced_folders_;  // their names are on the disk
};

}  // namespace cwm::server
