#include <algorithm>
#include <atomic>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/query/point_sampler.h"
#include "collision/query/query.h"

namespace cwm::collision {
namespace {

struct Chunk {
  std::size_t first, count;
};

// The batch in pieces: small ones first, so that a short time budget completes some, then large ones,
// of which each is put into an order of its own. 16384 points are faster than 8192 and as fast as 32768.
std::vector<Chunk> ChunksOf(std::size_t point_count) {
  constexpr std::size_t kSmallest = 256, kLargest = 16384;
  std::vector<Chunk> chunks;
  std::size_t size = kSmallest;
  for (std::size_t first = 0; first < point_count; first += chunks.back().count) {
    chunks.push_back({first, std::min(size, point_count - first)});
    if (first + chunks.back().count >= 2 * size) size = std::min(2 * size, kLargest);
  }
  return chunks;
}

PointColumns MakeRoom(std::size_t point_count) {
  PointColumns columns;
  columns.state.resize(point_count);
  columns.distance_m.resize(point_count);
  columns.gradient.resize(3 * point_count);
  columns.object.resize(point_count);
  columns.object_part.resize(point_count);
  columns.trust.resize(point_count);
  return columns;
}

void Keep(std::size_t completed, PointColumns& columns) {
  columns.state.resize(completed);
  columns.distance_m.resize(completed);
  columns.gradient.resize(3 * completed);
  columns.object.resize(completed);
  columns.object_part.resize(completed);
  columns.trust.resize(completed);
  std::sort(columns.bounds.begin(), columns.bounds.end(),
            [](const auto& a, const auto& b) { return a.row < b.row; });
  std::erase_if(columns.bounds, [&](const auto& bound) { return bound.row >= completed; });
  columns.completed = completed;
}

// What the threads of one call share. Chunks are taken in order, so those that are done when all
// have ended are a prefix but for the interrupted ones.
struct Batch {
  const WorldSnapshot& world;
  std::span<const Vector3> points;
  const QueryOptions& options;
  std::stop_token stop;
  WorldFilter filter;
  std::vector<Chunk> chunks;
  std::vector<std::uint8_t> done;  // a byte a chunk: threads write side by side
  std::atomic<std::size_t> next = 0;
  PointColumns columns;

  void Work(std::vector<PointColumns::Bound>& bounds) {
    PointSampler sampler(world, filter, options.max_distance_m, {stop, options.give_up_at});
    while (true) {
      const std::size_t at = next++;
      if (at >= chunks.size()) break;
      if (!sampler.Answer(points, chunks[at].first, chunks[at].count, columns)) break;
      done[at] = 1;
    }
    bounds = sampler.bounds();
  }

  void WorkTogether(int most_threads) {
    const auto threads = static_cast<std::size_t>(std::max(1, most_threads));
    std::vector<std::vector<PointColumns::Bound>> bounds(
        std::clamp<std::size_t>(chunks.size(), 1, threads));
    {
      std::vector<std::jthread> others;  // joined at the end of the block
      for (std::size_t i = 1; i < bounds.size(); ++i) {
        others.emplace_back([this, &bounds, i] { Work(bounds[i]); });
      }
      Work(bounds[0]);
    }
    for (const auto& some : bounds) {
      columns.bounds.insert(columns.bounds.end(), some.begin(), some.end());
    }
  }

  std::size_t Completed() const {
    const auto end = std::find(done.begin(), done.end(), 0) - done.begin();
    return end == std::ssize(chunks) ? points.size() : chunks[static_cast<std::size_t>(end)].first;
  }
};

}  // namespace

absl::StatusOr<PointColumns> SamplePoints(const WorldSnapshot& world,
                                          std::span<const Vector3> points,
                                          const QueryOptions& options, std::stop_token stop) {
  if (options.engine != EngineChoice::kAuto && options.engine != EngineChoice::kExact) {
    return absl::UnimplementedError(absl::StrCat("engine ", std::string(NameOf(options.engine)),
                                                 " does not sample points, AUTO and EXACT do"));
  }
  Batch batch{.world = world,
              .points = points,
              .options = options,
              .stop = stop,
              .filter = WorldFilter(world, options),
              .chunks = ChunksOf(points.size()),
              .done = {},
              .columns = MakeRoom(points.size())};
  batch.done.resize(batch.chunks.size());
  batch.WorkTogether(options.threads);
  const std::size_t completed = batch.Completed();
  if (completed < points.size() && stop.stop_requested()) {
    return absl::CancelledError("the question was cancelled");
  }
  Keep(completed, batch.columns);
  return std::move(batch.columns);
}

}  // namespace cwm::collision
