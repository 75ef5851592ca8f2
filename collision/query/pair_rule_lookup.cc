#include "collision/query/pair_rule_lookup.h"

#include <algorithm>
#include <cstddef>
#include <optional>

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
    : world_(world), body_(body) {
  ignored_.reserve(options.ignore_pairs.size());
  for (const NamedPair& pair : options.ignore_pairs) {
    ignored_.push_back({.pair = Ordered(pair), .allowed = true});
  }
  for (const PairRule& rule : world.pair_rules()) Add(rule);
  for (const PairRule& rule : ignored_) Add(rule);
  if (!everything_.rules.empty()) Resolve(everything_);
  if (!of_itself_.empty()) ResolveSelfPairs();
}

void PairRuleLookup::Add(const PairRule& rule) {
  Add(rule, rule.pair.a, rule.pair.b);
  if (rule.pair.a != rule.pair.b) Add(rule, rule.pair.b, rule.pair.a);
  AddToSelfPairs(rule);
}

void PairRuleLookup::Add(const PairRule& rule, const NamedThing& mine, const NamedThing& theirs) {
  const std::optional<int> frame = FrameOf(mine);
  if (!frame.has_value()) return;
  Rules* rules = &everything_;
  if (theirs.name != kEverything) {
    const WorldObjectPtr* object = world_.objects().Find(theirs.name);
    if (object == nullptr || !theirs.link.empty()) return;
    rules = &by_object_[object->get()];
  }
  rules->rules.push_back({*frame, &rule});
  widest_margin_m_ = std::max(widest_margin_m_, rule.margin_m.value_or(0));
}

void PairRuleLookup::AddToSelfPairs(const PairRule& rule) {
  if (body_.self_pairs.empty()) return;
  if (!FrameOf(rule.pair.a).has_value() || !FrameOf(rule.pair.b).has_value()) return;
  of_itself_.push_back(&rule);
}

// That of the body which the thing includes, kAllFrames, or nothing.
std::optional<int> PairRuleLookup::FrameOf(const NamedThing& thing) const {
  if (thing.name == kEverything) return kAllFrames;
  if (body_.self.empty() || thing.name != body_.self) return std::nullopt;
  if (thing.link.empty()) return kAllFrames;
  return body_.robot != nullptr ? body_.robot->FindLink(thing.link) : std::nullopt;
}

const PairTerms* PairRuleLookup::Named(const WorldObject& object) {
  const auto at = by_object_.find(&object);
  if (at == by_object_.end()) {
    return everything_.terms.empty() ? nullptr : everything_.terms.data();
  }
  if (at->second.terms.empty()) Resolve(at->second);
  return at->second.terms.data();
}

// Rules of everything are those of each object as well.
void PairRuleLookup::Resolve(Rules& rules) const {
  std::vector<Together> together(static_cast<std::size_t>(body_.frame_count));
  const auto add = [&](const std::vector<Applied>& applied) {
    for (const auto& [frame, rule] : applied) {
      if (frame != kAllFrames) {
        together[static_cast<std::size_t>(frame)].Add(*rule);
      } else {
        for (Together& each : together) each.Add(*rule);
      }
    }
  };
  add(rules.rules);
  if (&rules != &everything_) add(everything_.rules);
  for (const Together& each : together) rules.terms.push_back(each.Terms());
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
