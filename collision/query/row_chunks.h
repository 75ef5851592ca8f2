// A batch in chunks, which several threads may take.
//
// Chunks are made of the batch alone, each is answered by one thread into a place of its own, and
// they are taken in their order: the same bytes on any number of threads, and whenever the batch
// must end early, what is answered up to the first chunk that is not whole is a prefix of the full
// answer.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"

namespace cwm::collision {

struct RowChunk {
  std::size_t index = 0;  // among the chunks
  std::size_t first = 0, count = 0;
};

// Chunks of `rows` each, the last of what is left.
std::vector<RowChunk> EqualChunks(std::size_t row_count, std::size_t rows);

// How far a chunk came: its first `completed` rows. Fewer than all when its time was up or, as
// `status` says, at an error or a cancellation.
struct ChunkEnd {
  std::size_t completed = 0;
  absl::Status status = {};
};

// Answers chunks, one after the other; used by one thread. After one that is not whole it is asked
// no more.
class ChunkWorker {
 public:
  virtual ~ChunkWorker() = default;
  virtual ChunkEnd Answer(const RowChunk& chunk) = 0;
};

// Answers the chunks on at most `threads` threads, the caller's included, each with a worker of its
// own, and returns how many rows from the first on are answered: all, or what time sufficed for;
// the error of the first chunk that is not whole, if it has one. Where the
// system has no threads to give, fewer do the work. `make_worker` is called by all of them at once.
// An exception of theirs is the caller's.
absl::StatusOr<std::size_t> AnswerTogether(
    const std::vector<RowChunk>& chunks, int threads,
    const std::function<std::unique_ptr<ChunkWorker>()>& make_worker);

}  // namespace cwm::collision
