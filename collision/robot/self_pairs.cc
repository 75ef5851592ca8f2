#include "collision/robot/self_pairs.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>

namespace cwm::collision {
namespace {

// A symmetric matrix over links: true for pairs that are left out.
class SkippedPairs {
 public:
  explicit SkippedPairs(const RobotModel& model)
      : model_(model), size_(model.links.size()), is_left_out_(size_ * size_, false) {}

  bool operator()(int a, int b) const { return is_left_out_[At(a, b)]; }

  void Set(int a, int b, bool left_out) { is_left_out_[At(a, b)] = left_out; }

  void Set(const std::vector<NamedLinkPair>& pairs, bool left_out) {
    for (const NamedLinkPair& pair : pairs) {
      const std::optional<int> a = model_.FindLink(pair.link1);
      const std::optional<int> b = model_.FindLink(pair.link2);
      if (a.has_value() && b.has_value()) Set(*a, *b, left_out);
    }
  }

  void SetAllOf(const std::string& link) {
    const std::optional<int> a = model_.FindLink(link);
    for (std::size_t b = 0; a.has_value() && b < size_; ++b) Set(*a, static_cast<int>(b), true);
  }

 private:
  std::size_t At(int a, int b) const {
    return static_cast<std::size_t>(std::min(a, b)) * size_ + std::max(a, b);
  }

  const RobotModel& model_;
  std::size_t size_;
  std::vector<bool> is_left_out_;
};

// Applies MoveIt's order: defaults of links, enabled pairs, disabled pairs.
void LeaveOutDisabled(const SemanticDescription& semantic, SkippedPairs& left_out) {
  for (const std::string& link : semantic.disabled_links) left_out.SetAllOf(link);
  left_out.Set(semantic.enabled_pairs, false);
  left_out.Set(semantic.disabled_pairs, true);
}

void LeaveOutNeighbours(const RobotModel& model, SkippedPairs& left_out) {
  for (std::size_t i = 1; i < model.links.size(); ++i) {
    int above = model.links[i].parent;
    while (above != 0 && model.links[above].collisions.empty()) above = model.links[above].parent;
    left_out.Set(static_cast<int>(i), above, true);
  }
}

}  // namespace

std::vector<LinkPair> SelfPairs(const RobotModel& model, const SemanticDescription* semantic) {
  SkippedPairs left_out(model);
  if (semantic != nullptr) {
    LeaveOutDisabled(*semantic, left_out);
  } else {
    LeaveOutNeighbours(model, left_out);
  }
  std::vector<int> shaped;  // in the order of the URDF
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    if (!model.links[i].collisions.empty()) shaped.push_back(static_cast<int>(i));
  }
  std::sort(shaped.begin(), shaped.end(),
            [&](int a, int b) { return model.links[a].urdf_index < model.links[b].urdf_index; });
  std::vector<LinkPair> pairs;
  for (auto a = shaped.begin(); a != shaped.end(); ++a) {
    for (auto b = a + 1; b != shaped.end(); ++b) {
      if (model.links[*a].body == model.links[*b].body || left_out(*a, *b)) continue;
      pairs.push_back({.first = *a, .second = *b});
    }
  }
  return pairs;
}

}  // namespace cwm::collision
