// Writes a copy of a server's store, which arrives in pieces, to a new directory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "cwm/v1/admin.pb.h"
#include "proto/transfer/sha256.h"

namespace cwm::cli {

// The directory has a temporary name beside its final one until the copy is complete and on the
// disk. An incomplete copy is removed with its writer.
class BackupWriter {
 public:
  // InvalidArgument if `directory` exists already, or cannot be made.
  static absl::StatusOr<BackupWriter> Create(const std::filesystem::path& directory);
  BackupWriter(BackupWriter&& other) noexcept;
  ~BackupWriter();

  // Writes the next piece. DataLoss if it does not fit to the ones before, and for a file that has
  // another SHA-256 than announced.
  absl::Status Take(const v1::BackUpResponse& piece);
  // Gives the directory its name. DataLoss if the end has not come.
  absl::StatusOr<v1::BackUpEnd> Finish();

  std::int64_t received_bytes() const { return received_bytes_; }
  std::int64_t received_files() const { return received_files_; }

 private:
  BackupWriter(std::filesystem::path directory, std::filesystem::path temporary);

  absl::Status BeginFile(const v1::BackUpFile& file);
  absl::Status Append(const std::string& data);
  absl::Status EndFile();
  absl::Status TakeEnd(const v1::BackUpEnd& end);
  absl::Status CannotWrite(const std::filesystem::path& path) const;

  std::filesystem::path directory_;
  std::filesystem::path temporary_;  // empty: it has its name, or was moved from
  v1::BackUpFile file_;              // being received
  int descriptor_ = -1;              // of file_; -1: there is none
  std::unique_ptr<Sha256> hash_;
  std::int64_t file_bytes_ = 0;  // received of file_
  std::int64_t received_bytes_ = 0, received_files_ = 0;
  std::optional<v1::BackUpEnd> end_;
};

}  // namespace cwm::cli
