#include "server/store/sqlite/blob_files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/core/failpoint.h"
#include "server/store/sqlite/store_files.h"
#include "server/store/store_contract.h"

namespace cwm::server {
namespace {

namespace fs = std::filesystem;
using std::chrono::steady_clock;

constexpr std::string_view kObservedSuffix = ".observed";

std::string TopFolder(const std::string& directory) {
  return absl::StrCat(directory, "/", kBlobFolder);
}

// Creates a folder unless it is there; sets `created` if it was not.
absl::Status MakeFolder(const std::string& path, bool& created) {
  if (mkdir(path.c_str(), 0700) == 0) {
    created = true;
    return absl::OkStatus();
  }
  if (errno == EEXIST) return absl::OkStatus();
  return FileError(path, "cannot be created", errno);
}

absl::Status Rename(const std::string& from, const std::string& to) {
  if (rename(from.c_str(), to.c_str()) == 0) return absl::OkStatus();
  const int error = errno;
  return FileError(from, absl::StrCat("cannot be renamed to ", to), error);
}

}  // namespace

std::string BlobPath(const std::string& hash, bool is_durable) {
  return absl::StrCat(kBlobFolder, "/", hash.substr(0, 2), "/", hash,
                      is_durable ? std::string() : std::string(kObservedSuffix));
}

absl::Status MakeBlobFolder(const std::string& directory) {
  bool created = false;
  absl::Status status = MakeFolder(TopFolder(directory), created);
  if (!status.ok() || !created) return status;
  return SyncFile(directory);
}

absl::Status MakeFolderOf(const std::string& blob_path) {
  bool created = false;
  return MakeFolder(fs::path(blob_path).parent_path().string(), created);
}

absl::StatusOr<std::vector<BlobName>> ListBlobs(const std::string& directory,
                                                bool remove_incomplete) {
  std::vector<BlobName> blobs;
  std::vector<fs::path> incomplete;
  std::error_code error;
  const std::string top = TopFolder(directory);
  for (fs::recursive_directory_iterator it(top, error);
       !error && it != fs::recursive_directory_iterator(); it.increment(error)) {
    std::error_code gone;
    if (it->is_directory(gone)) continue;
    std::string name = it->path().filename().string();
    const bool is_observed = name.ends_with(kObservedSuffix);
    if (is_observed) name.resize(name.size() - kObservedSuffix.size());
    std::string path = BlobPath(name, !is_observed);
    if (!CheckBlobHash(name).ok() || absl::StrCat(directory, "/", path) != it->path().string()) {
      incomplete.push_back(it->path());
      continue;
    }
    const auto size = it->file_size(gone);
    blobs.push_back({std::move(name), std::move(path), gone ? 0 : static_cast<std::int64_t>(size)});
  }
  if (error && error.value() != ENOENT) return FileError(top, "cannot be read", error.value());
  if (remove_incomplete) {
    for (const fs::path& path : incomplete) fs::remove_all(path, error);
  }
  std::sort(blobs.begin(), blobs.end(),
            [](const BlobName& a, const BlobName& b) { return a.path < b.path; });
  return blobs;
}

absl::StatusOr<std::unique_ptr<BlobFiles>> BlobFiles::Open(const std::string& directory) {
  if (absl::Status status = MakeBlobFolder(directory); !status.ok()) return status;
  const absl::StatusOr<std::vector<BlobName>> blobs = ListBlobs(directory, true);
  if (!blobs.ok()) return blobs.status();
  std::unique_ptr<BlobFiles> files(new BlobFiles(directory));
  const steady_clock::time_point now = steady_clock::now();
  for (const BlobName& blob : *blobs) {
    Entry& entry = files->entries_[blob.hash];
    entry.is_there = true;
    entry.is_durable |= blob.path == BlobPath(blob.hash, true);
    entry.size = blob.size;
    entry.last_put = now;  // perhaps: it is not known better
  }
  return files;
}

std::string BlobFiles::FullPath(const std::string& hash, bool is_durable) const {
  return absl::StrCat(directory_, "/", BlobPath(hash, is_durable));
}

absl::Status BlobFiles::Write(const std::string& hash, std::string_view bytes, bool durable) {
  static std::atomic<std::int64_t> count = 0;
  const std::string path = FullPath(hash, durable);
  const std::string temporary = absl::StrCat(path, ".new", ++count);
  if (absl::Status status = MakeFolderOf(path); !status.ok()) return status;
  absl::StatusOr<FileDescriptor> folder = FileDescriptor();
  if (durable) folder = OpenFolderOf(path);
  if (!folder.ok()) return folder.status();
  if (absl::Status status = WriteNewFile(temporary, bytes, durable); !status.ok()) return status;
  if (absl::Status status = Name(temporary, path, *folder); !status.ok()) {
    unlink(temporary.c_str());
    return status;
  }
  // An observed file of the same name was not complete.
  if (durable) unlink(FullPath(hash, false).c_str());
  return absl::OkStatus();
}

absl::Status BlobFiles::MakeDurable(const std::string& hash) {
  const std::string observed = FullPath(hash, false);
  const std::string durable = FullPath(hash, true);
  const absl::StatusOr<FileDescriptor> folder = OpenFolderOf(durable);
  if (!folder.ok()) return folder.status();
  if (absl::Status status = SyncFile(observed); !status.ok()) return status;
  return Name(observed, durable, *folder);
}

absl::StatusOr<FileDescriptor> BlobFiles::OpenFolderOf(const std::string& path) {
  const std::string name = fs::path(path).parent_path().string();
  FileDescriptor folder(open(name.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!folder.is_open()) return OpenError(name, "cannot be opened", errno);
  {
    const std::scoped_lock lock(mutex_);
    if (synced_folders_.contains(name)) return folder;
  }
  if (absl::Status status = SyncFile(TopFolder(directory_)); !status.ok()) return status;
  const std::scoped_lock lock(mutex_);
  synced_folders_.insert(name);
  return folder;
}

absl::Status BlobFiles::Name(const std::string& from, const std::string& to,
                             const FileDescriptor& folder) {
  if (absl::Status status = Rename(from, to); !status.ok()) return status;
  FailPoint("blob-renamed");
  if (!folder.is_open() || fsync(folder.number()) == 0) return absl::OkStatus();
  return FileError(to, "its name cannot be synced", errno);
}

absl::Status BlobFiles::PutAlone(const std::string& hash, std::string_view bytes, bool durable,
                                 Entry& entry) {
  if (entry.is_there && !entry.is_checked) {
    const absl::StatusOr<std::string> found = ReadFile(FullPath(hash, entry.is_durable));
    entry.is_checked = found.ok() && *found == bytes;
    // What a durable record may name is replaced durably.
    durable |= entry.is_durable;
  }
  if (!entry.is_there || !entry.is_checked) {
    if (absl::Status status = Write(hash, bytes, durable); !status.ok()) return status;
    entry.is_durable = durable;
  } else if (durable && !entry.is_durable) {
    if (absl::Status status = MakeDurable(hash); !status.ok()) return status;
    entry.is_durable = true;
  }
  entry.is_there = true;
  entry.is_checked = true;
  entry.size = static_cast<std::int64_t>(bytes.size());
  return absl::OkStatus();
}

absl::Status BlobFiles::Put(const std::string& hash, std::string_view bytes,
                            Durability durability) {
  if (absl::Status status = CheckBlobHash(hash); !status.ok()) return status;
  std::unique_lock lock(mutex_);
  put_ended_.wait(lock, [&] { return !being_put_.contains(hash); });
  being_put_.insert(hash);
  Entry entry = entries_[hash];
  lock.unlock();
  const absl::Status status = PutAlone(hash, bytes, durability == Durability::kDurable, entry);
  lock.lock();
  entry.uses = entries_[hash].uses;  // counted meanwhile
  entry.last_put = steady_clock::now();
  if (status.ok()) {
    entries_[hash] = entry;
  } else if (!entries_[hash].is_there && entry.uses == 0) {
    entries_.erase(hash);
  }
  being_put_.erase(hash);
  put_ended_.notify_all();
  return status;
}

// A blob may become durable, and get another name, while it is opened.
absl::StatusOr<std::string> BlobFiles::Get(const std::string& hash) {
  if (absl::Status status = CheckBlobHash(hash); !status.ok()) return status;
  for (const bool is_durable : {true, false, true}) {
    const std::string path = FullPath(hash, is_durable);
    if (access(path.c_str(), F_OK) != 0) continue;
    absl::StatusOr<std::string> bytes = ReadFile(path);
    if (!bytes.ok()) {
      if (access(path.c_str(), F_OK) != 0) continue;
      return bytes;
    }
    const absl::Status status = CheckBlobBytes(hash, *bytes);
    if (status.ok()) {
      const std::scoped_lock lock(mutex_);
      const auto entry = entries_.find(hash);
      if (entry != entries_.end() && entry->second.is_there) entry->second.is_checked = true;
      return bytes;
    }
    // A power cut leaves parts of what was not synced.
    return is_durable ? status : BlobMissing(hash);
  }
  return BlobMissing(hash);
}

bool BlobFiles::Renew(const std::string& hash, Durability durability) {
  const std::scoped_lock lock(mutex_);
  const auto found = entries_.find(hash);
  if (found == entries_.end()) return false;
  Entry& entry = found->second;
  if (!entry.is_there || !entry.is_checked) return false;
  if (durability == Durability::kDurable && !entry.is_durable) return false;
  entry.last_put = steady_clock::now();
  return true;
}

absl::Status BlobFiles::SyncObserved() {
  std::vector<std::string> observed;
  {
    const std::scoped_lock lock(mutex_);
    for (const auto& [hash, entry] : entries_) {
      if (entry.is_there && !entry.is_durable && entry.is_checked) observed.push_back(hash);
    }
  }
  if (observed.empty()) return absl::OkStatus();
  // One call for all of them; it syncs the rest of the file system as well.
  const FileDescriptor folder(open(directory_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!folder.is_open()) return OpenError(directory_, "cannot be opened", errno);
  if (syncfs(folder.number()) != 0) return FileError(directory_, "cannot be synced", errno);
  // The new names need no sync: under either name the bytes are on the disk.
  const std::scoped_lock lock(mutex_);
  for (const std::string& hash : observed) {
    const auto entry = entries_.find(hash);
    if (entry == entries_.end() || entry->second.is_durable || being_put_.contains(hash)) continue;
    const std::string from = FullPath(hash, false);
    if (access(from.c_str(), F_OK) != 0) continue;  // not lost here: Get tells of it
    absl::Status status = Rename(from, FullPath(hash, true));
    if (!status.ok()) return status;
    entry->second.is_durable = true;
  }
  return absl::OkStatus();
}

void BlobFiles::AddUses(const std::vector<std::string>& hashes) {
  const std::scoped_lock lock(mutex_);
  for (const std::string& hash : hashes) ++entries_[hash].uses;
}

void BlobFiles::DropUses(const std::vector<std::string>& hashes) {
  const std::scoped_lock lock(mutex_);
  for (const std::string& hash : hashes) {
    const auto entry = entries_.find(hash);
    if (entry == entries_.end()) continue;
    if (--entry->second.uses == 0 && !entry->second.is_there && !being_put_.contains(hash)) {
      entries_.erase(entry);
    }
  }
}

bool BlobFiles::HasUnused(steady_clock::duration grace) const {
  const std::scoped_lock lock(mutex_);
  const steady_clock::time_point before = steady_clock::now() - grace;
  return std::any_of(entries_.begin(), entries_.end(), [&](const auto& item) {
    return item.second.uses == 0 && item.second.is_there && item.second.last_put <= before;
  });
}

void BlobFiles::RemoveUnused(steady_clock::duration grace, int count) {
  const std::scoped_lock lock(mutex_);
  const steady_clock::time_point before = steady_clock::now() - grace;
  for (auto it = entries_.begin(); it != entries_.end() && count > 0;) {
    const auto& [hash, entry] = *it;
    if (entry.uses > 0 || !entry.is_there || entry.last_put > before || being_put_.contains(hash)) {
      ++it;
      continue;
    }
    unlink(FullPath(hash, entry.is_durable).c_str());
    it = entries_.erase(it);
    --count;
  }
}

std::vector<BlobName> BlobFiles::Used() const {
  const std::scoped_lock lock(mutex_);
  std::vector<BlobName> used;
  for (const auto& [hash, entry] : entries_) {
    if (entry.uses > 0 && entry.is_there) {
      used.push_back({hash, BlobPath(hash, entry.is_durable), entry.size});
    }
  }
  return used;
}

std::int64_t BlobFiles::count() const {
  const std::scoped_lock lock(mutex_);
  return std::count_if(entries_.begin(), entries_.end(),
                       [](const auto& item) { return item.second.is_there; });
}

std::int64_t BlobFiles::bytes() const {
  const std::scoped_lock lock(mutex_);
  std::int64_t sum = 0;
  for (const auto& [hash, entry] : entries_) sum += entry.is_there ? entry.size : 0;
  return sum;
}

}  // namespace cwm::server
