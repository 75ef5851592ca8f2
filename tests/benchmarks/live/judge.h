// Judges a published world against the truth, over time. Nothing here knows names of the truth or
// how the world is made: published objects belong to true things by place and size alone.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "tests/benchmarks/live/timeline.h"

namespace cwm::benchmarks {

// chosen: a published object may be a true thing if their centres are at most this share of the
// true diagonal apart, and their diagonals differ by at most a factor of kMaxSizeRatio. Half of a
// thing may be unseen, and completed wrongly.
inline constexpr double kMaxCenterShare = 0.4;
inline constexpr double kMaxSizeRatio = 2;

// By true thing, the index of the published object that is it, of the kind kThing; -1: none. One to
// one, nearest centres first. Absent things have none.
std::vector<int> MatchThings(const Moment& moment);

// chosen: how long after a true event a change may still be due to it: regions are interpreted
// after 0.3 s at rest.
inline constexpr double kConsequence_s = 1.5;

// Changes between the published worlds of consecutive moments, of the kind kThing.
struct ChangeCounts {
  int added = 0, removed = 0, moved = 0, replaced = 0;
  int sum() const { return added + removed + moved + replaced; }
};
struct ChangeVerdict {
  ChangeCounts all = {};
  // Without an event of the true thing (it appears, vanishes, moves, or is seen for the first time)
  // within kConsequence_s before. A change of an object that is no true thing is false. A thing
  // that is added late, but for the first time since its event, is not.
  ChangeCounts unfounded = {};
  std::vector<std::string> lines = {};  // each unfounded change in words
};
// Moments before `from` are only history.
ChangeVerdict JudgeChanges(const Timeline& timeline, std::size_t from);

// A true event, and when the published world first showed it.
struct Notice {
  enum class Kind { kAdded, kRemoved, kMoved };
  Kind kind = Kind::kAdded;
  std::size_t thing = 0;
  std::size_t moment = 0;  // the first in which it shows
  double distance_m = 0;   // of a move, until the thing rests
  // Moments and seconds from the first moment that shows the event to the first whose published
  // world does, 0 for the same one; empty if it did not until the thing's next event.
  std::optional<int> moments = {};
  std::optional<double> time_s = {};
};
// All events of visible things from the moment `from` on. Added: an object of
// whatever kind, of at most kMaxSizeRatio of its size, is published at its place, and none was
// before. Removed: one was, and none is any more. Moved: its object is published as
// moving, or at least half of the distance from where it was published before.
std::vector<Notice> JudgeNotices(const Timeline& timeline, std::size_t from);

struct IdentityVerdict {
  long object_frames = 0;  // matched pairs of a true thing and a moment
  int switches = 0;        // a thing is matched under another name than the last time
  int returns = 0;         // a thing vanished and came back, and was matched again
  int names_kept = 0;      // of these, those with the name that they had
};
// A return is no switch, whatever its name.
IdentityVerdict JudgeIdentity(const Timeline& timeline, std::size_t from);

struct RestVerdict {
  // By thing and rest, metres: the difference of the published and the true displacement since the
  // rest before, so that the origins of published frames and errors of their shapes do not count.
  std::vector<double> errors_m = {};
  // The number of poses of one object beyond the first, during rests from kSettled_s on.
  int jitter = 0;
  // In words, each error of more than kLargeRestError_m and each further pose.
  std::vector<std::string> lines = {};
};
inline constexpr double kLargeRestError_m = 0.002;
inline constexpr double kSettled_s = 1;
RestVerdict JudgeRests(const Timeline& timeline);

}  // namespace cwm::benchmarks
