#include "server/core/watch.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "server/core/error.h"
#include "server/core/world_feed.h"

namespace cwm::server {
namespace {

using collision::Revision;

absl::Status TooSlow(Revision position, Revision oldest) {
  return MakeError(absl::StatusCode::kResourceExhausted,
                   absl::StrCat("the watch has read up to revision ", position.value,
                                ", events are kept from ", oldest.value, " on: start anew"),
                   {.reason = "WATCH_TOO_SLOW",
                    .metadata = {{"position", std::to_string(position.value)},
                                 {"oldest_revision", std::to_string(oldest.value)}}});
}

// The common part of both modes: the subscription, the initial state and the end.
class Cursor : public WatchCursor {
 public:
  Cursor(std::shared_ptr<WorldFeed> feed, WorldFeed::Start start, const WatchOptions& options)
      : feed_(std::move(feed)),
        subscription_(std::move(start.subscription)),
        position_(options.from_revision.value_or(start.latest->revision())) {
    if (!options.from_revision.has_value()) initial_ = std::move(start.latest);
  }
  ~Cursor() override { feed_->Unsubscribe(subscription_); }

  absl::StatusOr<std::optional<WatchStep>> Next() final {
    if (initial_ != nullptr) {
      return WatchStep{.kind = WatchStep::Kind::kInitialState,
                       .revision = position_,
                       .snapshot = std::exchange(initial_, nullptr),
                       .last = false};
    }
    if (said_last_) return std::nullopt;
    return NextChange();
  }

  Revision position() const final { return position_; }

 protected:
  virtual absl::StatusOr<std::optional<WatchStep>> NextChange() = 0;

  WorldFeed& feed() { return *feed_; }

  std::optional<WatchStep> Advance(Revision revision, std::vector<collision::ObjectDelta> deltas,
                                   std::vector<collision::RobotDelta> robot_deltas,
                                   std::vector<collision::PairRuleDelta> rule_deltas) {
    position_ = revision;
    const bool is_event = !deltas.empty() || !robot_deltas.empty() || !rule_deltas.empty();
    return WatchStep{.kind = is_event ? WatchStep::Kind::kEvents : WatchStep::Kind::kBookmark,
                     .revision = revision,
                     .deltas = std::move(deltas),
                     .robot_deltas = std::move(robot_deltas),
                     .rule_deltas = std::move(rule_deltas),
                     .last = false};
  }

  // The step of a reader that has received everything.
  absl::StatusOr<std::optional<WatchStep>> UpToDate(EndReason end_reason) {
    if (end_reason == EndReason::kDeleted) return WorldDeleted();
    if (end_reason == EndReason::kNone) return std::nullopt;
    said_last_ = true;
    return WatchStep{.kind = WatchStep::Kind::kBookmark, .revision = position_, .last = true};
  }

 private:
  std::shared_ptr<WorldFeed> feed_;
  std::shared_ptr<const WorldFeed::Wake> subscription_;
  SnapshotPtr initial_;  // not delivered yet
  Revision position_;
  bool said_last_ = false;
};

// Follows the log, one revision per step.
class LosslessCursor final : public Cursor {
 public:
  using Cursor::Cursor;

 private:
  absl::StatusOr<std::optional<WatchStep>> NextChange() override {
    const WorldFeed::ReadResult result = feed().ReadAfter(position());
    if (result.event != nullptr) {
      const Event& event = *result.event;
      return Advance(event.revision, {event.deltas.begin(), event.deltas.end()}, event.robot_deltas,
                     event.rule_deltas);
    }
    if (result.compacted) return TooSlow(position(), result.oldest_watch);
    return UpToDate(result.end_reason);
  }
};

// Compares the last delivered snapshot with the latest. It needs no log, so it can never be too
// slow.
class CoalescedCursor final : public Cursor {
 public:
  CoalescedCursor(std::shared_ptr<WorldFeed> feed, WorldFeed::Start start,
                  const WatchOptions& options)
      : Cursor(std::move(feed), start, options), delivered_(Delivered(start, options)) {}

 private:
  static SnapshotPtr Delivered(const WorldFeed::Start& start, const WatchOptions& options) {
    if (!options.from_revision.has_value()) return start.latest;
    if (start.from != nullptr) return start.from;
    return UndoEvents(*start.latest, start.missed, *options.from_revision);
  }

  absl::StatusOr<std::optional<WatchStep>> NextChange() override {
    const EndReason end_reason =
        feed().end_reason();  // before the latest snapshot: no change is lost
    SnapshotPtr latest = feed().Latest();
    if (latest->revision() == position()) return UpToDate(end_reason);
    std::vector<collision::ObjectDelta> deltas = collision::Difference(*delivered_, *latest);
    std::vector<collision::RobotDelta> robot_deltas =
        collision::RobotDifference(*delivered_, *latest);
    std::vector<collision::PairRuleDelta> rule_deltas =
        collision::RuleDifference(delivered_->pair_rules(), latest->pair_rules());
    const Revision revision = latest->revision();
    delivered_ = std::move(latest);
    return Advance(revision, std::move(deltas), std::move(robot_deltas), std::move(rule_deltas));
  }

  SnapshotPtr delivered_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<WatchCursor>> StartWatch(std::shared_ptr<WorldFeed> feed,
                                                        const WatchOptions& options,
                                                        WorldFeed::Wake wake) {
  absl::StatusOr<WorldFeed::Start> start = feed->Subscribe(options, std::move(wake));
  if (!start.ok()) return start.status();
  std::unique_ptr<WatchCursor> cursor;
  if (options.mode == WatchMode::kCoalesced) {
    cursor = std::make_unique<CoalescedCursor>(std::move(feed), *std::move(start), options);
  } else {
    cursor = std::make_unique<LosslessCursor>(std::move(feed), *std::move(start), options);
  }
  return cursor;
}

}  // namespace cwm::server
