// The pair rules while a list of changes is applied.
#pragma once

#include <cstddef>
#include <map>
#include <memory>

#include "absl/status/status.h"
#include "collision/world/world_snapshot.h"

namespace cwm::collision {

// The rules that a list touches, over an unchanged base, which must outlive this object.
class PairRuleTransaction {
 public:
  explicit PairRuleTransaction(const WorldSnapshot& base)
      : base_(base.pair_rules()), count_(base_.size()) {}

  absl::Status Allow(const AllowCollision& allow);
  absl::Status SetMargin(const SetPairMargin& set);
  void Expire(const ExpireRules& expire);

  // All rules of the next revision; nullptr if they are those of the base.
  std::shared_ptr<const PairRules> Finish();

 private:
  PairRule Current(const NamedPair& pair) const;  // an empty rule if there is none
  absl::Status Touch(PairRule rule);

  const PairRules& base_;
  std::size_t count_;  // number of rules that are not empty
  std::map<NamedPair, PairRule> touched_;
};

}  // namespace cwm::collision
