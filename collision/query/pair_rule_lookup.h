// The rules of pairs as one call needs them: names are compared once a call, and once for each object
// that it meets and that rules name.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "collision/query/query.h"

namespace cwm::collision {

// What rules say of two parts.
struct PairTerms {
  bool allowed = false;  // to collide: no question sees them
  bool has_margin = false;
  double margin_m = 0;  // in place of the usual one

  double Margin_m(double usual_m) const { return has_margin ? margin_m : usual_m; }
};

// One per call, used by one thread. Refers to the world and the body.
class PairRuleLookup {
 public:
  PairRuleLookup(const WorldSnapshot& world, const QueryBody& body, const QueryOptions& options);

  // Of the body's parts with the object's, by the frame of the part; nullptr where no rule applies.
  // Valid while this is.
  const PairTerms* Of(const WorldObject& object) {
    if (everything_.rules.empty() && by_object_.empty()) return nullptr;
    return Named(object);
  }
  // By self pair of the body; empty where no rule applies.
  std::span<const PairTerms> OfSelfPairs() const { return of_self_pairs_; }
  // The widest margin that a rule sets of any pair; 0 when none does.
  double widest_margin_m() const { return widest_margin_m_; }

 private:
  // A rule of which one side is the body, and that side: one frame of it, or kAllFrames.
  struct Applied {
    int frame;
    const PairRule* rule;
  };
  struct Rules {
    std::vector<Applied> rules;
    std::vector<PairTerms> terms;  // by frame; made when they are first asked for
  };

  void Add(const PairRule& rule);
  void Add(const PairRule& rule, const NamedThing& mine, const NamedThing& theirs);
  void AddToSelfPairs(const PairRule& rule);
  std::optional<int> FrameOf(const NamedThing& thing) const;
  const PairTerms* Named(const WorldObject& object);
  void Resolve(Rules& rules) const;
  void ResolveSelfPairs();

  const WorldSnapshot& world_;
  const QueryBody& body_;
  std::vector<PairRule> ignored_;  // of the request
  Rules everything_;               // rules of the body with all there is
  std::unordered_map<const WorldObject*, Rules> by_object_;
  std::vector<const PairRule*> of_itself_;
  std::vector<PairTerms> of_self_pairs_;
  double widest_margin_m_ = 0;
};

}  // namespace cwm::collision
