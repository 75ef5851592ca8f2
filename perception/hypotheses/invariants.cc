#include "perception/hypotheses/invariants.h"

#include <algorithm>
#include <cstdint>

#include "absl/strings/str_cat.h"

namespace cwm::perception {
namespace {

class Checker {
 public:
  explicit Checker(const SceneState& state) : state_(state) {}

  std::vector<std::string> Run() {
    CheckPoints();
    for (const HypothesisPtr& hypothesis : state_.hypotheses()) {
      CheckResting(*hypothesis);
      if (hypothesis->model) CheckModel(*hypothesis);
    }
    CheckOrder();
    return std::move(broken_);
  }

 private:
  static std::string NameOf(const ObjectHypothesis& hypothesis) {
    return absl::StrCat("hypothesis ", hypothesis.id.value);
  }

  void CheckPoints() {
    std::vector<std::uint8_t> owners(state_.points().size(), 0);
    const auto count = [&](const PointSet& points, const std::string& owner) {
      for (std::uint32_t i : points) {
        if (i >= owners.size()) {
          broken_.push_back(absl::StrCat(owner, " has point ", i, " of ", owners.size()));
        } else if (owners[i] < 2) {
          ++owners[i];
        }
      }
    };
    for (const HypothesisPtr& hypothesis : state_.hypotheses()) {
      if (hypothesis->points.empty()) broken_.push_back(NameOf(*hypothesis) + " has no points");
      count(hypothesis->points, NameOf(*hypothesis));
    }
    for (std::size_t s = 0; s < state_.support_count(); ++s) {
      count(state_.support(s).points, absl::StrCat("support ", s));
    }
    count(state_.measured().rejected, "the list of rejected points");
    const auto without = std::ranges::count(owners, 0);
    const auto several = std::ranges::count(owners, 2);
    if (without > 0) broken_.push_back(absl::StrCat(without, " points have no owner"));
    if (several > 0) broken_.push_back(absl::StrCat(several, " points have several owners"));
  }

  void CheckResting(const ObjectHypothesis& hypothesis) {
    const std::size_t max_steps = state_.hypotheses().size();
    std::size_t steps = 0;
    for (const ObjectHypothesis* at = &hypothesis; at->resting.on; ++steps) {
      const ObjectHypothesis* const below = state_.Find(*at->resting.on);
      if (below == nullptr) {
        broken_.push_back(absl::StrCat(NameOf(*at), " rests on hypothesis ", at->resting.on->value,
                                       ", which is gone"));
        return;
      }
      if (below->resting.support != at->resting.support) {
        broken_.push_back(absl::StrCat(NameOf(*at), " rests on hypothesis ", below->id.value,
                                       " of another support"));
      }
      if (steps > max_steps) {
        broken_.push_back(NameOf(hypothesis) + " rests on itself");
        return;
      }
      at = below;
    }
  }

  void CheckModel(const ObjectHypothesis& hypothesis) {
    const HypothesisModel& model = *hypothesis.model;
    const auto parts = static_cast<std::int32_t>(model.shapes().size() + model.handles().size());
    if (model.part_of_point().size() != hypothesis.points.size()) {
      broken_.push_back(absl::StrCat(NameOf(hypothesis), " has ", hypothesis.points.size(),
                                     " points and ", model.part_of_point().size(), " labels"));
    }
    if (std::ranges::any_of(model.part_of_point(), [&](std::int32_t part) {
          return part < kUnexplained || part >= parts;
        })) {
      broken_.push_back(NameOf(hypothesis) + " has labels of parts that it has not");
    }
  }

  void CheckOrder() {
    const auto comes_before = [](const HypothesisPtr& a, const HypothesisPtr& b) {
      if (a->IsObject() != b->IsObject()) return a->IsObject();
      return a->IsObject() && a->node_count > b->node_count;
    };
    if (!std::ranges::is_sorted(state_.hypotheses(), comes_before)) {
      broken_.push_back("hypotheses are not in the order of output");
    }
  }

  const SceneState& state_;
  std::vector<std::string> broken_;
};

}  // namespace

std::vector<std::string> ViolatedInvariants(const SceneState& state) {
  return Checker(state).Run();
}

}  // namespace cwm::perception
