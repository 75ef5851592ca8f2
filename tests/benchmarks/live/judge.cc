#include "tests/benchmarks/live/judge.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <tuple>
#include <utility>

namespace cwm::benchmarks {
namespace {

// chosen: below this visible share nobody can ask for a thing to be followed.
constexpr double kMinVisibleShare = 0.15;
// Two poses are equal if no number differs by more: published poses pass through text and floats.
constexpr double kSamePose = 1e-9;

bool IsSamePose(const Pose& a, const Pose& b) {
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff() <= kSamePose;
}

bool MayBe(const PublishedThing& published, const TrueThing& thing) {
  const double ratio = published.diagonal_m / thing.diagonal_m;
  return ratio <= kMaxSizeRatio && ratio >= 1 / kMaxSizeRatio &&
         (published.center_W - thing.center_W).norm() <= kMaxCenterShare * thing.diagonal_m;
}

// True if something is published at the place of the thing, whatever its kind. Pieces of a mover
// are smaller than the thing, which they cover together; what is much larger is something else.
bool IsCovered(const Moment& moment, const TrueThing& thing) {
  return std::ranges::any_of(moment.published, [&](const PublishedThing& published) {
    return published.diagonal_m <= kMaxSizeRatio * thing.diagonal_m &&
           (published.center_W - thing.center_W).norm() <= 0.5 * thing.diagonal_m;
  });
}

const PublishedThing* Find(const Moment& moment, const std::string& name) {
  const auto found = std::ranges::find(moment.published, name, &PublishedThing::name);
  return found == moment.published.end() ? nullptr : &*found;
}

const PublishedThing* MatchOf(const Moment& moment, int match) {
  return match < 0 ? nullptr : &moment.published[static_cast<std::size_t>(match)];
}

// The true thing that is matched by the published object, in this moment.
std::optional<std::size_t> ThingOf(const Moment& moment, const std::vector<int>& matches,
                                   const std::string& name) {
  for (std::size_t thing = 0; thing < matches.size(); ++thing) {
    const PublishedThing* match = MatchOf(moment, matches[thing]);
    if (match != nullptr && match->name == name) return thing;
  }
  return std::nullopt;
}

bool IsVisible(const TrueThing& thing) {
  return thing.is_present && thing.visible_share >= kMinVisibleShare;
}

// True if the thing appears, vanishes, moves or comes into sight between the moments.
bool HasEvent(const TrueThing& before, const TrueThing& after) {
  return before.is_present != after.is_present || after.is_moving ||
         !IsSamePose(before.X_WO, after.X_WO) || (!IsVisible(before) && IsVisible(after));
}

// By moment and thing, the stamp of the last event until then; -inf: none.
std::vector<std::vector<double>> LastEvents(const Timeline& timeline) {
  std::vector<std::vector<double>> last(timeline.size());
  for (std::size_t m = 0; m < timeline.size(); ++m) {
    last[m] = m == 0 ? std::vector<double>(timeline[0].truth.size(), -INFINITY) : last[m - 1];
    for (std::size_t t = 0; m > 0 && t < last[m].size(); ++t) {
      if (HasEvent(timeline[m - 1].truth[t], timeline[m].truth[t])) {
        last[m][t] = timeline[m].stamp_s;
      }
    }
  }
  return last;
}

std::vector<std::vector<int>> MatchAll(const Timeline& timeline) {
  std::vector<std::vector<int>> matches;
  matches.reserve(timeline.size());
  for (const Moment& moment : timeline) matches.push_back(MatchThings(moment));
  return matches;
}

class ChangeJudge {
 public:
  explicit ChangeJudge(const Timeline& timeline)
      : timeline_(timeline), matches_(MatchAll(timeline)), last_events_(LastEvents(timeline)) {}

  ChangeVerdict Judge(std::size_t from) {
    for (std::size_t m = std::max<std::size_t>(from, 1); m < timeline_.size(); ++m) JudgeMoment(m);
    return std::move(verdict_);
  }

 private:
  void JudgeMoment(std::size_t m) {
    for (const PublishedThing& now : timeline_[m].published) {
      if (now.kind != PublishedKind::kThing) continue;
      const PublishedThing* before = Find(timeline_[m - 1], now.name);
      if (before == nullptr && IsLateAddition(m, now.name)) {
        ++verdict_.all.added;
      } else if (before == nullptr) {
        Count(m, m, now.name, "added", &ChangeCounts::added);
      } else if (now.geometry_revision != before->geometry_revision) {
        Count(m, m, now.name, "replaced", &ChangeCounts::replaced);
      } else if (!IsSamePose(now.X_WO, before->X_WO)) {
        Count(m, m, now.name, "moved", &ChangeCounts::moved);
      }
    }
    for (const PublishedThing& before : timeline_[m - 1].published) {
      if (before.kind != PublishedKind::kThing) continue;
      if (Find(timeline_[m], before.name) == nullptr) {
        Count(m, m - 1, before.name, "removed", &ChangeCounts::removed);
      }
    }
  }

  // The change shows at moment m; at `matched` the object is matched.
  void Count(std::size_t m, std::size_t matched, const std::string& name, const char* kind,
             int ChangeCounts::*count) {
    ++(verdict_.all.*count);
    if (IsFounded(m, matched, name)) return;
    ++(verdict_.unfounded.*count);
    char line[200];
    std::snprintf(line, sizeof(line), "moment %zu, %.3f s: %s %s", m,
                  timeline_[m].stamp_s - timeline_.front().stamp_s, name.c_str(), kind);
    verdict_.lines.emplace_back(line);
  }

  // True if the object is a true thing that was not published since its last event: that it is
  // there is true, however late it is told.
  bool IsLateAddition(std::size_t m, const std::string& name) const {
    const auto thing = ThingOf(timeline_[m], matches_[m], name);
    if (!thing) return false;
    const double event_s = last_events_[m][*thing];
    for (std::size_t back = m; back-- > 0 && timeline_[back].stamp_s >= event_s;) {
      if (matches_[back][*thing] >= 0) return false;
    }
    return std::isfinite(event_s);
  }

  // An object may have stood where its thing was some moments ago, and be matched no longer.
  bool IsFounded(std::size_t m, std::size_t matched, const std::string& name) const {
    const double now_s = timeline_[m].stamp_s;
    for (std::size_t back = matched + 1; back-- > 0;) {
      if (now_s - timeline_[back].stamp_s > kConsequence_s) return false;
      const auto thing = ThingOf(timeline_[back], matches_[back], name);
      if (thing) return now_s - last_events_[m][*thing] <= kConsequence_s;
    }
    return false;
  }

  const Timeline& timeline_;
  const std::vector<std::vector<int>> matches_;
  const std::vector<std::vector<double>> last_events_;
  ChangeVerdict verdict_;
};

// The events of one thing, in order of time.
std::vector<Notice> EventsOf(const Timeline& timeline, std::size_t thing) {
  std::vector<Notice> events;
  for (std::size_t m = 1; m < timeline.size(); ++m) {
    const TrueThing& before = timeline[m - 1].truth[thing];
    const TrueThing& now = timeline[m].truth[thing];
    if (!before.is_present && now.is_present) {
      events.push_back({.kind = Notice::Kind::kAdded, .thing = thing, .moment = m});
    } else if (before.is_present && !now.is_present) {
      events.push_back({.kind = Notice::Kind::kRemoved, .thing = thing, .moment = m});
    } else if (now.is_present && !IsSamePose(before.X_WO, now.X_WO)) {
      const bool goes_on = m >= 2 && timeline[m - 2].truth[thing].is_present &&
                           !IsSamePose(timeline[m - 2].truth[thing].X_WO, before.X_WO);
      if (goes_on && !events.empty() && events.back().kind == Notice::Kind::kMoved) {
        const Pose& home = timeline[events.back().moment - 1].truth[thing].X_WO;
        events.back().distance_m = (now.X_WO.translation() - home.translation()).norm();
      } else if (!goes_on) {
        events.push_back(
            {.kind = Notice::Kind::kMoved,
             .thing = thing,
             .moment = m,
             .distance_m = (now.X_WO.translation() - before.X_WO.translation()).norm()});
      }
    }
  }
  return events;
}

std::string RestLine(const Timeline& timeline, std::size_t m, std::size_t thing,
                     const std::string& name, const char* what, double distance_m) {
  char line[200];
  std::snprintf(line, sizeof(line),
                "moment %zu, %.3f s: thing %zu, %.0f %% visible, as %s, %s by %.1f mm", m,
                timeline[m].stamp_s - timeline.front().stamp_s, thing,
                1e2 * timeline[m].truth[thing].visible_share, name.c_str(), what, 1e3 * distance_m);
  return line;
}

// True if the published world of the moment shows the event. `match_before` is the object that was
// matched before a move.
bool Shows(const Timeline& timeline, std::size_t m, const Notice& event,
           const PublishedThing* match_before) {
  const TrueThing& before = timeline[event.moment - 1].truth[event.thing];
  switch (event.kind) {
    case Notice::Kind::kAdded: {
      const TrueThing& now = timeline[m].truth[event.thing];
      return !IsCovered(timeline[event.moment - 1], now) && IsCovered(timeline[m], now);
    }
    case Notice::Kind::kRemoved:
      return IsCovered(timeline[event.moment - 1], before) && !IsCovered(timeline[m], before);
    case Notice::Kind::kMoved:
      break;
  }
  if (match_before == nullptr) return false;
  const PublishedThing* now = Find(timeline[m], match_before->name);
  if (now == nullptr) return !IsCovered(timeline[m], before);
  return now->is_moving || (now->X_WO.translation() - match_before->X_WO.translation()).norm() >=
                               0.5 * event.distance_m;
}

}  // namespace

std::vector<int> MatchThings(const Moment& moment) {
  std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
  for (std::size_t t = 0; t < moment.truth.size(); ++t) {
    for (std::size_t p = 0; p < moment.published.size(); ++p) {
      const PublishedThing& published = moment.published[p];
      if (!moment.truth[t].is_present || published.kind != PublishedKind::kThing ||
          !MayBe(published, moment.truth[t])) {
        continue;
      }
      pairs.emplace_back((published.center_W - moment.truth[t].center_W).norm(), t, p);
    }
  }
  std::ranges::sort(pairs);
  std::vector<int> matches(moment.truth.size(), -1);
  std::vector<bool> is_taken(moment.published.size(), false);
  for (const auto& [distance_m, t, p] : pairs) {
    if (matches[t] >= 0 || is_taken[p]) continue;
    matches[t] = static_cast<int>(p);
    is_taken[p] = true;
  }
  return matches;
}

ChangeVerdict JudgeChanges(const Timeline& timeline, std::size_t from) {
  return ChangeJudge(timeline).Judge(from);
}

std::vector<Notice> JudgeNotices(const Timeline& timeline, std::size_t from) {
  std::vector<Notice> notices;
  if (timeline.empty()) return notices;
  for (std::size_t thing = 0; thing < timeline.front().truth.size(); ++thing) {
    const std::vector<Notice> events = EventsOf(timeline, thing);
    for (std::size_t e = 0; e < events.size(); ++e) {
      Notice notice = events[e];
      const std::size_t shown =
          notice.kind == Notice::Kind::kRemoved ? notice.moment - 1 : notice.moment;
      if (notice.moment < from || !IsVisible(timeline[shown].truth[thing])) continue;
      const std::size_t end = e + 1 < events.size() ? events[e + 1].moment : timeline.size();
      const Moment& before = timeline[notice.moment - 1];
      const PublishedThing* match = MatchOf(before, MatchThings(before)[thing]);
      for (std::size_t m = notice.moment; m < end && !notice.moments; ++m) {
        if (!Shows(timeline, m, notice, match)) continue;
        notice.moments = static_cast<int>(m - notice.moment);
        notice.time_s = timeline[m].stamp_s - timeline[notice.moment].stamp_s;
      }
      notices.push_back(notice);
    }
  }
  return notices;
}

IdentityVerdict JudgeIdentity(const Timeline& timeline, std::size_t from) {
  IdentityVerdict verdict;
  std::map<std::size_t, std::string> names;  // by thing
  std::map<std::size_t, bool> was_away;
  for (std::size_t m = 0; m < timeline.size(); ++m) {
    const std::vector<int> matches = MatchThings(timeline[m]);
    for (std::size_t t = 0; t < matches.size(); ++t) {
      if (!timeline[m].truth[t].is_present) was_away[t] = names.count(t) > 0;
      const PublishedThing* match = MatchOf(timeline[m], matches[t]);
      if (match == nullptr) continue;
      const auto known = names.find(t);
      const bool is_same = known == names.end() || known->second == match->name;
      if (m >= from) {
        ++verdict.object_frames;
        if (was_away[t]) {
          ++verdict.returns;
          verdict.names_kept += is_same ? 1 : 0;
        } else if (!is_same) {
          ++verdict.switches;
        }
      }
      was_away[t] = false;
      names[t] = match->name;
    }
  }
  return verdict;
}

RestVerdict JudgeRests(const Timeline& timeline) {
  RestVerdict verdict;
  if (timeline.empty()) return verdict;
  const auto matches = MatchAll(timeline);
  for (std::size_t t = 0; t < timeline.front().truth.size(); ++t) {
    struct Rest {
      std::string name;
      Vector3 p_W = Vector3::Zero(), true_p_W = Vector3::Zero();
    };
    std::optional<Rest> before;  // the last rest that was measured
    const PublishedThing* settled = nullptr;
    std::size_t rest_begin = 0;
    for (std::size_t m = 0; m < timeline.size(); ++m) {
      const TrueThing& now = timeline[m].truth[t];
      const bool is_rest =
          m == 0 || (now.is_present && !now.is_moving && !HasEvent(timeline[m - 1].truth[t], now));
      if (!is_rest) {
        rest_begin = m;
        settled = nullptr;
        if (!now.is_present) before.reset();
        continue;
      }
      if (timeline[m].stamp_s - timeline[rest_begin].stamp_s < kSettled_s) continue;
      const PublishedThing* match = MatchOf(timeline[m], matches[m][t]);
      if (match == nullptr) continue;
      if (settled != nullptr) {
        if (match->name == settled->name && !IsSamePose(match->X_WO, settled->X_WO)) {
          ++verdict.jitter;
          const double shift_m = (match->X_WO.translation() - settled->X_WO.translation()).norm();
          verdict.lines.push_back(
              RestLine(timeline, m, t, match->name, "shifted at rest", shift_m));
        }
        settled = match;
        continue;
      }
      settled = match;
      const Rest rest{match->name, match->X_WO.translation(), now.X_WO.translation()};
      if (before && before->name == rest.name) {
        const double error_m =
            ((rest.p_W - before->p_W) - (rest.true_p_W - before->true_p_W)).norm();
        verdict.errors_m.push_back(error_m);
        if (error_m > kLargeRestError_m) {
          verdict.lines.push_back(
              RestLine(timeline, m, t, match->name, "is not where it came to rest", error_m));
        }
      }
      before = rest;
    }
  }
  return verdict;
}

}  // namespace cwm::benchmarks
