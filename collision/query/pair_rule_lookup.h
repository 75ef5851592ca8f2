// The rules of pairs as one call needs them: names are compared once a call, and once for each
// object that it meets.
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

// What rules say of two parts.
struct PairTerms {
  bool allowed = false;  // to collide: no question sees them
  bool has_margin = false;
  double margin_m = 0;  // in place of the usual one

  double Margin_m(double usual_m) const { return has_margin ? margin_m : usual_m; }
};

// One per call, used by one thread. Refers to the world and the body. Making it costs some tens of
// nanoseconds a rule; what rules say of an object is put together when it is first met.
class PairRuleLookup {
 public:
  PairRuleLookup(const WorldSnapshot& world, const QueryBody& body, const QueryOptions& options);

  // Of the body's parts with the object's, by the frame of the part; nullptr where no rule applies.
  // Valid while this is.
  const PairTerms* Of(const WorldObject& object) {
    return of_everything_.empty() && of_named_.empty() ? nullptr : Met(object);
  }
  // By self pair of the body; empty where no rule applies.
  std::span<const PairTerms> OfSelfPairs() const { return of_self_pairs_; }
  // The widest margin that a rule sets of any pair; 0 when none does.
  double widest_margin_m() const { return widest_margin_m_; }

 private:
  // A rule of which one side is the body, and that side: one frame of it, or all.
  struct Applied {
    int frame;
    const PairRule* rule;
    std::string_view theirs;  // the name of the other side
    std::int32_t next = -1;   // in of_named_: of the same bucket
  };

  void Add(const PairRule& rule);
  void Add(const PairRule& rule, const NamedThing& mine, const NamedThing& theirs);
  std::optional<int> FrameOf(const NamedThing& thing) const;
  void FillBuckets();
  std::size_t BucketOf(std::string_view name) const;
  const PairTerms* Met(const WorldObject& object);
  std::vector<PairTerms> TermsOf(std::span<const Applied> applied) const;
  void ResolveSelfPairs();

  const QueryBody& body_;
  std::vector<PairRule> ignored_;  // of the request
  std::vector<Applied> of_everything_;
  std::vector<PairTerms> terms_of_everything_;  // by frame
  std::vector<Applied> of_named_;
  std::vector<std::int32_t> buckets_;  // by hash of the name: the first of of_named_, or -1
  // Of objects that were met; empty for those that no rule names.
  std::unordered_map<const WorldObject*, std::vector<PairTerms>> met_;
  std::vector<const PairRule*> of_itself_;
  std::vector<PairTerms> of_self_pairs_;
  double widest_margin_m_ = 0;
};

}  // namespace cwm::collision
