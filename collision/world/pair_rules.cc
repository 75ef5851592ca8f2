#include "collision/world/pair_rules.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/robot/robot_model.h"
#include "collision/world/apply_fault.h"
#include "collision/world/world_object.h"

namespace cwm::collision {
namespace {

bool IsEverything(const NamedThing& thing) { return thing.name == kEverything; }

// True if `name` may be the name of a link in a robot's files.
bool IsLinkName(const std::string& name) {
  constexpr std::size_t kMaxLinkNameBytes = 256;
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  return name.size() <= kMaxLinkNameBytes && std::none_of(name.begin(), name.end(), is_control);
}

absl::Status CheckNamed(const NamedThing& thing, const std::string& field) {
  if (!IsEverything(thing) && !IsValidName(thing.name)) {
    const std::string shown = IsLinkName(thing.name) ? thing.name : "?";
    return InvalidFieldError(
        field + ".name",
        absl::StrCat("'", shown, "' must be \"*\", or 1 to 128 letters, digits or \"_-./\""));
  }
  if (IsEverything(thing) && !thing.link.empty()) {
    return InvalidFieldError(field + ".link",
                             "is given, must be empty: the name is \"*\", not a robot's");
  }
  if (!IsLinkName(thing.link)) {
    return InvalidFieldError(field + ".link",
                             "must be at most 256 bytes without control characters");
  }
  return absl::OkStatus();
}

// The first rule whose pair is not less.
template <class Rules>
auto LowerBound(Rules& rules, const NamedPair& pair) {
  return std::lower_bound(rules.begin(), rules.end(), pair,
                          [](const PairRule& rule, const NamedPair& p) { return rule.pair < p; });
}

}  // namespace

NamedPair Ordered(NamedPair pair) {
  if (pair.b < pair.a) std::swap(pair.a, pair.b);
  return pair;
}

bool AreLinksOfOneRobot(const NamedPair& pair) {
  return pair.a.name == pair.b.name && !pair.a.link.empty() && !pair.b.link.empty() &&
         pair.a.link != pair.b.link;
}

int Specificity(const NamedPair& pair) {
  const auto of = [](const NamedThing& thing) {
    return (IsEverything(thing) ? 0 : 1) + (thing.link.empty() ? 0 : 1);
  };
  return of(pair.a) + of(pair.b);
}

absl::Status CheckPair(const NamedPair& pair) {
  if (absl::Status status = CheckNamed(pair.a, "a"); !status.ok()) return status;
  return CheckNamed(pair.b, "b");
}

absl::Status CheckLinks(const NamedPair& pair,
                        const std::function<NameOwner(const std::string& name)>& owner_of) {
  const auto check = [&](const NamedThing& thing, const char* field) {
    if (thing.link.empty()) return absl::OkStatus();
    const NameOwner owner = owner_of(thing.name);
    if (owner.is_object) {
      return InvalidFieldError(field,
                               absl::StrCat("is '", thing.link, "', must be empty: '", thing.name,
                                            "' is an object, which has no links"));
    }
    if (owner.robot == nullptr || owner.robot->FindLink(thing.link).has_value()) {
      return absl::OkStatus();
    }
    return InvalidFieldError(
        field, absl::StrCat("is '", thing.link, "', must be a link of robot '", thing.name, "'"));
  };
  if (absl::Status status = check(pair.a, "a.link"); !status.ok()) return status;
  return check(pair.b, "b.link");
}

Expiry ExpiryAfter(std::chrono::nanoseconds duration, SteadyTime steady_now, WallTime wall_now) {
  return {.due = steady_now + std::chrono::duration_cast<SteadyTime::duration>(duration),
          .wall_time = wall_now + std::chrono::duration_cast<WallTime::duration>(duration)};
}

std::optional<SteadyTime> NextExpiry(const PairRules& rules) {
  std::optional<SteadyTime> next;
  for (const PairRule& rule : rules) {
    if (!rule.expires.has_value()) continue;
    next = std::min(next.value_or(rule.expires->due), rule.expires->due);
  }
  return next;
}

std::vector<PairRuleDelta> RuleDifference(const PairRules& before, const PairRules& after) {
  std::vector<PairRuleDelta> deltas;
  if (&before == &after) return deltas;
  auto a = before.begin(), b = after.begin();
  while (a != before.end() || b != after.end()) {
    if (b == after.end() || (a != before.end() && a->pair < b->pair)) {
      deltas.push_back({.before = *a, .after = {.pair = a->pair}});
      ++a;
    } else if (a == before.end() || b->pair < a->pair) {
      deltas.push_back({.before = {.pair = b->pair}, .after = *b});
      ++b;
    } else {
      if (*a != *b) deltas.push_back({.before = *a, .after = *b});
      ++a, ++b;
    }
  }
  return deltas;
}

void SetRule(PairRules& rules, PairRule rule) {
  const auto at = LowerBound(rules, rule.pair);
  const bool is_known = at != rules.end() && at->pair == rule.pair;
  if (rule.IsEmpty()) {
    if (is_known) rules.erase(at);
  } else if (is_known) {
    *at = std::move(rule);
  } else {
    rules.insert(at, std::move(rule));
  }
}

const PairRule* FindRule(const PairRules& rules, const NamedPair& pair) {
  const auto at = LowerBound(rules, pair);
  return at != rules.end() && at->pair == pair ? &*at : nullptr;
}

}  // namespace cwm::collision
