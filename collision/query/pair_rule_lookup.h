// The pair rules in the form that one query needs: names are compared once per query, and once for
// each object that it meets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "collision/query/query.h"

namespace cwm::collision {

// The combined rules for two parts.
struct EffectiveRule {
  bool allowed = false;  // allowed to collide: queries ignore the pair
  bool has_margin = false;
  double margin_m = 0;  // replaces the usual margin if has_margin

  double Margin_m(double default_m) const { return has_margin ? margin_m : default_m; }
};

// The combination of several rules about the same two parts, which refers to them.
struct CombinedRule {
  bool allowed = false;
  const PairRule* margin = nullptr;  // the rule whose margin applies

  void Add(const PairRule& rule);
  void Add(const CombinedRule& other);
  EffectiveRule Effective() const {
    return {.allowed = allowed,
            .has_margin = margin != nullptr,
            .margin_m = margin != nullptr ? *margin->margin_m : 0};
  }
};

// The combined rules for the parts of a body and the parts of an obstacle. Valid as long as the
// lookup.
class ObstacleRules {
 public:
  ObstacleRules() = default;  // no rule applies
  ObstacleRules(const EffectiveRule* rules, const RobotGeometry* by_link)
      : rules_(rules), by_link_(by_link) {}

  bool empty() const { return rules_ == nullptr; }
  // True if the rules differ between parts of the obstacle, which is then a robot.
  bool by_part() const { return by_link_ != nullptr; }
  const EffectiveRule& At(int frame, std::size_t part) const {
    const auto row = static_cast<std::size_t>(frame);
    if (by_link_ == nullptr) return rules_[row];
    const auto link = static_cast<std::size_t>(by_link_->link_of_part[part]);
    return rules_[row * by_link_->model->links.size() + link];
  }

 private:
  const EffectiveRule* rules_ = nullptr;  // by frame of the body, then by link if by_link_ is set
  const RobotGeometry* by_link_ = nullptr;
};

// Used by one thread. Refers to the world and the body. Construction takes some tens of nanoseconds
// per rule; the rules for an object are combined when it is first met.
class PairRuleLookup {
 public:
  PairRuleLookup(const WorldSnapshot& world, const QueryBody& body, const QueryOptions& options);

  ObstacleRules RulesOf(const Obstacle& obstacle) {
    return of_everything_.empty() && of_named_.empty() ? ObstacleRules() : LookUp(obstacle);
  }
  // By frame of the body: frames with the same number have the same rules for every obstacle.
  std::vector<int> FrameClasses() const;
  // True if some rule applies to the body and an obstacle of the world.
  bool MayChangeWorldPairs() const { return !of_everything_.empty() || !of_named_.empty(); }
  // The rules for the self pairs of the body, by pair; empty if no rule applies to any.
  std::span<const EffectiveRule> SelfPairRules() const { return of_self_pairs_; }
  // The largest margin that a rule sets for the body and the world; 0 if none does.
  double max_margin_m() const { return max_margin_m_; }

 private:
  // A rule with the body on one side. `frames` is that side: one frame of the body, all its own
  // frames (kOwnFrames, without attached objects, which have other names), or all frames
  // (kAllFrames).
  struct AppliedRule {
    int frames;
    const PairRule* rule;
    const NamedThing* theirs;  // the other side
    std::int32_t next = -1;    // next entry of the same bucket in of_named_
  };
  // The combined rules for an obstacle that was met.
  struct RuleTable {
    std::vector<EffectiveRule> rules;  // empty: no rule names it
    const RobotGeometry* by_link = nullptr;
  };

  bool Exists(const std::string& name) const;
  void AllowAttachment();
  void AllowSelfOnlyFrames();
  void Add(const PairRule& rule);
  void Add(const PairRule& rule, const NamedThing& mine, const NamedThing& theirs);
  std::optional<int> FramesOf(const NamedThing& thing) const;
  bool Covers(int frames, int frame) const;
  void FillBuckets();
  std::size_t BucketOf(std::string_view name) const;
  ObstacleRules LookUp(const Obstacle& obstacle);
  RuleTable CombineRules(std::span<const AppliedRule> applied, const RobotGeometry* robot) const;
  void ResolveSelfPairs();

  const WorldSnapshot& world_;
  const QueryBody& body_;
  std::vector<PairRule> ignored_;  // from the request and from the body's attachment
  std::vector<AppliedRule> of_everything_;
  RuleTable rules_of_everything_;
  std::vector<AppliedRule> of_named_;
  std::vector<std::int32_t> buckets_;  // by hash of the name: first entry in of_named_, or -1
  std::unordered_map<const Obstacle*, RuleTable> rules_by_obstacle_;
  std::vector<const PairRule*> of_itself_;
  std::vector<EffectiveRule> of_self_pairs_;
  double max_margin_m_ = 0;
};

}  // namespace cwm::collision
