// Rules of pairs: what holds between two things of a world beside their shapes. Values, ordered by
// the names of the pair.
#pragma once

#include <chrono>
#include <compare>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"

namespace cwm::collision {

struct RobotModel;  // robot/robot_model.h

using WallTime = std::chrono::system_clock::time_point;
using SteadyTime = std::chrono::steady_clock::time_point;

// The end of an allowance on two clocks, both read when it is accepted. The steady clock alone decides
// when it is over: a wall clock that is set later neither lengthens nor shortens it.
struct Expiry {
  SteadyTime due;
  WallTime wall_time;  // as clients are told
  friend bool operator==(const Expiry&, const Expiry&) = default;
};
// The end of what is allowed for `duration` from now.
Expiry ExpiryAfter(std::chrono::nanoseconds duration,
                   SteadyTime steady_now = std::chrono::steady_clock::now(),
                   WallTime wall_now = std::chrono::system_clock::now());

// The name of everything, bodies without a name included.
inline constexpr char kEverything[] = "*";

// Something of a world, there or not: an object, a robot with all its links, or one link.
struct NamedThing {
  std::string name;       // of an object or a robot, or kEverything
  std::string link = {};  // of the robot; empty: all of it
  friend auto operator<=>(const NamedThing&, const NamedThing&) = default;
};

// In either order: a rule and all that compares them have it as Ordered makes it.
struct NamedPair {
  NamedThing a, b;
  friend auto operator<=>(const NamedPair&, const NamedPair&) = default;
};
NamedPair Ordered(NamedPair pair);

// How many names, kEverything not counted, and links a pair has: 0 to 4. Of the margins of several
// rules that of the highest number holds, among equals that of the first in order.
int Precision(const NamedPair& pair);

// InvalidArgument ("a.name", "b.link" and the like, see FieldRuleOf) for a name that no object or
// robot can have, for one of a link that no robot can have, and for a link of everything.
absl::Status CheckPair(const NamedPair& pair);
// The same for a link that what has the name now does not have. Of a name that nothing has nothing
// is known.
struct NameOwner {
  const RobotModel* robot = nullptr;
  bool is_object = false;
};
absl::Status CheckLinks(const NamedPair& pair,
                        const std::function<NameOwner(const std::string& name)>& owner_of);

struct PairRule {
  NamedPair pair;                       // Ordered
  bool allowed = false;                 // to collide: no question sees the pair
  std::optional<Expiry> expires = {};   // of `allowed`, which then ends; absent: never
  std::optional<double> margin_m = {};  // in place of the margins of the two and of the request
  bool SaysNothing() const { return !allowed && !margin_m.has_value(); }
  friend bool operator==(const PairRule&, const PairRule&) = default;
};

// By pair, none twice, none that says nothing.
using PairRules = std::vector<PairRule>;

// When the first allowance ends; nothing when none does.
std::optional<SteadyTime> NextExpiry(const PairRules& rules);

// What differs: `before` or `after` says nothing where there is no such rule.
struct PairRuleDelta {
  PairRule before, after;
};
std::vector<PairRuleDelta> RuleDifference(const PairRules& before, const PairRules& after);

// nullptr when there is none of the very pair, which is Ordered.
const PairRule* FindRule(const PairRules& rules, const NamedPair& pair);
// `rules` with the rule in place of the one of its pair; without it when the rule says nothing.
void SetRule(PairRules& rules, PairRule rule);

}  // namespace cwm::collision
