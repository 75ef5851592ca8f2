#include "clients/cli/backup_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"

namespace cwm::cli {
namespace {

namespace fs = std::filesystem;

bool IsBelow(const fs::path& path) {
  if (path.empty() || path.is_absolute()) return false;
  for (const fs::path& part : path) {
    if (part.empty() || part == "." || part == "..") return false;
  }
  return true;
}

bool Synchronize(const fs::path& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool done = fsync(descriptor) == 0;
  close(descriptor);
  return done;
}

// Unlike rename, it does not replace an empty directory that has come meanwhile, except on file
// systems such as NFS that cannot tell.
bool RenameToNew(const fs::path& from, const fs::path& to) {
  if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return true;
  return errno == EINVAL && rename(from.c_str(), to.c_str()) == 0;
}

fs::path WithoutTrailingSlash(const fs::path& path) {
  return path.has_filename() ? path : path.parent_path();
}

}  // namespace

absl::StatusOr<BackupWriter> BackupWriter::Create(const fs::path& directory) {
  const fs::path named = WithoutTrailingSlash(directory);
  std::error_code ignored;
  if (fs::exists(fs::symlink_status(named, ignored))) {
    return absl::InvalidArgumentError(
        absl::StrCat("DIR: \"", named.string(), "\" exists, must be new"));
  }
  std::string temporary = named.string() + ".XXXXXX";
  if (mkdtemp(temporary.data()) == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat("DIR: \"", named.string(), "\" cannot be made: ", std::strerror(errno)));
  }
  return BackupWriter(named, temporary);
}

BackupWriter::BackupWriter(fs::path directory, fs::path temporary)
    : directory_(std::move(directory)), temporary_(std::move(temporary)) {}

BackupWriter::BackupWriter(BackupWriter&& other) noexcept
    : directory_(std::move(other.directory_)),
      temporary_(std::exchange(other.temporary_, {})),
      file_(std::move(other.file_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      hash_(std::move(other.hash_)),
      file_bytes_(other.file_bytes_),
      received_bytes_(other.received_bytes_),
      received_files_(other.received_files_),
      end_(std::move(other.end_)) {}

BackupWriter::~BackupWriter() {
  if (descriptor_ >= 0) close(descriptor_);
  std::error_code ignored;
  if (!temporary_.empty()) fs::remove_all(temporary_, ignored);
}

absl::Status BackupWriter::Take(const v1::BackUpResponse& piece) {
  if (end_) return absl::DataLossError("the backup goes on after its end");
  switch (piece.part_case()) {
    case v1::BackUpResponse::kFile:
      return BeginFile(piece.file());
    case v1::BackUpResponse::kData:
      return Append(piece.data());
    case v1::BackUpResponse::kEnd:
      return TakeEnd(piece.end());
    case v1::BackUpResponse::PART_NOT_SET:
      break;
  }
  return absl::DataLossError("the backup has a piece that this version does not know");
}

absl::Status BackupWriter::BeginFile(const v1::BackUpFile& file) {
  if (descriptor_ >= 0) {
    return absl::DataLossError(absl::StrCat("\"", file_.path(), "\" has ", file_.size_bytes(),
                                            " bytes, ", file_bytes_, " arrived"));
  }
  if (!IsBelow(file.path()) || file.size_bytes() < 0) {
    return absl::DataLossError(absl::StrCat("\"", file.path(), "\" is no file of a store"));
  }
  file_ = file;
  file_bytes_ = 0;
  hash_ = std::make_unique<Sha256>();
  const fs::path path = temporary_ / file.path();
  std::error_code ignored;  // then the file cannot be opened
  fs::create_directories(path.parent_path(), ignored);
  descriptor_ = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (descriptor_ < 0) return CannotWrite(path);
  return file.size_bytes() == 0 ? EndFile() : absl::OkStatus();
}

absl::Status BackupWriter::Append(const std::string& data) {
  const auto size = static_cast<std::int64_t>(data.size());
  if (descriptor_ < 0 || size > file_.size_bytes() - file_bytes_) {
    return absl::DataLossError(
        absl::StrCat("\"", file_.path(), "\" has more bytes than its ", file_.size_bytes()));
  }
  for (std::size_t written = 0; written < data.size();) {
    const ssize_t count = write(descriptor_, data.data() + written, data.size() - written);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return CannotWrite(temporary_ / file_.path());
    written += static_cast<std::size_t>(count);
  }
  hash_->Add(data.data(), data.size());
  file_bytes_ += size;
  received_bytes_ += size;
  return file_bytes_ == file_.size_bytes() ? EndFile() : absl::OkStatus();
}

absl::Status BackupWriter::EndFile() {
  const std::string hash = hash_->Hex();
  hash_.reset();
  if (hash != file_.sha256()) {
    return absl::DataLossError(absl::StrCat("\"", file_.path(), "\" arrived with the SHA-256 ",
                                            hash, ", must have ", file_.sha256()));
  }
  const bool is_kept = fsync(descriptor_) == 0;
  close(std::exchange(descriptor_, -1));
  if (!is_kept) return CannotWrite(temporary_ / file_.path());
  ++received_files_;
  return absl::OkStatus();
}

absl::Status BackupWriter::TakeEnd(const v1::BackUpEnd& end) {
  if (descriptor_ >= 0 || end.file_count() != received_files_ || end.bytes() != received_bytes_) {
    return absl::DataLossError(absl::StrCat("the backup has ", end.file_count(), " files with ",
                                            end.bytes(), " bytes, ", received_files_, " with ",
                                            received_bytes_, " arrived"));
  }
  end_ = end;
  return absl::OkStatus();
}

absl::StatusOr<v1::BackUpEnd> BackupWriter::Finish() {
  if (!end_) {
    return absl::DataLossError(
        absl::StrCat("the backup has no end; ", received_files_, " files arrived"));
  }
  std::error_code ignored;
  for (const auto& entry : fs::recursive_directory_iterator(temporary_, ignored)) {
    if (entry.is_directory(ignored) && !Synchronize(entry.path())) return CannotWrite(entry.path());
  }
  if (!Synchronize(temporary_)) return CannotWrite(temporary_);
  if (!RenameToNew(temporary_, directory_)) return CannotWrite(directory_);
  temporary_.clear();
  const fs::path parent = directory_.has_parent_path() ? directory_.parent_path() : ".";
  if (!Synchronize(parent)) return CannotWrite(parent);
  return *end_;
}

absl::Status BackupWriter::CannotWrite(const fs::path& path) const {
  const std::string message =
      absl::StrCat("DIR: \"", path.string(), "\" cannot be written: ", std::strerror(errno));
  return errno == ENOSPC ? absl::ResourceExhaustedError(message)
                         : absl::InvalidArgumentError(message);
}

}  // namespace cwm::cli
