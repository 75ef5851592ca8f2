#include "collision/query/pair_rule_lookup.h"

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <utility>

namespace cwm::collision {
namespace {

constexpr int kAllFrames = -1;
constexpr int kOwnFrames = -2;

}  // namespace

void CombinedRule::Add(const PairRule& rule) {
  const auto precedes = [](const PairRule& a, const PairRule& b) {
    const int precision_a = Specificity(a.pair), precision_b = Specificity(b.pair);
    return precision_a != precision_b ? precision_a > precision_b : a.pair < b.pair;
  };
  allowed |= rule.allowed;
  if (rule.margin_m.has_value() && (margin == nullptr || precedes(rule, *margin))) margin = &rule;
}

void CombinedRule::Add(const CombinedRule& other) {
  allowed |= other.allowed;
  if (other.margin != nullptr) Add(*other.margin);
}

PairRuleLookup::PairRuleLookup(const WorldSnapshot& world, const QueryBody& body,
                               const QueryOptions& options)
    : world_(world), body_(body) {
  for (const NamedPair& pair : options.ignore_pairs) {
    ignored_.push_back({.pair = Ordered(pair), .allowed = true});
  }
  if (body.attachment != nullptr) AllowAttachment();
  for (const PairRule& rule : world.pair_rules()) {
    // PairRule::check is the matter of WithCheckedPairs.
    if (rule.allowed || rule.margin_m.has_value()) Add(rule);
  }
  for (const PairRule& rule : ignored_) Add(rule);
  AllowSelfOnlyFrames();
  if (!of_everything_.empty()) rules_of_everything_ = CombineRules(of_everything_, nullptr);
  if (!of_named_.empty()) FillBuckets();
  if (!of_itself_.empty()) ResolveSelfPairs();
}

void PairRuleLookup::Add(const PairRule& rule) {
  const auto& [a, b] = rule.pair;
  Add(rule, a, b);
  if (a != b) Add(rule, b, a);
  if (body_.self_pairs.empty()) return;
  if (FramesOf(a).has_value() && FramesOf(b).has_value()) of_itself_.push_back(&rule);
}

void PairRuleLookup::Add(const PairRule& rule, const NamedThing& mine, const NamedThing& theirs) {
  const std::optional<int> frames = FramesOf(mine);
  if (!frames.has_value()) return;
  const bool of_everything = theirs.name == kEverything;
  // Planning scenes contain rules about objects that are no longer there, and about every two
  // links.
  if (!of_everything && !Exists(theirs.name)) return;
  auto& applied = of_everything ? of_everything_ : of_named_;
  applied.push_back({*frames, &rule, &theirs});
  max_margin_m_ = std::max(max_margin_m_, rule.margin_m.value_or(0));
}

// True if the world has an object or robot of that name other than the body itself.
bool PairRuleLookup::Exists(const std::string& name) const {
  if (name == body_.self) return false;
  return world_.Find(name) != nullptr || world_.FindRobot(name) != nullptr;
}

// The frame of the body to which the name refers, or kOwnFrames or kAllFrames; empty if it refers
// to none.
std::optional<int> PairRuleLookup::FramesOf(const NamedThing& thing) const {
  if (thing.name == kEverything) return kAllFrames;
  if (!body_.self.empty() && thing.name == body_.self) {
    if (thing.link.empty()) return kOwnFrames;
    return body_.robot != nullptr ? body_.robot->FindLink(thing.link) : std::nullopt;
  }
  for (std::size_t k = 0; k < body_.attached.size(); ++k) {
    if (thing.name != body_.attached[k].object->name) continue;
    if (!thing.link.empty()) return std::nullopt;  // objects have no links
    return body_.frame_count + static_cast<int>(k);
  }
  return std::nullopt;
}

std::vector<int> PairRuleLookup::FrameClasses() const {
  std::vector<int> classes(static_cast<std::size_t>(body_.TotalFrames()), 0);
  if (!MayChangeWorldPairs()) return classes;
  std::map<std::vector<bool>, int> known;
  for (int frame = 0; frame < body_.TotalFrames(); ++frame) {
    std::vector<bool> covered;
    for (const auto* applied : {&of_everything_, &of_named_}) {
      for (const AppliedRule& each : *applied) covered.push_back(Covers(each.frames, frame));
    }
    classes[static_cast<std::size_t>(frame)] =
        known.try_emplace(std::move(covered), static_cast<int>(known.size())).first->second;
  }
  return classes;
}

bool PairRuleLookup::Covers(int frames, int frame) const {
  return frames == kAllFrames || frames == frame ||
         (frames == kOwnFrames && frame < body_.frame_count);
}

// Ignores pairs of a querying object with the robot link that holds it, its touch links and the
// objects attached to the same link.
void PairRuleLookup::AllowAttachment() {
  const Attachment& by = *body_.attachment;
  const auto allow = [&](const NamedThing& other) {
    ignored_.push_back({.pair = Ordered({{body_.self}, other}), .allowed = true});
  };
  allow({by.robot, by.link});
  for (const std::string& link : by.touch_links) allow({by.robot, link});
  for (const WorldObjectPtr& other : world_.attached()) {
    const Attachment& of_other = *other->attachment;
    const bool is_there = of_other.robot == by.robot && of_other.link == by.link;
    if (is_there && other->name != body_.self) allow({other->name});
  }
}

// Frames that are not tested against the world are allowed to collide with all of it.
void PairRuleLookup::AllowSelfOnlyFrames() {
  static const PairRule kAllowed{.pair = {{kEverything}, {kEverything}}, .allowed = true};
  for (std::size_t frame = 0; frame < body_.self_only_frames.size(); ++frame) {
    if (!body_.self_only_frames[frame]) continue;
    of_everything_.push_back({static_cast<int>(frame), &kAllowed, &kAllowed.pair.b});
  }
}

void PairRuleLookup::FillBuckets() {
  buckets_.assign(std::bit_ceil(2 * of_named_.size()), -1);
  for (std::size_t i = 0; i < of_named_.size(); ++i) {
    std::int32_t& first = buckets_[BucketOf(of_named_[i].theirs->name)];
    of_named_[i].next = first;
    first = static_cast<std::int32_t>(i);
  }
}

std::size_t PairRuleLookup::BucketOf(std::string_view name) const {
  return static_cast<std::size_t>(HashOf(name)) & (buckets_.size() - 1);
}

ObstacleRules PairRuleLookup::LookUp(const Obstacle& obstacle) {
  const auto [at, is_new] = rules_by_obstacle_.try_emplace(&obstacle);
  if (is_new && !of_named_.empty()) {
    std::vector<AppliedRule> applied;
    for (std::int32_t i = buckets_[BucketOf(obstacle.name)]; i >= 0;) {
      const AppliedRule& each = of_named_[static_cast<std::size_t>(i)];
      if (each.theirs->name == obstacle.name) applied.push_back(each);
      i = each.next;
    }
    if (!applied.empty()) {  // rules for everything apply to it as well
      applied.insert(applied.end(), of_everything_.begin(), of_everything_.end());
      at->second = CombineRules(applied, obstacle.robot.get());
    }
  }
  const RuleTable& known = at->second.rules.empty() ? rules_of_everything_ : at->second;
  return known.rules.empty() ? ObstacleRules() : ObstacleRules(known.rules.data(), known.by_link);
}

// The combined rules for an obstacle; by link of the robot only if a rule names a link.
PairRuleLookup::RuleTable PairRuleLookup::CombineRules(std::span<const AppliedRule> applied,
                                                       const RobotGeometry* robot) const {
  RuleTable result;
  const bool by_link =
      robot != nullptr && std::any_of(applied.begin(), applied.end(), [](const AppliedRule& each) {
        return !each.theirs->link.empty();
      });
  if (by_link) result.by_link = robot;
  const std::size_t columns = by_link ? robot->model->links.size() : 1;
  std::vector<CombinedRule> combined(static_cast<std::size_t>(body_.TotalFrames()) * columns);
  for (const AppliedRule& each : applied) {
    std::size_t first = 0, last = columns;
    if (!each.theirs->link.empty()) {
      if (robot == nullptr) continue;  // objects have no links
      const std::optional<int> link = robot->model->FindLink(each.theirs->link);
      if (!link.has_value()) continue;
      first = static_cast<std::size_t>(*link);
      last = first + 1;
    }
    for (int frame = 0; frame < body_.TotalFrames(); ++frame) {
      if (!Covers(each.frames, frame)) continue;
      CombinedRule* const row = &combined[static_cast<std::size_t>(frame) * columns];
      for (std::size_t column = first; column < last; ++column) row[column].Add(*each.rule);
    }
  }
  result.rules.reserve(combined.size());
  for (const CombinedRule& each : combined) result.rules.push_back(each.Effective());
  return result;
}

// Each side of a rule is one frame, all own frames or all frames, so up to three sides cover each
// frame.
void PairRuleLookup::ResolveSelfPairs() {
  std::map<std::pair<int, int>, CombinedRule> combined;
  for (const PairRule* rule : of_itself_) {
    combined[std::minmax(*FramesOf(rule->pair.a), *FramesOf(rule->pair.b))].Add(*rule);
  }
  const auto sides = [&](int frame) {
    return std::array{frame, kAllFrames, frame < body_.frame_count ? kOwnFrames : kAllFrames};
  };
  std::pair<int, int> last(-1, -1);
  for (const auto& [first, second] : body_.self_pairs) {
    const std::pair<int, int> frames(body_.FrameOf(first), body_.FrameOf(second));
    if (frames == last) {  // most pairs have the frames of the one before
      of_self_pairs_.push_back(EffectiveRule(of_self_pairs_.back()));
      continue;
    }
    last = frames;
    CombinedRule pair;
    for (const int a : sides(frames.first)) {
      for (const int b : sides(frames.second)) {
        if (const auto at = combined.find(std::minmax(a, b)); at != combined.end())
          pair.Add(at->second);
      }
    }
    of_self_pairs_.push_back(pair.Effective());
  }
  const bool has_effect =
      std::any_of(of_self_pairs_.begin(), of_self_pairs_.end(),
                  [](const EffectiveRule& rules) { return rules.allowed || rules.has_margin; });
  if (!has_effect) of_self_pairs_.clear();
}

}  // namespace cwm::collision
