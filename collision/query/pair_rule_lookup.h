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

// What rules say of the parts of a body and those of an obstacle. Valid while the lookup is.
class ObstacleTerms {
 public:
  ObstacleTerms() = default;  // no rule applies
  ObstacleTerms(const PairTerms* terms, const RobotGeometry* by_link)
      : terms_(terms), by_link_(by_link) {}

  bool empty() const { return terms_ == nullptr; }
  // Whether the parts of the obstacle, a robot, differ; else what is said of one is said of all.
  bool by_part() const { return by_link_ != nullptr; }
  const PairTerms& Of(int frame, std::size_t part) const {
    const auto row = static_cast<std::size_t>(frame);
    if (by_link_ == nullptr) return terms_[row];
    const auto link = static_cast<std::size_t>(by_link_->link_of_part[part]);
    return terms_[row * by_link_->model->links.size() + link];
  }

 private:
  const PairTerms* terms_ = nullptr;  // by frame of the body, and in it by link if by_link_ is set
  const RobotGeometry* by_link_ = nullptr;
};

// Used by one thread. Refers to the world and the body. Making it costs some tens of
// nanoseconds a rule; what rules say of an object is put together when it is first met.
class PairRuleLookup {
 public:
  PairRuleLookup(const WorldSnapshot& world, const QueryBody& body, const QueryOptions& options);

  ObstacleTerms Of(const Obstacle& obstacle) {
    return of_everything_.empty() && of_named_.empty() ? ObstacleTerms() : Met(obstacle);
  }
  // Whether some rule is about the body and what there is in the world.
  bool MayChangeWorldPairs() const { return !of_everything_.empty() || !of_named_.empty(); }
  // By self pair of the body; empty where no rule applies to any.
  std::span<const PairTerms> OfSelfPairs() const { return of_self_pairs_; }
  // The widest margin that a rule sets of the body and the world; 0 when none does.
  double widest_margin_m() const { return widest_margin_m_; }

 private:
  // A rule of which one side is the body, and that side: one frame of it, all that are its own
  // (kOwnFrames: what it carries has other names), or all.
  struct Applied {
    int frames;
    const PairRule* rule;
    const NamedThing* theirs;  // the other side
    std::int32_t next = -1;    // in of_named_: of the same bucket
  };
  // What is known of an obstacle that was met.
  struct Terms {
    std::vector<PairTerms> terms;  // empty: no rule names it
    const RobotGeometry* by_link = nullptr;
  };

  bool IsThere(const std::string& name) const;
  void AllowAttachment();
  void Add(const PairRule& rule);
  void Add(const PairRule& rule, const NamedThing& mine, const NamedThing& theirs);
  std::optional<int> FramesOf(const NamedThing& thing) const;
  bool Covers(int frames, int frame) const;
  void FillBuckets();
  std::size_t BucketOf(std::string_view name) const;
  ObstacleTerms Met(const Obstacle& obstacle);
  Terms TermsOf(std::span<const Applied> applied, const RobotGeometry* robot) const;
  void ResolveSelfPairs();

  const WorldSnapshot& world_;
  const QueryBody& body_;
  std::vector<PairRule> ignored_;  // of the request, and what the body is attached to
  std::vector<Applied> of_everything_;
  Terms terms_of_everything_;
  std::vector<Applied> of_named_;
  std::vector<std::int32_t> buckets_;  // by hash of the name: the first of of_named_, or -1
  std::unordered_map<const Obstacle*, Terms> met_;
  std::vector<const PairRule*> of_itself_;
  std::vector<PairTerms> of_self_pairs_;
  double widest_margin_m_ = 0;
};

}  // namespace cwm::collision
