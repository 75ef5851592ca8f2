// The rules of pairs while a list of changes is applied.
#pragma once

#include <cstddef>
#include <map>
#include <memory>

#include "absl/status/status.h"
#include "collision/world/world_snapshot.h"

namespace cwm::collision {

// The rules that a list touches, over an untouched base, which outlives it.
class PairRuleTransaction {
 public:
  explicit PairRuleTransaction(const WorldSnapshot& base)
      : base_(base.pair_rules()), count_(base_.size()) {}

  absl::Status Allow(const AllowCollision& allow);
  absl::Status SetMargin(const SetPairMargin& set);
  void Expire(const ExpireRules& expire);

  // All rules of the next revision; nullptr when they are those of the base.
  std::shared_ptr<const PairRules> Finish();

 private:
  PairRule Current(const NamedPair& pair) const;  // one that says nothing where there is none
  absl::Status Touch(PairRule rule);

  const PairRules& base_;
  std::size_t count_;  // of rules that say something
  std::map<NamedPair, PairRule> touched_;
};

}  // namespace cwm::collision
