#include "server/core/kept_snapshots.h"

#include <algorithm>
#include <chrono>
#include <ratio>
#include <utility>

#include "server/core/approximate_bytes.h"

namespace cwm::server {
namespace {

using collision::Revision;
using collision::WorldSnapshot;
using std::chrono::seconds;

// chosen: a planner that was told of a revision asks for it within a second; an operator who looks
// back sees ten pictures a second of what just happened and one a second of the minutes before.
using Tenths = std::chrono::duration<std::int64_t, std::deci>;
constexpr seconds kTenthsTime{10};

// chosen: after a burst of revisions the history shrinks over the next ones, two for each that is
// made, instead of making one of them wait.
constexpr int kMaxThinnedAtOnce = 2;

// The interval in which the time lies.
template <class Interval>
std::int64_t NumberOf(Clock::time_point time) {
  return std::chrono::floor<Interval>(time.time_since_epoch()).count();
}

std::int64_t RuleBytes(const WorldSnapshot& before, const WorldSnapshot& after) {
  return &before.pair_rules() != &after.pair_rules() ? ApproximateBytes(before.pair_rules()) : 0;
}

KeptSnapshots::Cost CostBetween(const WorldSnapshot& before, const WorldSnapshot& after) {
  const auto objects = collision::Difference(before, after);
  const auto robots = collision::RobotDifference(before, after);
  return {
      .changed_count = objects.size() + robots.size(),
      .superseded_bytes = ApproximateSupersededBytes(objects) + ApproximateSupersededBytes(robots)};
}

constexpr auto kRevisionOf = [](const auto& kept) { return kept.snapshot->revision(); };

}  // namespace

KeptSnapshots::KeptSnapshots(const Retention& retention, SnapshotPtr first)
    : retention_(retention) {
  const std::int64_t bytes = ApproximateOwnBytes(*first);
  kept_.push_back({.snapshot = std::move(first),
                   .ordinal = 0,
                   .made = Clock::time_point::min(),
                   .superseded = Clock::time_point::max(),
                   .used = Clock::time_point::min(),
                   .path_bytes = bytes});
  CountBytes(kept_.back(), 1);
}

void KeptSnapshots::CountBytes(const Kept& kept, int sign) {
  own_bytes_ += sign * kept.own_bytes();
  (kept.only_leased ? leased_bytes_ : unleased_bytes_) += sign * kept.bytes();
}

void KeptSnapshots::Append(SnapshotPtr next, Clock::time_point when, const Cost& cost,
                           std::vector<SnapshotPtr>& dropped) {
  Kept& latest = kept_.back();
  CountBytes(latest, -1);
  latest.superseded = when;
  latest.superseded_bytes = cost.superseded_bytes;
  latest.rule_bytes = RuleBytes(*latest.snapshot, *next);
  CountBytes(latest, 1);
  const std::int64_t path_bytes = ApproximateOwnBytes(*next, cost.changed_count);
  kept_.push_back({.snapshot = std::move(next),
                   .ordinal = latest.ordinal + 1,
                   .made = when,
                   .superseded = Clock::time_point::max(),
                   .used = Clock::time_point::min(),
                   .path_bytes = path_bytes});
  CountBytes(kept_.back(), 1);
  EndLeases(when, dropped);
  Shrink(when, dropped);
  ShrinkLeased(dropped);
}

void KeptSnapshots::EndLeases(Clock::time_point now, std::vector<SnapshotPtr>& dropped) {
  if (leased_count_ == 0) return;
  for (std::size_t i = kept_.size(); i-- > 0;) {
    const auto each = kept_.begin() + static_cast<std::ptrdiff_t>(i);
    if (each->only_leased && !IsLeased(*each, now)) Drop(each, dropped);
  }
}

void KeptSnapshots::DropAllButLatest(std::vector<SnapshotPtr>& dropped) {
  while (kept_.size() > 1) Drop(kept_.begin(), dropped);
}

std::int64_t KeptSnapshots::unleased_count() const {
  return static_cast<std::int64_t>(kept_.size() - leased_count_);
}

std::int64_t KeptSnapshots::MaxCount(Clock::time_point now) const {
  const auto first_recent =
      std::ranges::lower_bound(kept_, now - retention_.recent_time, {}, &Kept::superseded);
  const std::int64_t recent_count = kept_.end() - first_recent;
  return std::max(retention_.exact_snapshots, std::min(recent_count, retention_.recent_snapshots));
}

// Compares the time that the newest revisions took with that of so many at ten a second. Only their
// number is kept of those that were thinned.
bool KeptSnapshots::IsSlow() const {
  const Kept& latest = kept_.back();
  const std::int64_t max_count = std::max<std::int64_t>(1, retention_.exact_snapshots);
  const auto first =
      std::ranges::upper_bound(kept_, latest.ordinal - max_count, {}, &Kept::ordinal);
  return first->made <= latest.made - Tenths(max_count - 1);
}

// The oldest that can be thinned, else the oldest. There are two at least that are not only leased.
KeptSnapshots::Iterator KeptSnapshots::NextToFall(Clock::time_point now) {
  const auto is_unleased = [](const Kept& kept) { return !kept.only_leased; };
  const Iterator oldest = std::ranges::find_if(kept_, is_unleased);
  if (IsSlow()) return oldest;
  const Clock::time_point recent_from = now - retention_.recent_time;
  const Clock::time_point tenths_from = recent_from - kTenthsTime;
  Clock::time_point previous = oldest->made;
  for (Iterator each = oldest + 1; each != kept_.end(); ++each) {
    if (each->only_leased) continue;
    if (each->superseded >= recent_from) break;
    const bool is_same_interval =
        each->superseded >= tenths_from
            ? NumberOf<Tenths>(each->made) == NumberOf<Tenths>(previous)
            : NumberOf<seconds>(each->made) == NumberOf<seconds>(previous);
    if (is_same_interval) return each;
    previous = each->made;
  }
  return oldest;
}

// A snapshot that is held costs nothing more if it is kept as well, and whoever holds it is about
// to tell somebody of it, who then has half of the time at least.
bool KeptSnapshots::IsLeased(Kept& kept, Clock::time_point now) const {
  const bool is_fresh = kept.used >= now - retention_.lease_time / 2;
  if (!is_fresh && kept.snapshot.use_count() > 1) kept.used = now;
  return kept.used >= now - retention_.lease_time;
}

void KeptSnapshots::Shrink(Clock::time_point now, std::vector<SnapshotPtr>& dropped) {
  const auto let_fall = [&] {
    const Iterator which = NextToFall(now);
    if (!IsLeased(*which, now)) return Drop(which, dropped);
    CountBytes(*which, -1);
    which->only_leased = true;
    CountBytes(*which, 1);
    ++leased_count_;
  };
  for (int i = 0; i < kMaxThinnedAtOnce && unleased_count() > MaxCount(now); ++i) {
    if (unleased_count() > 1) let_fall();
  }
  while (unleased_bytes_ > retention_.snapshot_bytes && unleased_count() > 1) let_fall();
}

void KeptSnapshots::ShrinkLeased(std::vector<SnapshotPtr>& dropped) {
  const auto is_over = [&] {
    return static_cast<std::int64_t>(leased_count_) > retention_.leased_snapshots ||
           leased_bytes_ > retention_.leased_bytes;
  };
  while (leased_count_ > 0 && is_over()) {
    const auto order = [](const Kept& kept) { return std::pair(!kept.only_leased, kept.used); };
    Drop(std::ranges::min_element(kept_, {}, order), dropped);
  }
}

// Its neighbours then share less with each other: the one before also holds what was superseded
// between the two, and what both paths to the next one's changes copied is there once.
void KeptSnapshots::Drop(Iterator which, std::vector<SnapshotPtr>& dropped) {
  CountBytes(*which, -1);
  if (which->only_leased) --leased_count_;
  const bool is_between = which != kept_.begin();
  dropped.push_back(std::move(which->snapshot));
  const Iterator next = kept_.erase(which);
  if (!is_between) return;
  const Iterator previous = next - 1;
  CountBytes(*previous, -1);
  CountBytes(*next, -1);
  const Cost cost = CostBetween(*previous->snapshot, *next->snapshot);
  previous->superseded_bytes = cost.superseded_bytes;
  previous->rule_bytes = RuleBytes(*previous->snapshot, *next->snapshot);
  next->path_bytes = ApproximateOwnBytes(*next->snapshot, cost.changed_count);
  CountBytes(*previous, 1);
  CountBytes(*next, 1);
}

Revision KeptSnapshots::oldest() const {
  const auto found = std::ranges::find(kept_, false, &Kept::only_leased);
  return found->snapshot->revision();
}

Revision KeptSnapshots::NearestTo(Revision revision) const {
  const auto after = std::ranges::lower_bound(kept_, revision, {}, kRevisionOf);
  if (after == kept_.begin()) return kRevisionOf(*after);
  const Revision before = kRevisionOf(*std::prev(after));
  if (after == kept_.end()) return before;
  const Revision next = kRevisionOf(*after);
  return next.value - revision.value <= revision.value - before.value ? next : before;
}

SnapshotPtr KeptSnapshots::Find(Revision revision) const {
  const auto found = std::ranges::lower_bound(kept_, revision, {}, kRevisionOf);
  const bool is_kept = found != kept_.end() && kRevisionOf(*found) == revision;
  return is_kept ? found->snapshot : nullptr;
}

SnapshotPtr KeptSnapshots::Use(Revision revision, Clock::time_point now) {
  const auto found = std::ranges::lower_bound(kept_, revision, {}, kRevisionOf);
  if (found == kept_.end() || kRevisionOf(*found) != revision) return nullptr;
  found->used = std::max(found->used, now);
  return found->snapshot;
}

}  // namespace cwm::server
