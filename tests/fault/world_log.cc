#include "tests/fault/world_log.h"

#include <algorithm>
#include <iterator>

namespace cwm::fault {
namespace {

// After a power cut the server skips so many numbers, so that none is used for two worlds.
constexpr std::int64_t kRevisionJump = 65'536;

// True if the changes lead from the world to itself.
bool HasNoEffect(const ModelWorld& world, const std::vector<Change>& changes) {
  const auto after = Apply(world, changes);
  return after && *after == world;
}

bool LeadsTo(const ModelWorld& before, const std::vector<Change>& changes,
             const ModelWorld& after) {
  const auto result = Apply(before, changes);
  return result && *result == after;
}

std::string TextOf(const std::vector<Effect>& effects) {
  return nlohmann::json(effects).dump().substr(0, 500);
}

}  // namespace

std::string TextOf(const LogicalWrite& write) {
  const Operation& first = write.first();
  return "write " + first.request_id + " of client " + std::to_string(first.client) + " " +
         nlohmann::json(first.changes).dump().substr(0, 500);
}

void WorldLog::Complain(Report& report, const std::string& rule, const std::string& text) const {
  report.violations.push_back({rule, world_ + " (" + uid_ + "): " + text});
}

void WorldLog::AddSeen(std::int64_t revision, std::int64_t time_ns) {
  if (revision <= 0) return;
  LoggedRevision& logged = revisions_[revision];
  logged.first_seen_ns = std::min(logged.first_seen_ns, time_ns);
}

void WorldLog::AddEvents(std::int64_t revision, std::vector<Effect> effects) {
  events_.try_emplace(revision, std::move(effects));
}

const LoggedRevision* WorldLog::Find(std::int64_t revision) const {
  const auto found = revisions_.find(revision);
  return found == revisions_.end() ? nullptr : &found->second;
}

std::size_t WorldLog::EpochAt(std::int64_t time_ns) const {
  return static_cast<std::size_t>(std::count_if(
      cuts_.begin(), cuts_.end(), [&](const CutPoint& cut) { return cut.return_ns <= time_ns; }));
}

std::optional<std::int64_t> WorldLog::Next(std::int64_t revision, std::size_t epoch) const {
  for (auto next = revisions_.upper_bound(revision); next != revisions_.end(); ++next) {
    if (EpochAt(next->second.first_seen_ns) > epoch) return std::nullopt;
    if (next->second.is_skip) continue;
    if (!next->second.taken_by || *next->second.taken_by >= epoch) return next->first;
  }
  return std::nullopt;
}

void WorldLog::FindSkips() {
  for (CutPoint& cut : cuts_) {
    cut.kept = cut.shown;
    const auto shown = cut.shown ? revisions_.find(*cut.shown) : revisions_.end();
    if (shown == revisions_.end() || shown->second.first_seen_ns < cut.return_ns) continue;
    const std::int64_t before = shown == revisions_.begin() ? 0 : std::prev(shown)->first;
    if (*cut.shown - before < kRevisionJump / 2) continue;
    shown->second.is_skip = true;
    cut.kept = *cut.shown - kRevisionJump;
    AddSeen(*cut.kept, cut.invoke_ns - 1);
  }
}

// Numbers of revisions have no holes, but for the jump after a power cut: a number that nobody saw
// was made by a write without an answer.
void WorldLog::FillHoles(Report& report) {
  std::int64_t last = 0;
  std::vector<std::pair<std::int64_t, std::int64_t>> missing;  // number, when it was there
  for (const auto& [revision, logged] : revisions_) {
    if (revision - last >= kRevisionJump / 2) {
      if (EpochAt(logged.first_seen_ns) == 0) {
        Complain(report, "numbers",
                 "the revision jumps from " + std::to_string(last) + " to " +
                     std::to_string(revision) + " without a power cut");
      }
    } else {
      for (std::int64_t hole = last + 1; hole < revision; ++hole) {
        missing.emplace_back(hole, logged.first_seen_ns);
      }
    }
    last = revision;
  }
  for (const auto& [hole, time_ns] : missing) revisions_[hole].first_seen_ns = time_ns;
}

void WorldLog::MarkTaken(Report& report) {
  for (std::size_t i = 0; i < cuts_.size(); ++i) {
    if (!cuts_[i].kept) continue;
    for (auto it = revisions_.upper_bound(*cuts_[i].kept); it != revisions_.end(); ++it) {
      LoggedRevision& logged = it->second;
      if (!logged.taken_by && logged.first_seen_ns < cuts_[i].return_ns) logged.taken_by = i;
    }
  }
  for (const auto& [revision, write] : claims_) {
    const std::optional<std::size_t> taken_by = revisions_[revision].taken_by;
    if (!taken_by || write->acknowledged_ns >= cuts_[*taken_by].invoke_ns) continue;
    if (IsObserved(write->first().changes)) {
      ++report.lost_observed;
    } else {
      ++report.lost;
      Complain(report, "power-cut",
               TextOf(*write) + " was acknowledged at revision " + std::to_string(revision) +
                   ", and the power cut took it");
    }
  }
}

void WorldLog::Fold(Report& report) {
  for (const LogicalWrite* write : writes_) {
    if (write->is_acknowledged()) claims_.emplace(write->revision, write);
    if (write->is_unresolved) unresolved_.push_back(write);
  }
  FindSkips();
  FillHoles(report);
  MarkTaken(report);
  std::optional<ModelWorld> state = ModelWorld();
  std::int64_t last = 0;
  // The world that a cut left, while the revisions that it took are folded.
  struct Kept {
    std::optional<ModelWorld> state;
    std::int64_t revision;
    std::size_t cut;
  };
  std::vector<Kept> kept;
  for (auto& [revision, logged] : revisions_) {
    while (!kept.empty() && logged.taken_by != kept.back().cut) {
      state = kept.back().state;
      last = kept.back().revision;
      kept.pop_back();
    }
    if (logged.taken_by && (kept.empty() || kept.back().cut != *logged.taken_by)) {
      kept.push_back({state, last, *logged.taken_by});
    }
    logged.previous = last;
    if (!logged.is_skip) state = After({revision, state ? &*state : nullptr}, logged, report);
    if (state) logged.hash = HashOf(*state);
    ++report.revisions;
    if (!state) ++report.unchecked_revisions;
    last = revision;
  }
}

std::optional<ModelWorld> WorldLog::After(const Step& step, LoggedRevision& logged,
                                          Report& report) {
  if (step.before == nullptr) {
    const auto [first, end] = claims_.equal_range(step.revision);
    if (first != end) logged.author = first->second;
    return std::nullopt;
  }
  return events_.contains(step.revision) ? AfterEvents(step, logged, report)
                                         : AfterWrites(step, logged, report);
}

// A watch showed what the revision changed; one write must have done exactly that.
std::optional<ModelWorld> WorldLog::AfterEvents(const Step& step, LoggedRevision& logged,
                                                Report& report) {
  ModelWorld after = *step.before;
  const std::vector<Effect>& effects = events_.at(step.revision);
  const std::string number = std::to_string(step.revision);
  for (const Effect& effect : effects) {
    if (ApplyEffect(effect, after)) continue;
    Complain(report, "watch-content",
             "revision " + number + " changes " + effect.name +
                 ", which the world does not have: " + TextOf(effects));
  }
  const auto [first, end] = claims_.equal_range(step.revision);
  for (auto claim = first; claim != end && logged.author == nullptr; ++claim) {
    if (LeadsTo(*step.before, claim->second->first().changes, after)) logged.author = claim->second;
  }
  for (auto claim = first; claim != end; ++claim) {
    const LogicalWrite* const write = claim->second;
    if (write == logged.author || HasNoEffect(after, write->first().changes)) continue;
    ++report.lost;
    Complain(report, "acknowledged",
             TextOf(*write) + " was acknowledged at revision " + number + ", which holds " +
                 TextOf(effects));
  }
  if (logged.author == nullptr) {
    const auto found =
        std::find_if(unresolved_.begin(), unresolved_.end(), [&](const LogicalWrite* write) {
          return LeadsTo(*step.before, write->first().changes, after);
        });
    if (found == unresolved_.end()) {
      if (first == end) {
        Complain(report, "exactly-once",
                 "no write made revision " + number + ", which holds " + TextOf(effects));
      }
    } else {
      logged.author = *found;
      unresolved_.erase(found);
      ++report.unknown_applied;
    }
  }
  return after;
}

// No watch showed the revision: the acknowledged write is believed, and reads are compared with it.
std::optional<ModelWorld> WorldLog::AfterWrites(const Step& step, LoggedRevision& logged,
                                                Report& report) {
  const auto [first, end] = claims_.equal_range(step.revision);
  const std::string number = std::to_string(step.revision);
  for (auto claim = first; claim != end; ++claim) {
    const auto after = Apply(*step.before, claim->second->first().changes);
    if (!after) continue;
    const bool others_agree = std::all_of(first, end, [&](const auto& other) {
      return other.second == claim->second || HasNoEffect(*after, other.second->first().changes);
    });
    if (!others_agree) continue;
    logged.author = claim->second;
    return after;
  }
  if (first != end) {
    report.lost += std::distance(first, end) - 1;
    Complain(report, "acknowledged",
             "the writes acknowledged at revision " + number + " cannot be so: " +
                 TextOf(*first->second) + " after " + TextOf(*step.before).substr(0, 500));
  } else if (unresolved_.empty()) {
    Complain(report, "exactly-once", "no write made revision " + number);
  }
  return std::nullopt;
}

}  // namespace cwm::fault
