#include "server/rpc/stream_overlay.h"

#include <chrono>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "server/core/error.h"
#include "server/core/refusal.h"
#include "server/rpc/status_conversion.h"
#include "server/wire/objects.h"
#include "server/wire/prepared_bytes.h"

namespace cwm::server {
namespace {

absl::StatusOr<std::vector<collision::Change>> Read(const Application& application,
                                                    const v1::StreamOverlay& overlay,
                                                    WorkBudget* budget) {
  if (overlay.changes().empty()) return std::vector<collision::Change>();
  const auto bytes = static_cast<std::int64_t>(overlay.ByteSizeLong());
  const std::int64_t max_bytes = application.limits.max_stream_overlay_bytes;
  if (bytes > max_bytes) {
    return InvalidField("overlay",
                        absl::StrCat("has ", bytes, " bytes, must have at most ", max_bytes));
  }
  return ChangesFromProto(overlay.changes(), application.limits, application.geometry,
                          FieldPath::OfRequest("overlay"), "changes", budget);
}

// Replaces a change that has expired, so that later changes keep their indices.
constexpr collision::ExpireRules kNothing{Clock::time_point::min()};

}  // namespace

absl::Status StreamOverlay::Set(const Application& application, const v1::StreamOverlay& overlay,
                                const ClientId& client, WorkBudget* budget) {
  changes_.clear();
  base_ = changed_ = nullptr;
  world_ = WorldNameOf(overlay.world());
  const auto world = application.worlds.Find(world_);
  world_uid_ = world.ok() ? (*world)->uid() : "";
  read_status_ =
      Overloaded("overlay: there was no memory to read it", "OUT_OF_MEMORY");  // until read
  charge_ = MemoryCharge::Empty(application.memory, MemoryBudget::Client(client));
  absl::Status charged = charge_.Resize(PreparedBytes(overlay.changes(), application.geometry));
  if (!charged.ok()) return read_status_ = std::move(charged);
  auto changes = Read(application, overlay, budget);
  read_status_ = changes.status();
  changes_ = changes.ok() ? *std::move(changes) : std::vector<collision::Change>();
  if (changes_.empty()) charge_ = {};
  return read_status_;
}

absl::StatusOr<SnapshotPtr> StreamOverlay::ApplyTo(const World& world, SnapshotPtr base,
                                                   WorkBudget* budget) {
  if (world.name() != world_) return base;
  if (!read_status_.ok()) return read_status_;
  if (changes_.empty()) return base;
  if (world_uid_.empty()) world_uid_ = world.uid();
  if (world_uid_ != world.uid()) return WorldReplaced(world_, world_uid_, world.uid());
  Expire();
  if (base != base_) {
    auto changed = WithChanges(base, changes_, "overlay.changes", budget);
    if (!changed.ok()) return changed;
    changed_ = *std::move(changed);
    base_ = std::move(base);
  }
  return changed_;
}

// Expires allowances of the overlay, since no world publishes their end. Afterwards the pair is as
// in the queried revision: an overlay adds to the world's allowances and takes none away.
void StreamOverlay::Expire() {
  const Clock::time_point now = Clock::now();
  for (auto change = changes_.begin(); change != changes_.end(); ++change) {
    const auto* over = std::get_if<collision::AllowCollision>(&change->what);
    if (over == nullptr || !over->expires.has_value() || over->expires->due > now) continue;
    // If a pair was allowed several times, only the last expiry counts: earlier allowances end with
    // it.
    const collision::NamedPair pair = collision::Ordered(over->pair);
    for (auto before = changes_.begin(); before <= change; ++before) {
      const auto* allow = std::get_if<collision::AllowCollision>(&before->what);
      if (allow != nullptr && !allow->withdraw && collision::Ordered(allow->pair) == pair)
        before->what = kNothing;
    }
    base_ = changed_ = nullptr;
  }
}

absl::StatusOr<SnapshotPtr> WithChanges(const SnapshotPtr& base,
                                        const std::vector<collision::Change>& changes,
                                        const std::string& list, WorkBudget* budget) {
  auto changed = collision::Apply(base, changes, budget);
  if (HasEnded(budget)) return budget->status();
  if (changed.ok()) return changed;
  return ExplainRefusal(changed.status(), *base, changes, list);
}

}  // namespace cwm::server
