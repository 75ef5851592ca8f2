#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/engines/exact_engine.h"
#include "collision/query/interrupt.h"
#include "collision/query/object_ranks.h"
#include "collision/query/query.h"
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
    if (filter.SkipsPart(object, part.source)) continue;
    const double limit_m = nearest.has_value() ? nearest->hit.distance_m : ray.max_distance_m;
    const double entry_m = slabs.Entry_m(placed.bounds_W);
    if (entry_m > limit_m || std::isinf(entry_m)) continue;
    const auto hit = CastRay(*part.engines[static_cast<int>(EngineKind::kExact)], placed.X_WP,
                             {ray.origin, ray.direction, limit_m});
    if (interrupt.After(1)) return;
    if (!hit.has_value() || hit->distance_m > limit_m) continue;
    const bool nearer = !nearest.has_value() || hit->distance_m < nearest->hit.distance_m ||
                        Precedes(object, *nearest->object);
    if (nearer) nearest = {.hit = *hit, .object = &object, .part = static_cast<std::int32_t>(k)};
  }
}

void AppendRow(RayColumns& columns, const std::optional<NearestHit>& nearest, ObjectRanks& ranks) {
  const NearestHit row =
      nearest.value_or(NearestHit{{.distance_m = 0, .normal = Vector3::Zero()}, nullptr, 0});
  columns.hit.push_back(nearest.has_value() ? 1 : 0);
  columns.distance_m.push_back(row.hit.distance_m);
  columns.normal.insert(columns.normal.end(), row.hit.normal.begin(), row.hit.normal.end());
  columns.object.push_back(nearest.has_value() ? ranks.Of(row.object) : 0);
  columns.object_part.push_back(row.part);
  ++columns.completed;
}

}  // namespace

absl::StatusOr<RayColumns> CastRays(const WorldSnapshot& world, std::span<const RayRow> rays,
                                    const QueryOptions& options, std::stop_token stop) {
  if (options.engine != EngineChoice::kAuto && options.engine != EngineChoice::kExact) {
    return absl::UnimplementedError(absl::StrCat("engine ", std::string(NameOf(options.engine)),
                                                 " does not answer rays, AUTO and EXACT do"));
  }
  const WorldFilter filter(world, options);
  Interrupt interrupt(std::move(stop), options.give_up_at);
  ObjectRanks ranks(world);
  RayColumns columns;
  columns.hit.reserve(rays.size());
  columns.distance_m.reserve(rays.size());
  columns.normal.reserve(3 * rays.size());
  columns.object.reserve(rays.size());
  columns.object_part.reserve(rays.size());
  for (const RayRow& ray : rays) {
    if (interrupt.After(1)) break;
    std::optional<NearestHit> nearest;
    world.bounds().ForEachOnRay(
        ray.origin, ray.direction, ray.max_distance_m, [&](const Obstacle& object, double) {
          if (!filter.Skips(object)) HitObject(object, filter, ray, interrupt, nearest);
          if (interrupt.reason() != Interrupt::Reason::kNone) return -1.0;
          return nearest.has_value() ? nearest->hit.distance_m : ray.max_distance_m;
        });
    if (interrupt.reason() != Interrupt::Reason::kNone) break;
    AppendRow(columns, nearest, ranks);
  }
  if (interrupt.reason() == Interrupt::Reason::kStopped) {
    return absl::CancelledError("the question was cancelled");
  }
  return columns;
}

}  // namespace cwm::collision
