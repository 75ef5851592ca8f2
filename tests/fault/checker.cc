#include "tests/fault/checker.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <memory>
#include <set>
#include <utility>

#include "tests/fault/watch_rules.h"
#include "tests/fault/world_log.h"

namespace cwm::fault {
namespace {

using Kind = Operation::Kind;
using Outcome = Operation::Outcome;

// The server tells so that it does not have the world.
bool SaysWorldIsGone(const std::string& reason) {
  return reason == "WORLD_UNKNOWN" || reason == "WORLD_REPLACED" || reason == "WORLD_DELETED";
}

std::string TextOf(const Operation& operation) {
  static constexpr const char* kKinds[] = {"write", "deletion", "read", "power cut", "clock"};
  return std::string(kKinds[static_cast<int>(operation.kind)]) + " " + operation.request_id +
         " of client " + std::to_string(operation.client) + " in " + operation.world + " (" +
         operation.world_uid + ")";
}

// The newest revision of a world that anybody was told of before some time. A power cut takes back
// what was not acknowledged as durable.
class Floor {
 public:
  void AddSeen(std::int64_t time_ns, std::int64_t revision) {
    seen_.push_back({time_ns, revision});
  }
  void AddDurable(std::int64_t time_ns, std::int64_t revision) {
    durable_.push_back({time_ns, revision});
  }
  void Finish(const std::vector<CutPoint>& cuts) {
    std::vector<Point> all = durable_;
    all.insert(all.end(), seen_.begin(), seen_.end());
    // Answers under way at the power cut do not count: a flush may be lost that told of success.
    std::erase_if(all, [&](const Point& point) {
      return std::any_of(cuts.begin(), cuts.end(), [&](const CutPoint& cut) {
        return point.time_ns >= cut.invoke_ns && point.time_ns < cut.return_ns;
      });
    });
    std::sort(all.begin(), all.end(), ByTime);
    std::sort(durable_.begin(), durable_.end(), ByTime);
    std::size_t cut = 0;
    std::int64_t newest = 0;
    for (const Point& point : all) {
      for (; cut < cuts.size() && cuts[cut].invoke_ns <= point.time_ns; ++cut) {
        newest = DurableBefore(cuts[cut].invoke_ns);
        newest_.push_back({cuts[cut].invoke_ns, newest});
      }
      newest = std::max(newest, point.revision);
      newest_.push_back({point.time_ns, newest});
    }
    for (; cut < cuts.size(); ++cut) {
      newest_.push_back({cuts[cut].invoke_ns, DurableBefore(cuts[cut].invoke_ns)});
    }
  }
  // After Finish; 0 if nobody was told anything.
  std::int64_t Before(std::int64_t time_ns) const {
    const auto next = std::lower_bound(newest_.begin(), newest_.end(), Point{time_ns, 0}, ByTime);
    return next == newest_.begin() ? 0 : std::prev(next)->revision;
  }

 private:
  struct Point {
    std::int64_t time_ns;
    std::int64_t revision;
  };
  static bool ByTime(const Point& a, const Point& b) { return a.time_ns < b.time_ns; }
  std::int64_t DurableBefore(std::int64_t time_ns) const {
    std::int64_t newest = 0;
    for (const Point& point : durable_) {
      if (point.time_ns < time_ns) newest = std::max(newest, point.revision);
    }
    return newest;
  }
  std::vector<Point> seen_;
  std::vector<Point> durable_;
  std::vector<Point> newest_;
};

class Checker {
 public:
  explicit Checker(const History& history) : history_(history) {}

  Report Run() {
    GroupAttempts();
    CollectWorlds();
    for (auto& [uid, log] : logs_) log.Fold(report_);
    CollectFloors();
    for (const auto& write : writes_) CheckWrite(*write);
    for (const Operation& operation : history_.operations) CheckOperation(operation);
    CheckDigests();
    CheckWatches(history_.watches, logs_, report_);
    CountUnknown();
    return std::move(report_);
  }

 private:
  void Complain(const std::string& rule, const std::string& text) {
    report_.violations.push_back({rule, text});
  }

  void GroupAttempts() {
    std::map<std::string, LogicalWrite*> by_id;
    for (const Operation& operation : history_.operations) {
      if (operation.kind == Kind::kDelete) {
        if (operation.outcome == Outcome::kOk) ++report_.acknowledged;
        continue;
      }
      if (operation.kind != Kind::kWrite) continue;
      LogicalWrite*& write = by_id[operation.request_id];
      if (write == nullptr || operation.request_id.empty()) {
        writes_.push_back(std::make_unique<LogicalWrite>());
        write = writes_.back().get();
      }
      write->attempts.push_back(&operation);
      AddAttempt(operation, *write);
    }
    for (const auto& write : writes_) Resolve(*write);
  }

  void AddAttempt(const Operation& operation, LogicalWrite& write) {
    if (!operation.world_uid.empty()) write.world_uid = operation.world_uid;
    if (operation.outcome == Outcome::kUnknown) write.had_unknown = true;
    if (operation.outcome != Outcome::kOk) return;
    if (!write.is_acknowledged()) {
      write.revision = operation.revision;
      write.acknowledged_ns = operation.return_ns;
    } else if (write.revision != operation.revision) {
      Complain("exactly-once", TextOf(operation) + " was acknowledged at revision " +
                                   std::to_string(write.revision) + " and, to a retry, at " +
                                   std::to_string(operation.revision));
    }
  }

  void Resolve(LogicalWrite& write) {
    if (write.is_acknowledged()) {
      ++report_.acknowledged;
      return;
    }
    const Operation& last = *write.attempts.back();
    // The retry was refused with the world's present state: had an earlier attempt been written,
    // the retry would have had its reply.
    const bool was_refused =
        last.outcome == Outcome::kError && !(write.had_unknown && SaysWorldIsGone(last.reason));
    write.is_unresolved = !was_refused;
    ++(was_refused ? report_.refused : report_.unresolved);
  }

  WorldLog& LogOf(const std::string& world, const std::string& uid) {
    return logs_.try_emplace(uid, world, uid).first->second;
  }

  void CollectWorlds() {
    for (const auto& write : writes_) {
      const Operation& first = write->first();
      if (!write->world_uid.empty()) LogOf(first.world, write->world_uid).AddWrite(write.get());
    }
    for (const Operation& operation : history_.operations) {
      if (operation.outcome == Outcome::kOk && !operation.world_uid.empty()) {
        LogOf(operation.world, operation.world_uid)
            .AddSeen(operation.revision, operation.return_ns);
      }
    }
    for (const Watch& watch : history_.watches) {
      for (WatchStep& step : StepsOf(watch, report_)) {
        WorldLog& log = LogOf(watch.world, watch.world_uid);
        log.AddSeen(step.revision, step.time_ns);
        if (watch.is_lossless && step.kind == WatchMessage::Kind::kEvents) {
          log.AddEvents(step.revision, std::move(step.effects));
        }
      }
    }
    // A world whose first write got no answer has no uid in it.
    for (const auto& write : writes_) {
      if (!write->is_unresolved || !write->world_uid.empty()) continue;
      for (auto& [uid, log] : logs_) {
        if (log.world() == write->first().world) log.AddWrite(write.get());
      }
    }
    for (auto& [uid, log] : logs_) log.SetCuts(CutsOf(uid));
    for (const Operation& operation : history_.operations) {
      if (operation.kind != Kind::kClockAhead) continue;
      for (auto& [uid, log] : logs_) log.SetForgotten(operation.invoke_ns);
    }
  }

  std::vector<CutPoint> CutsOf(const std::string& uid) const {
    std::vector<CutPoint> cuts;
    for (const Operation& operation : history_.operations) {
      if (operation.kind != Kind::kCut) continue;
      cuts.push_back({.invoke_ns = operation.invoke_ns, .return_ns = operation.return_ns});
    }
    for (std::size_t i = 0; i < cuts.size(); ++i) {
      const std::int64_t end = i + 1 < cuts.size() ? cuts[i + 1].invoke_ns : LogicalWrite::kNever;
      for (const Operation& operation : history_.operations) {
        if (operation.after_restart && operation.outcome == Outcome::kOk &&
            operation.world_uid == uid && operation.invoke_ns >= cuts[i].return_ns &&
            operation.invoke_ns < end && !cuts[i].shown) {
          cuts[i].shown = operation.revision;
        }
      }
    }
    return cuts;
  }

  void CollectFloors() {
    for (const Operation& operation : history_.operations) {
      if (operation.world_uid.empty()) continue;
      Floor& floor = floors_[operation.world_uid];
      if (operation.outcome == Outcome::kOk) floor.AddSeen(operation.return_ns, operation.revision);
      if (operation.actual_revision) {
        floor.AddSeen(operation.return_ns, *operation.actual_revision);
      }
      if (operation.kind == Kind::kWrite && operation.outcome == Outcome::kOk &&
          !IsObserved(operation.changes)) {
        floor.AddDurable(operation.return_ns, operation.revision);
      }
    }
    for (const Watch& watch : history_.watches) {
      for (const WatchMessage& message : watch.messages) {
        if (!message.more) floors_[watch.world_uid].AddSeen(message.time_ns, message.revision);
      }
    }
    for (auto& [uid, floor] : floors_) {
      const auto log = logs_.find(uid);
      floor.Finish(log == logs_.end() ? std::vector<CutPoint>{} : log->second.cuts());
    }
    for (const Operation& operation : history_.operations) {
      if (operation.kind != Kind::kDelete) continue;
      Deletion& deletion = deletions_[operation.world_uid];
      deletion.first_invoke_ns = std::min(deletion.first_invoke_ns, operation.invoke_ns);
      if (operation.outcome == Outcome::kOk) {
        deletion.acknowledged_ns = std::min(deletion.acknowledged_ns, operation.return_ns);
      }
    }
  }

  // Real-time order, and the rule of expected_revision.
  void CheckWrite(const LogicalWrite& write) {
    if (!write.is_acknowledged()) return;
    const Operation& first = write.first();
    const WorldLog& log = logs_.at(write.world_uid);
    const LoggedRevision* const logged = log.Find(write.revision);
    const std::int64_t floor = floors_.at(write.world_uid).Before(first.invoke_ns);
    const bool made_it = logged != nullptr && logged->author == &write;
    if (write.revision < floor || (made_it && write.revision == floor)) {
      Complain("real-time", TextOf(write) + " got revision " + std::to_string(write.revision) +
                                ", but revision " + std::to_string(floor) +
                                " had been told before it was sent");
    }
    if (!first.expected_revision || logged == nullptr) return;
    const std::int64_t before = made_it ? logged->previous : write.revision;
    if (*first.expected_revision != before) {
      Complain("expected-revision", TextOf(write) + " expected revision " +
                                        std::to_string(*first.expected_revision) +
                                        " and succeeded after " + std::to_string(before));
    }
  }

  void CheckOperation(const Operation& operation) {
    if (operation.world_uid.empty()) return;  // nothing of a world
    const std::int64_t floor = floors_.at(operation.world_uid).Before(operation.invoke_ns);
    if (operation.outcome == Outcome::kError) CheckRefusal(operation, floor);
    if (operation.outcome != Outcome::kOk) return;
    CheckNotDeleted(operation);
    const WorldLog& log = logs_.at(operation.world_uid);
    if (operation.kind != Kind::kWrite) CheckRevision(operation, log, floor);
    if (operation.kind == Kind::kRead) CheckContent(operation, log);
  }

  void CheckRefusal(const Operation& operation, std::int64_t floor) {
    const std::string& reason = operation.reason;
    if (operation.actual_revision) {
      if (*operation.actual_revision == operation.expected_revision) {
        Complain("expected-revision", TextOf(operation) +
                                          " was refused although it expected the actual revision " +
                                          std::to_string(*operation.actual_revision));
      }
      if (*operation.actual_revision < floor) {
        Complain("latest", TextOf(operation) + " was refused with revision " +
                               std::to_string(*operation.actual_revision) + ", but " +
                               std::to_string(floor) + " had been told before");
      }
    }
    if (reason == "REVISION_IN_FUTURE" && operation.asked_revision <= floor) {
      Complain("latest", TextOf(operation) + ": revision " +
                             std::to_string(operation.asked_revision) +
                             " is said to be in the future, but had been told before");
    }
    if (operation.kind == Kind::kDelete && SaysWorldIsGone(reason) && floor > 0) {
      Complain("exactly-once",
               TextOf(operation) + " was refused with " + reason + " instead of the first reply");
    } else if (SaysWorldIsGone(reason) && floor > 0) {
      const auto deletion = deletions_.find(operation.world_uid);
      if (deletion == deletions_.end() || deletion->second.first_invoke_ns > operation.return_ns) {
        ++report_.lost;
        Complain("acknowledged", TextOf(operation) + " was refused with " + reason +
                                     ", but nobody deleted the world");
      }
    }
  }

  void CheckNotDeleted(const Operation& operation) {
    const auto deletion = deletions_.find(operation.world_uid);
    if (operation.kind == Kind::kDelete || deletion == deletions_.end()) return;
    if (deletion->second.acknowledged_ns < operation.invoke_ns) {
      Complain("deleted", TextOf(operation) + " succeeded after the world had been deleted");
    }
  }

  void CheckRevision(const Operation& operation, const WorldLog& log, std::int64_t floor) {
    const std::int64_t revision = operation.revision;
    const std::string text = TextOf(operation) + " is at revision " + std::to_string(revision);
    if (operation.at == Operation::At::kLatest && revision < floor) {
      if (operation.after_restart) CountLost(operation, log);
      Complain("latest", text + ", but " + std::to_string(floor) + " had been told before");
    }
    if (operation.at == Operation::At::kAtLeast && revision < operation.asked_revision) {
      Complain("latest",
               text + ", but asked for at least " + std::to_string(operation.asked_revision));
    }
    if (operation.at == Operation::At::kExact && revision != operation.asked_revision) {
      Complain("latest", text + ", but asked for " + std::to_string(operation.asked_revision));
    }
    const LoggedRevision* const logged = log.Find(revision);
    if (logged == nullptr) return;  // revision 0
    if (logged->author != nullptr && logged->author->first().invoke_ns > operation.return_ns) {
      Complain("real-time", text + ", which was made later");
    }
    if (logged->taken_by && *logged->taken_by < log.EpochAt(operation.invoke_ns)) {
      Complain("power-cut", text + ", whose number a power cut had taken");
    }
  }

  // The acknowledged writes that a restart did not bring back.
  void CountLost(const Operation& operation, const WorldLog& log) {
    for (const LogicalWrite* write : log.writes()) {
      if (write->acknowledged_ns >= operation.invoke_ns || write->revision <= operation.revision) {
        continue;
      }
      const LoggedRevision* const logged = log.Find(write->revision);
      if (logged == nullptr || !logged->taken_by) ++report_.lost;
    }
  }

  void CheckContent(const Operation& operation, const WorldLog& log) {
    const ModelHash empty = HashOf({});
    const LoggedRevision* const logged = log.Find(operation.revision);
    if (operation.revision > 0 && (logged == nullptr || !logged->hash)) return;
    const ModelHash& hash = operation.revision > 0 ? *logged->hash : empty;
    ++report_.reads;
    const auto compare = [&](const char* part, const std::optional<std::uint64_t>& read,
                             std::uint64_t folded) {
      if (!read || *read == folded) return;
      Complain("content", TextOf(operation) + " shows other " + part + " at revision " +
                              std::to_string(operation.revision) + " than the writes made");
    };
    compare("objects", operation.objects_hash, hash.objects);
    compare("robots", operation.robots_hash, hash.robots);
    compare("rules", operation.rules_hash, hash.rules);
  }

  void CheckDigests() {
    std::map<std::string, const Operation*> first_by_key;
    for (const Operation& operation : history_.operations) {
      for (const auto& [what, digest] : operation.digests) {
        const std::string key =
            operation.world_uid + " " + std::to_string(operation.revision) + " " + what;
        const auto [first, is_new] = first_by_key.try_emplace(key, &operation);
        if (is_new || first->second->digests.at(what) == digest) continue;
        Complain("replay", TextOf(operation) + ": the bytes of " + what + " at revision " +
                               std::to_string(operation.revision) +
                               " are not those that were sent before");
      }
    }
  }

  // Writes without an answer that were in the world when the server was back.
  void CountUnknown() {
    for (const auto& write : writes_) {
      if (!write->had_unknown) continue;
      ++report_.unknown;
      if (!write->is_acknowledged()) continue;
      const Operation* restart = nullptr;
      for (const Operation& operation : history_.operations) {
        if (operation.after_restart && operation.outcome == Outcome::kOk &&
            operation.world_uid == write->world_uid &&
            operation.invoke_ns > write->first().return_ns) {
          restart = &operation;
          break;
        }
      }
      if (restart != nullptr && write->revision <= restart->revision) ++report_.unknown_applied;
    }
  }

  struct Deletion {
    std::int64_t first_invoke_ns = LogicalWrite::kNever;
    std::int64_t acknowledged_ns = LogicalWrite::kNever;
  };

  const History& history_;
  Report report_;
  std::vector<std::unique_ptr<LogicalWrite>> writes_;
  std::map<std::string, WorldLog> logs_;
  std::map<std::string, Floor> floors_;
  std::map<std::string, Deletion> deletions_;
};

}  // namespace

Report Check(const History& history) { return Checker(history).Run(); }

}  // namespace cwm::fault
