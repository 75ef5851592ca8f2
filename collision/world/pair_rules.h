// Rules for pairs of objects or robots beyond their shapes: allowed collisions and margins. Plain
// values, ordered by the names of the pair.
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

// The end of an allowance on two clocks, both read when it is accepted. Only the steady clock
// decides when it ends, so that setting the wall clock has no effect on it.
struct Expiry {
  SteadyTime due;
  WallTime wall_time;  // for clients
  friend bool operator==(const Expiry&, const Expiry&) = default;
};
// The end of an allowance for `duration` from now.
Expiry ExpiryAfter(std::chrono::nanoseconds duration,
                   SteadyTime steady_now = std::chrono::steady_clock::now(),
                   WallTime wall_now = std::chrono::system_clock::now());

// The name that matches everything, including bodies without a name.
inline constexpr char kEverything[] = "*";

// An item of the world, whether or not it exists: an object, a robot with all its links, or one
// link.
struct NamedThing {
  std::string name;       // of an object or a robot, or kEverything
  std::string link = {};  // of the robot; empty for all its links
  friend auto operator<=>(const NamedThing&, const NamedThing&) = default;
};

// Two items in either order. Rules, and functions that compare pairs, have them in the order of
// Ordered.
struct NamedPair {
  NamedThing a, b;
  friend auto operator<=>(const NamedPair&, const NamedPair&) = default;
};
NamedPair Ordered(NamedPair pair);

// True if both are links of the robot of one name.
bool AreLinksOfOneRobot(const NamedPair& pair);

// The number of names, except kEverything, and of links in a pair: 0 to 4. If several rules have a
// margin, the one with the highest number applies, and among equals the first in order.
int Specificity(const NamedPair& pair);

// InvalidArgument ("a.name", "b.link" and the like, see FieldRuleOf) for a name that no object or
// robot can have, for the name of a link that no robot can have, and for a link of kEverything.
absl::Status CheckPair(const NamedPair& pair);
// InvalidArgument for a link that the present owner of the name does not have. Names without an
// owner are accepted.
struct NameOwner {
  const RobotModel* robot = nullptr;
  bool is_object = false;
};
absl::Status CheckLinks(const NamedPair& pair,
                        const std::function<NameOwner(const std::string& name)>& owner_of);

struct PairRule {
  NamedPair pair;                       // as Ordered returns it
  bool allowed = false;                 // the pair may collide: queries ignore it
  std::optional<Expiry> expires = {};   // the end of `allowed`; absent: never
  std::optional<double> margin_m = {};  // replaces the margins of both items and of the request
  // The pair, two links of one robot, is checked although the SRDF disables it, or although they
  // are fixed to each other. Never together with `allowed`.
  bool check = false;
  bool IsEmpty() const { return !allowed && !margin_m.has_value() && !check; }
  friend bool operator==(const PairRule&, const PairRule&) = default;
};

// Ordered by pair, each pair once, without empty rules.
using PairRules = std::vector<PairRule>;

// The time when the first allowance ends; empty if none does.
std::optional<SteadyTime> NextExpiry(const PairRules& rules);

// One difference; `before` or `after` is empty (IsEmpty) if there is no such rule.
struct PairRuleDelta {
  PairRule before, after;
};
std::vector<PairRuleDelta> RuleDifference(const PairRules& before, const PairRules& after);

// The rule of exactly this pair, which is Ordered; nullptr if there is none.
const PairRule* FindRule(const PairRules& rules, const NamedPair& pair);
// Replaces or adds the rule of its pair; removes it if the rule is empty.
void SetRule(PairRules& rules, PairRule rule);

}  // namespace cwm::collision
