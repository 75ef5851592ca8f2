// Rules of pairs as MoveIt's matrix; declared in planning_scene.h.
#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/export/planning_scene.h"

namespace cwm::server {
namespace {

using collision::NamedThing;
using collision::PairRule;
using collision::WorldRobot;

std::string NameOf(const NamedThing& thing) {
  return thing.link.empty() ? thing.name : absl::StrCat(thing.name, ":", thing.link);
}

std::string NameOf(const PairRule& rule) {
  return absl::StrCat(NameOf(rule.pair.a), " and ", NameOf(rule.pair.b));
}

class MatrixMaker {
 public:
  explicit MatrixMaker(const WorldRobot* robot, const collision::PairRules& rules) : robot_(robot) {
    if (robot_ != nullptr) {
      for (const collision::ModelLink& link : robot_->model().links) {
        if (!link.collisions.empty()) names_.insert(link.name);
      }
    }
    for (const PairRule& rule : rules) {
      if (!rule.allowed) continue;
      for (const NamedThing* thing : {&rule.pair.a, &rule.pair.b}) {
        const auto names = NamesOf(*thing);
        if (names && !IsEverything(*thing)) names_.insert(names->begin(), names->end());
      }
    }
    std::size_t index = 0;
    for (const std::string& name : names_) index_[name] = index++;
    allowed_.assign(names_.size(), std::vector<bool>(names_.size(), false));
  }

  // Links next to each other and those of one body are among them: MoveIt's matrix has no other way
  // to say so.
  void AllowUncheckedLinks() {
    if (robot_ == nullptr) return;
    const auto& links = robot_->model().links;
    std::set<std::pair<int, int>> checked;
    for (const collision::LinkPair& pair : robot_->model().self_pairs) {
      checked.insert(std::minmax(pair.first, pair.second));
    }
    for (int i = 0; i < static_cast<int>(links.size()); ++i) {
      for (int j = i + 1; j < static_cast<int>(links.size()); ++j) {
        const auto& a = links[static_cast<std::size_t>(i)];
        const auto& b = links[static_cast<std::size_t>(j)];
        if (a.collisions.empty() || b.collisions.empty() || checked.count({i, j}) > 0) continue;
        Allow(a.name, b.name);
      }
    }
  }

  // False for a rule of another robot, of which the scene knows nothing.
  bool Take(const PairRule& rule) {
    const auto names_a = NamesOf(rule.pair.a);
    const auto names_b = NamesOf(rule.pair.b);
    if (!names_a || !names_b) return false;
    for (const std::string& a : *names_a) {
      for (const std::string& b : *names_b) Allow(a, b);
    }
    if (IsEverything(rule.pair.a)) by_default_.insert(names_b->begin(), names_b->end());
    if (IsEverything(rule.pair.b)) by_default_.insert(names_a->begin(), names_a->end());
    return true;
  }

  AllowedMatrix Made() const {
    return {.names = {names_.begin(), names_.end()},
            .allowed = allowed_,
            .by_default = {by_default_.begin(), by_default_.end()}};
  }

 private:
  static bool IsEverything(const NamedThing& thing) { return thing.name == collision::kEverything; }

  // As the scene calls the thing; everything is every name.
  std::optional<std::vector<std::string>> NamesOf(const NamedThing& thing) const {
    if (IsEverything(thing)) return std::vector<std::string>(names_.begin(), names_.end());
    if (robot_ != nullptr && thing.name == robot_->name) {
      if (!thing.link.empty()) return std::vector<std::string>{thing.link};
      std::vector<std::string> links;
      for (const collision::ModelLink& link : robot_->model().links) {
        if (!link.collisions.empty()) links.push_back(link.name);
      }
      return links;
    }
    if (!thing.link.empty()) return std::nullopt;
    return std::vector<std::string>{thing.name};
  }

  void Allow(const std::string& a, const std::string& b) {
    if (a == b) return;
    const std::size_t i = index_.at(a);
    const std::size_t j = index_.at(b);
    allowed_[i][j] = allowed_[j][i] = true;
  }

  const WorldRobot* const robot_;
  std::set<std::string> names_;
  std::map<std::string, std::size_t> index_;
  std::vector<std::vector<bool>> allowed_;
  std::set<std::string> by_default_;
};

}  // namespace

AllowedMatrix AllowedMatrixOf(const collision::PairRules& rules, const WorldRobot* robot,
                              std::vector<std::string>& warnings) {
  MatrixMaker maker(robot, rules);
  maker.AllowUncheckedLinks();
  for (const PairRule& rule : rules) {
    if (rule.margin_m) {
      warnings.push_back(absl::StrCat(NameOf(rule), ": the margin of the pair is left out"));
    }
    if (!rule.allowed) continue;
    if (!maker.Take(rule)) {
      warnings.push_back(
          absl::StrCat(NameOf(rule), ": the rule is left out, it is of another robot"));
    } else if (rule.expires) {
      warnings.push_back(absl::StrCat(NameOf(rule), ": allowed for good, here it ends by itself"));
    }
  }
  return maker.Made();
}

}  // namespace cwm::server
