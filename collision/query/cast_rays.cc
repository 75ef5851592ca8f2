#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/engines/exact_engine.h"
#include "collision/query/hidden_spaces.h"
#include "collision/query/interrupt.h"
#include "collision/query/object_ranks.h"
#include "collision/query/query.h"
#include "collision/query/row_chunks.h"
#include "collision/query/world_filter.h"

namespace cwm::collision {
namespace {

struct NearestHit {
  RayHit hit;
  const Obstacle* object = nullptr;
  std::int32_t part = -1;
};

// Keeps the nearest hit of the ray with the parts of one object; equally near ones go to the object
// that comes first by name, then to the first part.
void HitObject(const Obstacle& object, const WorldFilter& filter, const RayRow& ray,
               Interrupt& interrupt, std::optional<NearestHit>& nearest) {
  const SlabRay slabs(ray.origin, ray.direction);
  for (std::size_t k = 0; k < object.parts_W.size(); ++k) {
    const PreparedPart& part = object.geometry->parts[k];
    const PlacedPart& placed = object.parts_W[k];
    if (filter.SkipsPart(object, k)) continue;
    const double limit_m = nearest.has_value() ? nearest->hit.distance_m : ray.max_distance_m;
    const double entry_m = slabs.Entry_m(placed.bounds_W);
    if (entry_m > limit_m || std::isinf(entry_m)) continue;
    const auto hit = CastRay(*part.engines[static_cast<int>(EngineKind::kExact)], placed.X_WP,
                             {ray.origin, ray.direction, limit_m}, &interrupt);
    if (interrupt.CountWork(1)) return;
    if (!hit.has_value() || hit->distance_m > limit_m) continue;
    const bool nearer = !nearest.has_value() || hit->distance_m < nearest->hit.distance_m ||
                        Precedes(object, *nearest->object);
    if (nearer) nearest = {.hit = *hit, .object = &object, .part = static_cast<std::int32_t>(k)};
  }
}

// chosen: a ray takes a few microseconds.
constexpr std::size_t kRaysPerChunk = 1024;

void Resize(std::size_t rays, RayColumns& columns) {
  columns.hit.resize(rays);
  columns.distance_m.resize(rays);
  columns.normal.resize(3 * rays);
  columns.object.resize(rays);
  columns.object_part.resize(rays);
  columns.accuracy.resize(rays, Accuracy::kExact);
}

// The query and its result.
struct RayBatch {
  const WorldSnapshot& world;
  std::span<const RayRow> rays;
  const QueryOptions& options;
  std::stop_token stop;
  TimeLimit limit;
  WorldFilter filter;
  std::vector<HiddenSpace> hidden;
  RayColumns columns;
};

class Caster : public ChunkWorker {
 public:
  explicit Caster(RayBatch& batch)
      : batch_(batch), interrupt_(batch.stop, batch.limit), ranks_(batch.world) {}

  ChunkResult Process(const RowChunk& chunk) override {
    std::size_t k = 0;
    for (; k < chunk.count && !interrupt_.CountWork(1); ++k) {
      const std::optional<NearestHit> nearest = Cast(batch_.rays[chunk.first + k]);
      if (has_ended()) break;
      if (nearest.has_value()) Write(chunk.first + k, *nearest);
      const RayRow& ray = batch_.rays[chunk.first + k];
      if (PassesHidden(ray, nearest) || MayMeetCaps(ray, nearest)) {
        batch_.columns.accuracy[chunk.first + k] = Accuracy::kBounded;
      }
    }
    batch_.limit.Count(k);
    if (interrupt_.reason() != Interrupt::Reason::kStopped) return {k};
    return {k, absl::CancelledError("the question was cancelled")};
  }

 private:
  bool has_ended() const { return interrupt_.reason() != Interrupt::Reason::kNone; }

  // The nearest hit of a ray; void if interrupted.
  std::optional<NearestHit> Cast(const RayRow& ray) {
    std::optional<NearestHit> nearest;
    batch_.world.bounds().ForEachOnRay(
        ray.origin, ray.direction, ray.max_distance_m, [&](const Obstacle& object, double) {
          if (!batch_.filter.Skips(object)) {
            HitObject(object, batch_.filter, ray, interrupt_, nearest);
          }
          if (has_ended()) return -1.0;
          return nearest.has_value() ? nearest->hit.distance_m : ray.max_distance_m;
        });
    return nearest;
  }

  // True if the ray enters a hidden space before its hit.
  bool PassesHidden(const RayRow& ray, const std::optional<NearestHit>& nearest) const {
    const double end_m = nearest ? nearest->hit.distance_m - kExactTolerance_m : ray.max_distance_m;
    return std::ranges::any_of(batch_.hidden, [&](const HiddenSpace& space) {
      return space.Entry_m(ray.origin, ray.direction) < end_m;
    });
  }

  // True if the ray meets a closed hole of a mesh before its hit or there.
  bool MayMeetCaps(const RayRow& ray, const std::optional<NearestHit>& nearest) const {
    if (!batch_.world.has_caps()) return false;
    const double end_m = nearest ? nearest->hit.distance_m + kExactTolerance_m : ray.max_distance_m;
    bool meets = false;
    batch_.world.bounds().ForEachOnRay(
        ray.origin, ray.direction, end_m, [&](const Obstacle& object, double) {
          const std::vector<PreparedPart>& parts = object.geometry->parts;
          for (std::size_t k = 0; k < parts.size() && !meets; ++k) {
            if (!HasCaps(parts[k].shape) || batch_.filter.Skips(object) ||
                batch_.filter.SkipsPart(object, k)) {
              continue;
            }
            meets = MayMeetCap(*parts[k].engines[static_cast<int>(EngineKind::kExact)],
                               object.parts_W[k].X_WP, {ray.origin, ray.direction, end_m});
          }
          return meets ? -1.0 : end_m;
        });
    return meets;
  }

  void Write(std::size_t row, const NearestHit& nearest) {
    RayColumns& columns = batch_.columns;
    columns.hit[row] = 1;
    columns.distance_m[row] = nearest.hit.distance_m;
    for (int i = 0; i < 3; ++i) {
      columns.normal[3 * row + static_cast<std::size_t>(i)] = nearest.hit.normal[i];
    }
    columns.object[row] = ranks_.IndexOf(nearest.object);
    columns.object_part[row] = nearest.part;
  }

  RayBatch& batch_;
  Interrupt interrupt_;
  ObjectRanks ranks_;
};

}  // namespace

absl::StatusOr<RayColumns> CastRays(const WorldSnapshot& world, std::span<const RayRow> rays,
                                    const QueryOptions& options, std::stop_token stop) {
  if (options.engine != EngineChoice::kAuto && options.engine != EngineChoice::kExact) {
    return absl::UnimplementedError(absl::StrCat("engine ", std::string(NameOf(options.engine)),
                                                 " does not answer rays, AUTO and EXACT do"));
  }
  RayBatch batch{.world = world,
                 .rays = rays,
                 .options = options,
                 .stop = std::move(stop),
                 .limit = TimeLimit(options),
                 .filter = WorldFilter(world, options),
                 .hidden = {},
                 .columns = {}};
  batch.hidden = HiddenSpacesOf(world, batch.filter);
  Resize(rays.size(), batch.columns);
  const auto completed = ProcessChunks(EqualChunks(rays.size(), kRaysPerChunk), options.threads,
                                       [&] { return std::make_unique<Caster>(batch); });
  if (!completed.ok()) return completed.status();
  Resize(*completed, batch.columns);
  batch.columns.completed = *completed;
  return std::move(batch.columns);
}

}  // namespace cwm::collision
