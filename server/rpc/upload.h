// Bytes that arrive in chunks, in order, into one buffer that grows as they come.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "server/rpc/runtime.h"
#include "server/wire/field_path.h"

namespace cwm::server {

// Not thread safe. Takes from the runtime's quota of upload bytes what has really arrived, and
// gives it back at its end: a header that promises much costs nothing.
class Upload {
 public:
  Upload(std::int64_t total_bytes, Runtime& runtime)
      : total_bytes_(total_bytes), runtime_(runtime) {}
  ~Upload() { runtime_.upload_bytes.GiveBack(taken_bytes_); }
  Upload(const Upload&) = delete;
  Upload& operator=(const Upload&) = delete;

  // Refuses an empty or too large chunk, one that leaves a gap, comes twice or goes beyond the end.
  absl::Status Append(std::int64_t offset, const std::string& data, const FieldPath& path);
  // An error that says how much is missing.
  absl::Status CheckComplete(const FieldPath& path) const;

  const std::string& bytes() const { return bytes_; }
  std::string Take() { return std::move(bytes_); }

 private:
  const std::int64_t total_bytes_;
  Runtime& runtime_;
  std::string bytes_;
  std::int64_t taken_bytes_ = 0;
};

}  // namespace cwm::server
