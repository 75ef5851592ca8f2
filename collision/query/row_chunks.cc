#include "collision/query/row_chunks.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <utility>

#include "collision/thread_pool/thread_pool.h"

namespace cwm::collision {
namespace {

// The state shared by the threads of one call.
class SharedChunks {
 public:
  SharedChunks(const std::vector<RowChunk>& chunks,
               const std::function<std::unique_ptr<ChunkWorker>()>& make_worker)
      : chunks_(chunks), make_worker_(make_worker), results_(chunks.size()) {}

  // Answers chunks until none is left. After an incomplete chunk no thread takes another one.
  void ProcessRemaining() {
    try {
      TakeChunks();
    } catch (...) {
      next_ = chunks_.size();
      if (!has_failed_.exchange(true)) failure_ = std::current_exception();
    }
  }

  // The result, valid once all threads have ended.
  absl::StatusOr<std::size_t> Result() const {
    if (failure_ != nullptr) std::rethrow_exception(failure_);
    std::size_t completed = 0;
    for (const RowChunk& chunk : chunks_) {
      const ChunkResult& result = results_[chunk.index];
      completed += result.completed;
      if (result.completed == chunk.count) continue;
      if (!result.status.ok()) return result.status;
      break;
    }
    return completed;
  }

 private:
  void TakeChunks() {
    std::unique_ptr<ChunkWorker> worker;
    while (true) {
      const std::size_t at = next_++;
      if (at >= chunks_.size()) return;
      if (worker == nullptr) worker = make_worker_();
      results_[at] = worker->Process(chunks_[at]);
      if (results_[at].completed == chunks_[at].count) continue;
      next_ = chunks_.size();
      return;
    }
  }

  const std::vector<RowChunk>& chunks_;
  const std::function<std::unique_ptr<ChunkWorker>()>& make_worker_;
  std::vector<ChunkResult> results_;  // by chunk; each is written by the thread that took the chunk
  std::atomic<std::size_t> next_ = 0;
  std::atomic<bool> has_failed_ = false;
  std::exception_ptr failure_;  // exception of the first thread that failed, rethrown by Result
};

}  // namespace

std::vector<RowChunk> EqualChunks(std::size_t row_count, std::size_t rows) {
  std::vector<RowChunk> chunks;
  chunks.reserve(row_count / rows + 1);
  for (std::size_t first = 0; first < row_count; first += rows) {
    chunks.push_back({chunks.size(), first, std::min(rows, row_count - first)});
  }
  return chunks;
}

absl::StatusOr<std::size_t> ProcessChunks(
    const std::vector<RowChunk>& chunks, int threads,
    const std::function<std::unique_ptr<ChunkWorker>()>& make_worker) {
  SharedChunks shared(chunks, make_worker);
  const int thread_count =
      std::clamp(threads, 1, static_cast<int>(std::max<std::size_t>(1, chunks.size())));
  ParallelLoop(
      static_cast<std::size_t>(thread_count), 1, [&] { return thread_count; },
      [&](std::size_t, std::size_t) { shared.ProcessRemaining(); })
      .Run();
  return shared.Result();
}

}  // namespace cwm::collision
