// Pair rules as MoveIt's allowed collision matrix; declared in planning_scene.h.
#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/core/error.h"
#include "server/export/notes.h"
#include "server/export/planning_scene.h"

namespace cwm::server {
namespace {

using collision::NamedThing;
using collision::PairRule;
using collision::WorldRobot;

std::string NameOf(const NamedThing& named) {
  return named.link.empty() ? named.name : absl::StrCat(named.name, ":", named.link);
}

std::string NameOf(const PairRule& rule) {
  return absl::StrCat(NameOf(rule.pair.a), " and ", NameOf(rule.pair.b));
}

class MatrixMaker {
 public:
  MatrixMaker(const collision::WorldSnapshot& snapshot, const WorldRobot* robot) : robot_(robot) {
    if (robot_ != nullptr) {
      for (const collision::ModelLink& link : robot_->model().links) {
        if (!link.collisions.empty()) links_.push_back(link.name);
      }
    }
    for (const collision::WorldRobotPtr& other : snapshot.robots()) {
      if (other.get() != robot_) others_.insert(other->name);
    }
    names_.insert(links_.begin(), links_.end());
    for (const PairRule& rule : snapshot.pair_rules()) {
      if (!rule.allowed || IsOfAnother(rule)) continue;
      for (const NamedThing* named : {&rule.pair.a, &rule.pair.b}) {
        if (IsEverything(*named) || IsRobot(*named)) continue;
        names_.insert(named->link.empty() ? named->name : named->link);
      }
    }
  }

  std::size_t name_count() const { return names_.size(); }

  // Must be called before any pair is allowed. Takes memory proportional to the square of the
  // number of names.
  void LayOut() {
    std::size_t index = 0;
    for (const std::string& name : names_) index_[name] = index++;
    allowed_.assign(names_.size(), std::vector<bool>(names_.size(), false));
  }

  // Allows the pairs of links that the robot does not check, adjacent links and links of one rigid
  // body included: MoveIt's matrix has no other way to express it.
  absl::Status AllowUncheckedLinks(const CancellationCheck& check_cancelled) {
    if (robot_ == nullptr) return absl::OkStatus();
    const auto& links = robot_->model().links;
    std::set<std::pair<int, int>> checked;
    for (const collision::LinkPair& pair : robot_->model().self_pairs) {
      checked.insert(std::minmax(pair.first, pair.second));
    }
    for (int i = 0; i < static_cast<int>(links.size()); ++i) {
      if (absl::Status status = check_cancelled(); !status.ok()) return status;
      for (int j = i + 1; j < static_cast<int>(links.size()); ++j) {
        const auto& a = links[static_cast<std::size_t>(i)];
        const auto& b = links[static_cast<std::size_t>(j)];
        if (a.collisions.empty() || b.collisions.empty() || checked.count({i, j}) > 0) continue;
        Allow(a.name, b.name);
      }
    }
    return absl::OkStatus();
  }

  // Checks a pair of links that AllowUncheckedLinks allowed.
  void Check(const PairRule& rule) {
    const auto a = index_.find(rule.pair.a.link), b = index_.find(rule.pair.b.link);
    if (a == index_.end() || b == index_.end()) return;  // without geometry, or no longer there
    allowed_[a->second][b->second] = allowed_[b->second][a->second] = false;
  }

  // True if the rule concerns another robot, which the scene does not contain.
  bool IsOfAnother(const PairRule& rule) const {
    return IsOfAnother(rule.pair.a) || IsOfAnother(rule.pair.b);
  }

  void Take(const PairRule& rule) {
    const auto& [a, b] = rule.pair;
    if (IsEverything(a) || IsEverything(b)) {
      AddDefault(IsEverything(a) ? b : a);
      return;
    }
    const std::vector<std::string> names_b = NamesOf(b);
    for (const std::string& name_a : NamesOf(a)) {
      for (const std::string& name_b : names_b) Allow(name_a, name_b);
    }
  }

  absl::StatusOr<AllowedCollisionMatrix> Made(const CancellationCheck& check_cancelled) {
    for (const std::string& name : by_default_) {
      if (absl::Status status = check_cancelled(); !status.ok()) return status;
      for (const std::string& other : names_) Allow(name, other);
    }
    return AllowedCollisionMatrix{.names = {names_.begin(), names_.end()},
                                  .allowed = std::move(allowed_),
                                  .by_default = {by_default_.begin(), by_default_.end()}};
  }

 private:
  static bool IsEverything(const NamedThing& named) { return named.name == collision::kEverything; }
  bool IsRobot(const NamedThing& named) const {
    return robot_ != nullptr && named.name == robot_->name && named.link.empty();
  }
  bool IsOfAnother(const NamedThing& named) const {
    if (IsEverything(named) || (robot_ != nullptr && named.name == robot_->name)) return false;
    return !named.link.empty() || others_.count(named.name) > 0;
  }

  // The scene's names of the object, robot or link. Must not be called for "everything".
  std::vector<std::string> NamesOf(const NamedThing& named) const {
    if (IsRobot(named)) return links_;
    return {named.link.empty() ? named.name : named.link};
  }

  // Adds the names of `named` to the default entries; their pairs are made at the end, once per
  // name.
  void AddDefault(const NamedThing& named) {
    if (IsEverything(named)) {
      by_default_ = names_;
    } else {
      for (const std::string& name : NamesOf(named)) by_default_.insert(name);
    }
  }

  void Allow(const std::string& a, const std::string& b) {
    if (a == b) return;
    const std::size_t i = index_.at(a);
    const std::size_t j = index_.at(b);
    allowed_[i][j] = allowed_[j][i] = true;
  }

  const WorldRobot* const robot_;
  std::vector<std::string> links_;  // of the robot, those with collision geometry
  std::set<std::string> others_;    // robots that the scene does not contain
  std::set<std::string> names_;
  std::map<std::string, std::size_t> index_;
  std::vector<std::vector<bool>> allowed_;
  std::set<std::string> by_default_;
};

}  // namespace

absl::StatusOr<AllowedCollisionMatrix> MakeAllowedCollisionMatrix(
    const collision::WorldSnapshot& snapshot, const WorldRobot* robot,
    std::vector<std::string>& warnings, const CancellationCheck& check_cancelled) {
  MatrixMaker maker(snapshot, robot);
  if (maker.name_count() > kMaxMatrixNames) {
    return MakeError(
        absl::StatusCode::kResourceExhausted,
        absl::StrCat("the matrix of allowed collisions would have ", maker.name_count(),
                     " names of links and objects, must have at most ", kMaxMatrixNames),
        {.reason = "EXPORT_TOO_LARGE"});
  }
  maker.LayOut();
  if (absl::Status status = maker.AllowUncheckedLinks(check_cancelled); !status.ok()) return status;
  for (const PairRule& rule : snapshot.pair_rules()) {
    if (rule.check && !maker.IsOfAnother(rule)) maker.Check(rule);
  }
  Notes notes;
  for (const PairRule& rule : snapshot.pair_rules()) {
    if (absl::Status status = check_cancelled(); !status.ok()) return status;
    if (rule.margin_m) notes.Add("the margin of the pair is left out", NameOf(rule));
    if (!rule.allowed) continue;
    if (maker.IsOfAnother(rule)) {
      notes.Add("the rule is left out, it is of another robot", NameOf(rule));
      continue;
    }
    maker.Take(rule);
    if (rule.expires) notes.Add("allowed for good, here it ends by itself", NameOf(rule));
  }
  notes.AppendTo(warnings);
  return maker.Made(check_cancelled);
}

}  // namespace cwm::server
