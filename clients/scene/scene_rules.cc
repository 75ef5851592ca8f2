// Allowed collisions of a planning scene; declared in scene_robot.h.
#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/formats/format_error.h"
#include "clients/scene/scene_objects.h"
#include "clients/scene/scene_robot.h"

namespace cwm::scene {
namespace {

namespace pb = cwm::v1;

class RuleBuilder {
 public:
  RuleBuilder(const formats::SceneFile& scene, const pb::Robot* robot)
      : collisions_(scene.allowed_collisions), robot_(robot) {
    AddMembers(scene);
    const auto& names = collisions_.names;
    for (std::size_t i = 0; i < names.size(); ++i) row_.emplace(names[i], i);
    for (const auto& [name, allowed] : collisions_.defaults) defaults_[name] = allowed;
  }

  SceneRules Make(const std::vector<pb::PairRule>& before) {
    for (const auto& [name, allowed] : collisions_.defaults) {
      if (allowed) AllowByDefault(name);
    }
    const auto& names = collisions_.names;
    for (std::size_t i = 0; i < names.size(); ++i) {
      for (std::size_t j = i + 1; j < names.size(); ++j) {
        if (collisions_.allowed[i][j]) Allow(names[i], names[j]);
      }
    }
    for (const pb::PairRule& rule : before) {
      if (rule.allowed() && Forbids(rule.pair())) rules_.withdrawn.push_back(rule.pair());
    }
    WarnAboutUnknownNames();
    DecideRobotPairs();
    return std::move(rules_);
  }

 private:
  void AddMembers(const formats::SceneFile& scene) {
    if (robot_ != nullptr) {
      for (const pb::RobotLink& link : robot_->links()) {
        pb::NamedThing member;
        member.set_name(robot_->name());
        member.set_link(link.name());
        if (link.collision_count() > 0) solid_.push_back(link.name());
        members_[link.name()] = member;
      }
    }
    const auto add_object = [&](const formats::SceneObject& object) {
      pb::NamedThing member;
      member.set_name(ObjectName(object.id));
      if (members_.emplace(object.id, member).second) solid_.push_back(object.id);
    };
    for (const auto& object : scene.objects) add_object(object);
    for (const auto& attached : scene.robot_state.attached) add_object(attached.object);
  }

  // True if the matrix says false for a pair that a rule allows; for "*" the default counts.
  bool Forbids(const pb::NamedPair& pair) const {
    const auto a = NameInFile(pair.a()), b = NameInFile(pair.b());
    if (a && b) return MatrixEntry(*a, *b) == false;
    const bool a_is_all = pair.a().name() == "*", b_is_all = pair.b().name() == "*";
    const auto& one = a ? a : b;
    if (!one || !(a_is_all || b_is_all)) return false;
    const auto said = defaults_.find(*one);
    return said != defaults_.end() && !said->second;
  }

  std::optional<std::string> NameInFile(const pb::NamedThing& member) const {
    for (const auto& [name, known] : members_) {
      if (known.name() == member.name() && known.link() == member.link()) return name;
    }
    return std::nullopt;
  }

  bool IsAllowed(const std::string& a, const std::string& b) const {
    return MatrixEntry(a, b).value_or(false);
  }

  // The file's value for two different names; empty if it has none.
  std::optional<bool> MatrixEntry(const std::string& a, const std::string& b) const {
    const auto row_a = row_.find(a);
    const auto row_b = row_.find(b);
    if (row_a != row_.end() && row_b != row_.end()) {
      const auto [first, second] = std::minmax(row_a->second, row_b->second);
      return collisions_.allowed[first][second];
    }
    const auto default_a = defaults_.find(a);
    const auto default_b = defaults_.find(b);
    if (default_a == defaults_.end() && default_b == defaults_.end()) return std::nullopt;
    return (default_a == defaults_.end() || default_a->second) &&
           (default_b == defaults_.end() || default_b->second);
  }

  void AllowByDefault(const std::string& name) {
    std::vector<std::string> allowed;
    bool has_exceptions = false;
    for (const std::string& other : solid_) {
      if (other == name) continue;
      if (IsAllowed(name, other)) allowed.push_back(other);
      if (!IsAllowed(name, other)) has_exceptions = true;
    }
    if (!has_exceptions) {
      const auto member = members_.find(name);
      if (member == members_.end()) {
        unknown_.insert(name);
        return;
      }
      pb::NamedPair pair;
      *pair.mutable_a() = member->second;
      pair.mutable_b()->set_name("*");
      touches_all_.insert(name);
      rules_.pairs.push_back(pair);
      return;
    }
    for (const std::string& other : allowed) Allow(name, other);
    rules_.warnings.push_back(absl::StrCat(
        "allowed_collision_matrix: ", formats::Printable(name),
        " may by default touch all but some: allowed with what the scene has, not with what comes "
        "later"));
  }

  void Allow(const std::string& a, const std::string& b) {
    const auto member_a = members_.find(a);
    const auto member_b = members_.find(b);
    if (member_a == members_.end()) unknown_.insert(a);
    if (member_b == members_.end()) unknown_.insert(b);
    if (member_a == members_.end() || member_b == members_.end()) return;
    if (touches_all_.count(a) + touches_all_.count(b) > 0) return;
    if (!done_.insert(std::minmax(a, b)).second) return;
    pb::NamedPair pair;
    *pair.mutable_a() = member_a->second;
    *pair.mutable_b() = member_b->second;
    rules_.pairs.push_back(pair);
  }

  void WarnAboutUnknownNames() {
    if (unknown_.empty()) return;
    const std::vector<std::string> names(unknown_.begin(), unknown_.end());
    const std::string links =
        robot_ == nullptr ? "" : absl::StrCat("links of ", robot_->name(), " nor ");
    rules_.warnings.push_back(absl::StrCat("allowed_collision_matrix: ", FormatNames(names),
                                           ": left out, no ", links, "objects of the scene"));
  }

  // The scene decides about pairs of links, whatever the robot's description says.
  void DecideRobotPairs() {
    if (robot_ == nullptr) return;
    std::vector<std::string> checked, allowed;
    for (int a = 0; a < robot_->links_size(); ++a) {
      const auto& of_a = robot_->links(a).unchecked_links();
      for (int b = a + 1; b < robot_->links_size(); ++b) {
        const std::string &name_a = robot_->links(a).name(), &name_b = robot_->links(b).name();
        if (robot_->links(a).collision_count() == 0 || robot_->links(b).collision_count() == 0) {
          continue;
        }
        const std::optional<bool> said = MatrixEntry(name_a, name_b);
        const bool is_checked = std::find(of_a.begin(), of_a.end(), b) == of_a.end();
        const std::string pair = absl::StrCat(name_a, " with ", name_b);
        if (said == false && !is_checked) {
          checked.push_back(pair);
          pb::NamedPair& named = rules_.checked.emplace_back();
          *named.mutable_a() = members_.at(name_a);
          *named.mutable_b() = members_.at(name_b);
        }
        if (said == true && is_checked) allowed.push_back(pair);
      }
    }
    if (!checked.empty()) {
      rules_.warnings.push_back(absl::StrCat(
          "allowed_collision_matrix: false to ", FormatNames(checked), ", which ", robot_->name(),
          " does not check, by its SRDF or as neighbours: checked until withdrawn"));
    }
    if (!allowed.empty()) {
      rules_.warnings.push_back(absl::StrCat("allowed_collision_matrix: true to ",
                                             FormatNames(allowed), ", which ", robot_->name(),
                                             " would check: allowed until withdrawn"));
    }
  }

  const formats::SceneAllowedCollisions& collisions_;
  const pb::Robot* const robot_;
  std::map<std::string, pb::NamedThing> members_;  // by the name in the file
  std::vector<std::string> solid_;                 // names with collision geometry
  std::map<std::string, std::size_t> row_;
  std::map<std::string, bool> defaults_;
  std::set<std::string> touches_all_, unknown_;
  std::set<std::pair<std::string, std::string>> done_;
  SceneRules rules_;
};

}  // namespace

SceneRules ConvertRules(const formats::SceneFile& scene, const pb::Robot* robot,
                        const std::vector<pb::PairRule>& before) {
  return RuleBuilder(scene, robot).Make(before);
}

}  // namespace cwm::scene
