#include "collision/world/pair_rule_transaction.h"

#include <cmath>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/geometry/validation.h"
#include "collision/world/apply_fault.h"

namespace cwm::collision {
namespace {

// Reports the fault of a pair with the field names of the change.
absl::Status CheckPairOf(const NamedPair& pair) {
  const absl::Status status = CheckPair(pair);
  const std::optional<FieldRule> fault = FieldRuleOf(status);
  return fault ? InvalidFieldError(absl::StrCat("pair.", fault->field), fault->rule) : status;
}

}  // namespace

absl::Status PairRuleTransaction::Allow(const AllowCollision& allow) {
  if (absl::Status status = CheckPairOf(allow.pair); !status.ok()) return status;
  if (allow.withdraw && allow.expires.has_value()) {
    return InvalidFieldError("expires_after",
                             "is given, must be absent: what is withdrawn cannot expire");
  }
  if (allow.check && allow.withdraw) {
    return InvalidFieldError("check", "is true, must be false: what is withdrawn is not checked");
  }
  if (allow.check && allow.expires.has_value()) {
    return InvalidFieldError("expires_after",
                             "is given, must be absent: a check lasts until it is withdrawn");
  }
  PairRule rule = Current(Ordered(allow.pair));
  rule.allowed = !allow.withdraw && !allow.check;
  rule.check = allow.check && AreLinksOfOneRobot(allow.pair);
  rule.expires = allow.expires;
  return Touch(std::move(rule));
}

absl::Status PairRuleTransaction::SetMargin(const SetPairMargin& set) {
  if (absl::Status status = CheckPairOf(set.pair); !status.ok()) return status;
  const double margin_m = set.margin_m.value_or(0);
  if (!(margin_m >= 0 && margin_m <= kMaxCoordinate_m)) {
    return InvalidFieldError(
        "margin_m", absl::StrCat("is ", margin_m, ", must be finite, not negative and at most ",
                                 kMaxCoordinate_m));
  }
  PairRule rule = Current(Ordered(set.pair));
  rule.margin_m = set.margin_m;
  return Touch(std::move(rule));
}

void PairRuleTransaction::Expire(const ExpireRules& expire) {
  PairRules over;
  const auto note = [&](const PairRule& rule) {
    if (rule.expires.has_value() && rule.expires->due <= expire.now) over.push_back(rule);
  };
  for (const PairRule& rule : base_) {
    if (touched_.find(rule.pair) == touched_.end()) note(rule);
  }
  for (const auto& [pair, rule] : touched_) note(rule);
  for (PairRule& rule : over) {
    rule.allowed = false;
    rule.expires = std::nullopt;
    static_cast<void>(Touch(std::move(rule)));  // only new rules are refused
  }
}

std::shared_ptr<const PairRules> PairRuleTransaction::Finish() {
  if (touched_.empty()) return nullptr;
  PairRules rules;
  rules.reserve(count_);
  const auto add = [&](const PairRule& rule) {
    if (!rule.IsEmpty()) rules.push_back(rule);
  };
  auto touched = touched_.begin();
  for (const PairRule& rule : base_) {
    for (; touched != touched_.end() && touched->first < rule.pair; ++touched) add(touched->second);
    if (touched != touched_.end() && touched->first == rule.pair) {
      add((touched++)->second);
    } else {
      add(rule);
    }
  }
  for (; touched != touched_.end(); ++touched) add(touched->second);
  if (rules == base_) return nullptr;
  return std::make_shared<const PairRules>(std::move(rules));
}

PairRule PairRuleTransaction::Current(const NamedPair& pair) const {
  const auto at = touched_.find(pair);
  if (at != touched_.end()) return at->second;
  const PairRule* rule = FindRule(base_, pair);
  return rule != nullptr ? *rule : PairRule{.pair = pair};
}

absl::Status PairRuleTransaction::Touch(PairRule rule) {
  const bool was = !Current(rule.pair).IsEmpty(), is = !rule.IsEmpty();
  if (is && !was && count_ >= kMaxPairRules) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "the world has ", count_, " rules of pairs, must have at most ", kMaxPairRules));
  }
  if (is && !was) ++count_;
  if (was && !is) --count_;
  NamedPair pair = rule.pair;
  touched_[std::move(pair)] = std::move(rule);
  return absl::OkStatus();
}

}  // namespace cwm::collision
