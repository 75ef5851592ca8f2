#include "collision/query/pair_rule_lookup.h"

#include <algorithm>
#include <bit>

namespace cwm::collision {
namespace {

constexpr int kAllFrames = -1;

// What several rules say together of the same two parts.
struct Together {
  bool allowed = false;
  const PairRule* margin = nullptr;  // the rule whose margin holds

  void Add(const PairRule& rule) {
    allowed |= rule.allowed;
    if (rule.margin_m.has_value() && (margin == nullptr || Precedes(rule, *margin))) margin = &rule;
  }
  void Add(const Together& other) {
    allowed |= other.allowed;
    if (other.margin != nullptr) Add(*other.margin);
  }
  PairTerms Terms() const {
    return {.allowed = allowed,
            .has_margin = margin != nullptr,
            .margin_m = margin != nullptr ? *margin->margin_m : 0};
  }

 private:
  static bool Precedes(const PairRule& a, const PairRule& b) {
    const int precision_a = Precision(a.pair), precision_b = Precision(b.pair);
    return precision_a != precision_b ? precision_a > precision_b : a.pair < b.pair;
  }
};

}  // namespace

PairRuleLookup::PairRuleLookup(const WorldSnapshot& world, const QueryBody& body,
                               const QueryOptions& options)
    : body_(body) {
  ignored_.reserve(options.ignore_pairs.size());
  for (const NamedPair& pair : options.ignore_pairs) {
    ignored_.push_back({.pair = Ordered(pair), .allowed = true});
  }
  for (const PairRule& rule : world.pair_rules()) Add(rule);
  for (const PairRule& rule : ignored_) Add(rule);
  if (!of_everything_.empty()) terms_of_everything_ = TermsOf(of_everything_);
  if (!of_named_.empty()) FillBuckets();
  if (!of_itself_.empty()) ResolveSelfPairs();
}

void PairRuleLookup::Add(const PairRule& rule) {
  const auto& [a, b] = rule.pair;
  Add(rule, a, b);
  if (a != b) Add(rule, b, a);
  if (body_.self_pairs.empty()) return;
  if (FrameOf(a).has_value() && FrameOf(b).has_value()) of_itself_.push_back(&rule);
}

void PairRuleLookup::Add(const PairRule& rule, const NamedThing& mine, const NamedThing& theirs) {
  if (!theirs.link.empty()) return;  // objects have none
  const std::optional<int> frame = FrameOf(mine);
  if (!frame.has_value()) return;
  auto& applied = theirs.name == kEverything ? of_everything_ : of_named_;
  applied.push_back({*frame, &rule, theirs.name});
  widest_margin_m_ = std::max(widest_margin_m_, rule.margin_m.value_or(0));
}

// That of the body which the thing includes, kAllFrames, or nothing.
std::optional<int> PairRuleLookup::FrameOf(const NamedThing& thing) const {
  if (thing.name == kEverything) return kAllFrames;
  if (body_.self.empty() || thing.name != body_.self) return std::nullopt;
  if (thing.link.empty()) return kAllFrames;
  return body_.robot != nullptr ? body_.robot->FindLink(thing.link) : std::nullopt;
}

void PairRuleLookup::FillBuckets() {
  buckets_.assign(std::bit_ceil(2 * of_named_.size()), -1);
  for (std::size_t i = 0; i < of_named_.size(); ++i) {
    std::int32_t& first = buckets_[BucketOf(of_named_[i].theirs)];
    of_named_[i].next = first;
    first = static_cast<std::int32_t>(i);
  }
}

std::size_t PairRuleLookup::BucketOf(std::string_view name) const {
  return static_cast<std::size_t>(HashOf(name)) & (buckets_.size() - 1);
}

const PairTerms* PairRuleLookup::Met(const WorldObject& object) {
  const auto [at, is_new] = met_.try_emplace(&object);
  if (is_new && !of_named_.empty()) {
    std::vector<Applied> applied;
    for (std::int32_t i = buckets_[BucketOf(object.name)]; i >= 0;) {
      const Applied& each = of_named_[static_cast<std::size_t>(i)];
      if (each.theirs == object.name) applied.push_back(each);
      i = each.next;
    }
    if (!applied.empty()) {  // rules of everything are about it as well
      applied.insert(applied.end(), of_everything_.begin(), of_everything_.end());
      at->second = TermsOf(applied);
    }
  }
  if (!at->second.empty()) return at->second.data();
  return terms_of_everything_.empty() ? nullptr : terms_of_everything_.data();
}

std::vector<PairTerms> PairRuleLookup::TermsOf(std::span<const Applied> applied) const {
  std::vector<Together> together(static_cast<std::size_t>(body_.frame_count));
  for (const Applied& each : applied) {
    if (each.frame != kAllFrames) {
      together[static_cast<std::size_t>(each.frame)].Add(*each.rule);
    } else {
      for (Together& frame : together) frame.Add(*each.rule);
    }
  }
  std::vector<PairTerms> terms;
  terms.reserve(together.size());
  for (const Together& frame : together) terms.push_back(frame.Terms());
  return terms;
}

// A rule is about two frames, one with all, or all with all.
void PairRuleLookup::ResolveSelfPairs() {
  const auto frames = static_cast<std::size_t>(body_.frame_count);
  Together all;
  std::vector<Together> one(frames);
  std::unordered_map<std::size_t, Together> two;
  const auto key = [&](int a, int b) {
    return static_cast<std::size_t>(std::min(a, b)) * frames +
           static_cast<std::size_t>(std::max(a, b));
  };
  for (const PairRule* rule : of_itself_) {
    const int a = *FrameOf(rule->pair.a), b = *FrameOf(rule->pair.b);
    if (a != kAllFrames && b != kAllFrames) {
      two[key(a, b)].Add(*rule);
    } else if (a != kAllFrames || b != kAllFrames) {
      one[static_cast<std::size_t>(std::max(a, b))].Add(*rule);
    } else {
      all.Add(*rule);
    }
  }
  const auto frame_of = [&](std::int32_t part) {
    return body_.frame_of_part.empty() ? 0 : body_.frame_of_part[static_cast<std::size_t>(part)];
  };
  for (const auto& [first, second] : body_.self_pairs) {
    const int a = frame_of(first), b = frame_of(second);
    Together pair = all;
    pair.Add(one[static_cast<std::size_t>(a)]);
    pair.Add(one[static_cast<std::size_t>(b)]);
    if (const auto at = two.find(key(a, b)); at != two.end()) pair.Add(at->second);
    of_self_pairs_.push_back(pair.Terms());
  }
}

}  // namespace cwm::collision
