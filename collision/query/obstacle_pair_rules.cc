#include "collision/query/obstacle_pair_rules.h"

#include <algorithm>
#include <optional>

#include "collision/world/world_robot.h"

namespace cwm::collision {
namespace {

// Indices of links, 0 for an object.
struct LinkRange {
  int begin = 0, end = 0;
};

int CountLinks(const Obstacle& obstacle) {
  return obstacle.robot != nullptr ? static_cast<int>(obstacle.robot->model->links.size()) : 1;
}

// The links of the obstacle to which the name refers; empty if it refers to none.
std::optional<LinkRange> LinksOf(const NamedThing& named, const Obstacle& obstacle) {
  if (named.name == kEverything) return LinkRange{0, CountLinks(obstacle)};
  if (named.name != obstacle.name) return std::nullopt;
  if (named.link.empty()) return LinkRange{0, CountLinks(obstacle)};
  if (obstacle.robot == nullptr) return std::nullopt;  // objects have no links
  const std::optional<int> link = obstacle.robot->model->FindLink(named.link);
  if (!link.has_value()) return std::nullopt;
  return LinkRange{*link, *link + 1};
}

void AddTo(ObstaclePairTable& table, const PairRule& rule, const std::optional<LinkRange>& first,
           const std::optional<LinkRange>& second) {
  if (!first || !second) return;
  for (int i = first->begin; i < first->end; ++i) {
    for (int j = second->begin; j < second->end; ++j) table.At(i, j).Add(rule);
  }
}

}  // namespace

ObstaclePairRules::ObstaclePairRules(const WorldSnapshot& world,
                                     std::span<const PairRule> ignored) {
  for (const PairRule& rule : world.pair_rules()) {
    if (rule.allowed || rule.margin_m.has_value()) Add(rule);
  }
  for (const PairRule& rule : ignored) Add(rule);
}

void ObstaclePairRules::Add(const PairRule& rule) {
  rules_[std::minmax<std::string_view>(rule.pair.a.name, rule.pair.b.name)].push_back(&rule);
  max_margin_m_ = std::max(max_margin_m_, rule.margin_m.value_or(0));
}

ObstaclePairTable ObstaclePairRules::Of(const Obstacle& first, const Obstacle& second) const {
  if (rules_.empty()) return {};
  const std::string_view all = kEverything;
  const Names both = std::minmax<std::string_view>(first.name, second.name);
  std::vector<Names> keys = {both, std::minmax(all, both.first), {all, all}};
  if (&first != &second) keys.push_back(std::minmax(all, both.second));
  ObstaclePairTable table;
  for (const Names& key : keys) {
    const auto found = rules_.find(key);
    if (found == rules_.end()) continue;
    if (table.empty()) {
      table = ObstaclePairTable(static_cast<std::size_t>(CountLinks(first)),
                                static_cast<std::size_t>(CountLinks(second)));
    }
    for (const PairRule* const rule : found->second) {
      const auto& [a, b] = rule->pair;
      AddTo(table, *rule, LinksOf(a, first), LinksOf(b, second));
      if (a != b) AddTo(table, *rule, LinksOf(b, first), LinksOf(a, second));
    }
  }
  return table;
}

}  // namespace cwm::collision
