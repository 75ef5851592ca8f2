// Bytes that arrive in chunks, in order, into one buffer that grows as they come.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "server/core/memory_budget.h"
#include "server/wire/field_path.h"

namespace cwm::server {

// Not thread safe. Charges what has really arrived, until its end: a header that promises much
// costs nothing.
class Upload {
 public:
  Upload(std::int64_t total_bytes, std::int64_t max_chunk_bytes, MemoryCharge charge)
      : total_bytes_(total_bytes), max_chunk_bytes_(max_chunk_bytes), charge_(std::move(charge)) {}

  // Refuses an empty or too large chunk, one that leaves a gap, comes twice or goes beyond the end;
  // the errors of MemoryBudget::Charge.
  absl::Status Append(std::int64_t offset, const std::string& data, const FieldPath& path);
  // An error that says how much is missing.
  absl::Status CheckComplete(const FieldPath& path) const;

  const std::string& bytes() const { return bytes_; }
  std::string Take() { return std::move(bytes_); }

 private:
  std::size_t NextCapacity() const;

  const std::int64_t total_bytes_;
  const std::int64_t max_chunk_bytes_;
  MemoryCharge charge_;
  std::string bytes_;
};

}  // namespace cwm::server
