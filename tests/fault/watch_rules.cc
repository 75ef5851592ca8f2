#include "tests/fault/watch_rules.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace cwm::fault {
namespace {

// What a client knows from all its streams of one world.
struct Follower {
  std::optional<ModelWorld> state = {};  // empty: it began to watch at a revision other than 0
  std::int64_t revision = 0;
};

class StreamCheck {
 public:
  StreamCheck(const Watch& watch, const WorldLog& log, Report& report)
      : watch_(watch), log_(log), report_(report), epoch_(log.EpochAt(watch.invoke_ns)) {}

  void Run(Follower& follower) {
    if (watch_.from_revision) {
      if (*watch_.from_revision == 0) {
        follower = {.state = ModelWorld(), .revision = 0};
      } else if (*watch_.from_revision != follower.revision) {
        follower = {.state = std::nullopt, .revision = *watch_.from_revision};
      }
    }
    bool began = watch_.from_revision.has_value();
    for (const WatchStep& step : StepsOf(watch_, unused_)) {
      const bool is_initial = step.kind == WatchMessage::Kind::kInitialState;
      if (is_initial == began) {
        Complain("resumable", is_initial ? "an initial state was sent again"
                                         : "the watch did not begin with the initial state");
        return;
      }
      if (is_initial) {
        follower = {.state = ModelWorld(), .revision = step.revision};
        began = true;
        Take(step, follower);
      } else if (step.kind == WatchMessage::Kind::kEvents) {
        CheckEvents(step, follower);
      } else {
        CheckBookmark(step, follower);
      }
      if (failed_) return;
      follower.revision = std::max(follower.revision, step.revision);
    }
    CheckEnd(follower);
  }

 private:
  void Complain(const std::string& rule, const std::string& text) {
    failed_ = true;
    report_.violations.push_back(
        {"watch-" + rule,
         log_.world() + " (" + log_.uid() + "), " +
             (watch_.is_lossless ? "lossless" : "coalesced") + " watch of client " +
             std::to_string(watch_.client) + " from " +
             (watch_.from_revision ? std::to_string(*watch_.from_revision) : "its state") + ": " +
             text});
  }

  void CheckEvents(const WatchStep& step, Follower& follower) {
    const std::string number = std::to_string(step.revision);
    if (step.revision == follower.revision) {
      Complain("unique", "revision " + number + " was sent twice");
    } else if (step.revision < follower.revision) {
      Complain("ordered",
               "revision " + number + " was sent after " + std::to_string(follower.revision));
    } else {
      if (watch_.is_lossless) CheckNoneSkipped(step.revision - 1, follower.revision);
      if (!failed_) Take(step, follower);
    }
  }

  void CheckBookmark(const WatchStep& step, const Follower& follower) {
    if (step.revision < follower.revision) {
      Complain("ordered", "the bookmark " + std::to_string(step.revision) + " was sent after " +
                              std::to_string(follower.revision));
      return;
    }
    if (watch_.is_lossless) CheckNoneSkipped(step.revision, follower.revision);
    if (!failed_) Compare(step, follower);
  }

  // Everything after `reached` up to `last` must have been sent.
  void CheckNoneSkipped(std::int64_t last, std::int64_t reached) {
    const auto next = log_.Next(reached, epoch_);
    if (next && *next <= last) {
      Complain("reliable", "revision " + std::to_string(*next) + " was not sent, but what follows");
    }
  }

  void Take(const WatchStep& step, Follower& follower) {
    if (!follower.state) return;
    ++report_.watch_events;
    for (const Effect& effect : step.effects) {
      if (ApplyEffect(effect, *follower.state)) continue;
      // A coalesced watch reports the removal of what its client never heard of, too.
      if (effect.kind == Effect::Kind::kRemoveObject && !watch_.is_lossless) continue;
      if (effect.kind == Effect::Kind::kRemoveRobot && !watch_.is_lossless) continue;
      Complain("content", "revision " + std::to_string(step.revision) + " changes " + effect.name +
                              ", which the client does not know");
      return;
    }
    Compare(step, follower);
  }

  void Compare(const WatchStep& step, const Follower& follower) {
    if (!follower.state || step.revision == 0) return;
    const LoggedRevision* const logged = log_.Find(step.revision);
    if (logged == nullptr) {
      Complain("bookmarkable", "there is no revision " + std::to_string(step.revision));
    } else if (logged->taken_by && *logged->taken_by < epoch_) {
      Complain("reliable", "revision " + std::to_string(step.revision) +
                               ", which a power cut took, was sent again");
    } else if (logged->hash && *logged->hash != HashOf(*follower.state)) {
      Complain("content", "at revision " + std::to_string(step.revision) +
                              " the client knows another world than the writes made: " +
                              TextOf(*follower.state).substr(0, 2'000));
    }
  }

  void CheckEnd(const Follower& follower) {
    if (watch_.end_reason != "REVISION_COMPACTED" && watch_.end_reason != "REVISION_IN_FUTURE") {
      return;
    }
    const LoggedRevision* const logged = log_.Find(follower.revision);
    if (log_.forgotten_ns() > 0 && watch_.invoke_ns >= log_.forgotten_ns() &&
        (logged == nullptr || logged->first_seen_ns < log_.forgotten_ns())) {
      return;
    }
    // A cut may have taken the revision from which the client resumes, or the memory of it.
    if (epoch_ > 0 && logged != nullptr && log_.EpochAt(logged->first_seen_ns) < epoch_) return;
    Complain("resumable", "it cannot resume at revision " + std::to_string(follower.revision));
  }

  const Watch& watch_;
  const WorldLog& log_;
  Report& report_;
  Report unused_;  // incomplete steps were reported when the logs were made
  std::size_t epoch_;
  bool failed_ = false;
};

}  // namespace

std::vector<WatchStep> StepsOf(const Watch& watch, Report& report) {
  std::vector<WatchStep> steps;
  bool continues = false;
  for (const WatchMessage& message : watch.messages) {
    if (continues &&
        (steps.back().revision != message.revision || steps.back().kind != message.kind)) {
      report.violations.push_back({"watch-atomic", watch.world + ": revision " +
                                                       std::to_string(steps.back().revision) +
                                                       " was not completed before revision " +
                                                       std::to_string(message.revision)});
      return steps;
    }
    if (!continues) steps.push_back({.kind = message.kind, .revision = message.revision});
    steps.back().time_ns = message.time_ns;
    steps.back().effects.insert(steps.back().effects.end(), message.effects.begin(),
                                message.effects.end());
    continues = message.more;
  }
  if (continues) steps.pop_back();
  return steps;
}

void CheckWatches(const std::vector<Watch>& watches,
                  const std::map<std::string, WorldLog>& logs_by_uid, Report& report) {
  std::vector<const Watch*> in_time;
  for (const Watch& watch : watches) in_time.push_back(&watch);
  std::stable_sort(in_time.begin(), in_time.end(),
                   [](const Watch* a, const Watch* b) { return a->invoke_ns < b->invoke_ns; });
  std::map<std::pair<int, std::string>, Follower> followers;
  for (const Watch* watch : in_time) {
    const auto log = logs_by_uid.find(watch->world_uid);
    if (log == logs_by_uid.end()) continue;  // nothing was ever sent
    StreamCheck(*watch, log->second, report).Run(followers[{watch->client, watch->world_uid}]);
  }
}

}  // namespace cwm::fault
