// Bytes that arrive in chunks, in order, in one buffer that grows with them.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "server/core/memory_budget.h"
#include "server/wire/field_path.h"

namespace cwm::server {

// Not thread safe. Charges only bytes that have arrived, until the destructor: a header that
// announces much costs nothing.
class Upload {
 public:
  Upload(std::int64_t total_bytes, std::int64_t max_chunk_bytes, MemoryCharge charge)
      : total_bytes_(total_bytes), max_chunk_bytes_(max_chunk_bytes), charge_(std::move(charge)) {}

  // Refuses a chunk that is empty, too large, repeated, leaves a gap or goes beyond the end; the
  // errors of MemoryBudget::Charge.
  absl::Status Append(std::int64_t offset, const std::string& data, const FieldPath& path);
  // OK if all bytes have arrived, else an error that says how many are missing.
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
