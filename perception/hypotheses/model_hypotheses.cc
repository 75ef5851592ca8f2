#include "perception/hypotheses/model_hypotheses.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <numeric>

#include "absl/strings/str_cat.h"
#include "perception/cloud/parallel_for.h"
#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

// chosen: the number of objects for which touching objects are searched, which may cost as much as
// all other work on an object. 25 objects fill an image of a Kinect; a room of many images has a
// quarter as many per image.
constexpr std::size_t kMinSplitCount = 25, kPointsPerSplit = 640UL * 480 / 6;
// chosen: a scene has at most this many times as many objects; smaller ones are modelled with
// reduced effort.
constexpr std::size_t kFullEffortPerSplit = 4;

// How many of the largest hypotheses get which effort.
struct Efforts {
  std::size_t split = 0;  // are searched for touching objects
  std::size_t full = 0;   // are modelled with full effort

  explicit Efforts(std::size_t points)
      : split(std::max(kMinSplitCount, points / kPointsPerSplit)),
        full(kFullEffortPerSplit * split) {}
};

double UnexplainedShare(std::span<const ModelPtr> models) {
  std::size_t points = 0;
  std::ptrdiff_t unexplained = 0;
  for (const ModelPtr& model : models) {
    if (!model) continue;
    points += model->part_of_point().size();
    unexplained += std::ranges::count(model->part_of_point(), kUnexplained);
  }
  return points == 0 ? 0 : static_cast<double>(unexplained) / static_cast<double>(points);
}

std::vector<std::size_t> LargestFirst(std::span<const HypothesisPtr> hypotheses) {
  std::vector<std::size_t> order(hypotheses.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::ranges::greater(),
                           [&](std::size_t k) { return hypotheses[k]->points.size(); });
  return order;
}

std::vector<std::string> WarningsOf(std::size_t count, const Efforts& efforts, bool is_shapeless) {
  std::vector<std::string> warnings;
  if (count > efforts.split) {
    warnings.push_back(absl::StrCat(
        "of ", count, " objects the largest ", efforts.split,
        " alone were looked at for objects that touch: the others may be several each"));
  }
  if (is_shapeless) {
    warnings.push_back(absl::StrCat(
        "of the largest ", efforts.split, " of ", count,
        " objects hardly anything is a shape: the others are meshed, no shapes were looked for"));
  } else if (count > efforts.full) {
    warnings.push_back(absl::StrCat("of ", count, " objects all but the largest ", efforts.full,
                                    " were modelled with reduced effort: some of their shapes may "
                                    "be missed, and their meshes are coarser"));
  }
  return warnings;
}

}  // namespace

ModelledScene ModelHypotheses(const SceneState& state, const HypothesisModeler& modeler,
                              const ModelingOptions& options, const Work& work) {
  const auto hypotheses = state.hypotheses();
  const std::vector<std::size_t> order = LargestFirst(hypotheses);
  const Efforts efforts(state.points().size());
  ModelingOptions unsplit = options;
  unsplit.modeler.split_touching = false;
  ModelingOptions reduced = unsplit;
  reduced.modeler.reduced_effort = true;
  ModelingOptions meshed = reduced;
  meshed.modeler = WithoutSearch(meshed.modeler);

  std::vector<ModelPtr> models(hypotheses.size());
  bool is_shapeless = false;
  const auto options_of = [&](std::size_t rank) -> const ModelingOptions& {
    if (rank < efforts.split) return options;
    if (is_shapeless) return meshed;
    return rank < efforts.full ? unsplit : reduced;
  };
  const auto model_ranks = [&](std::size_t first, std::size_t end) {
    ParallelFor(end - first, 1, work, [&](std::size_t begin, std::size_t stop) {
      for (std::size_t rank = first + begin; rank < first + stop; ++rank) {
        models[order[rank]] = modeler.Model(*hypotheses[order[rank]], options_of(rank));
      }
    });
  };
  const std::size_t largest = std::min(efforts.split, order.size());
  model_ranks(0, largest);
  // In noise and in heaps of balls, 0.98 and more of the points have no shape.
  is_shapeless = order.size() > largest && SearchesAny(options.modeler) &&
                 UnexplainedShare(models) > kNearlyAll;
  model_ranks(largest, order.size());
  return {.state = state.WithModels(models),
          .is_shapeless = is_shapeless,
          .warnings = WarningsOf(order.size(), efforts, is_shapeless)};
}

}  // namespace cwm::perception
