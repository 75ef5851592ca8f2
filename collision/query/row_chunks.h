// Splits a batch into chunks for several threads.
//
// The chunks depend only on the batch, each is answered by one thread into its own memory, and they
// are taken in order. The result therefore has the same bytes for any number of threads, and if the
// batch must end early, the rows answered before the first gap are a prefix of the full result.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"

namespace cwm::collision {

struct RowChunk {
  std::size_t index = 0;  // index of the chunk in the batch
  std::size_t first = 0, count = 0;
};

// Splits row_count rows into chunks of `rows` each; the last one may be shorter.
std::vector<RowChunk> EqualChunks(std::size_t row_count, std::size_t rows);

// The progress of a chunk: its first `completed` rows are answered. Fewer than all if the deadline
// was reached or, as `status` says, after an error or a cancellation.
struct ChunkResult {
  std::size_t completed = 0;
  absl::Status status = {};
};

// Answers chunks one after the other; used by one thread. It gets no further chunk after an
// incomplete one.
class ChunkWorker {
 public:
  virtual ~ChunkWorker() = default;
  virtual ChunkResult Process(const RowChunk& chunk) = 0;
};

// Answers the chunks on at most `threads` threads, including the caller's, each with its own
// worker. Returns the number of rows answered from the first one on, or the error of the first
// incomplete chunk if it has one. Fewer threads do the work if the system has no more.
// `make_worker` is called concurrently by all threads. An exception of a thread is rethrown to the
// caller.
absl::StatusOr<std::size_t> ProcessChunks(
    const std::vector<RowChunk>& chunks, int threads,
    const std::function<std::unique_ptr<ChunkWorker>()>& make_worker);

}  // namespace cwm::collision
