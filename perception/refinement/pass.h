// Passes change the hypotheses of a scene: two become one, one becomes several, or points change
// their owner. A pass proposes; the driver (refine.h) models the products, evaluates and commits.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "perception/cloud/work.h"
#include "perception/hypotheses/hypothesis_modeler.h"
#include "perception/hypotheses/scene_state.h"

namespace cwm::perception {

struct RefinementContext {
  const ModelingOptions& options;
  const HypothesisModeler& modeler;
  const Work& work;
};

// The expected product: one object is modelled without a search for touching objects.
enum class Expectation { kAny, kSingleObject };

struct Product {
  PointSet points = {};
  std::size_t node_count = 0;
  // The product's ground: a hypothesis or, if `on_product` is set, that product of the same
  // proposal.
  Resting resting = {};
  std::optional<std::size_t> on_product = {};
  std::vector<Placed<Plate>> plates = {};
  Expectation expects = Expectation::kAny;
  std::optional<std::vector<ShapePart>> given_shapes = {};  // level frame; no search then
};

struct Consumed {
  HypothesisId id;
  std::size_t successor = 0;  // product that the objects on it rest on afterwards
};

// A hypothesis that only changes in that it rests on a product.
struct RestingUpdate {
  HypothesisId id;
  std::size_t on_product = 0;
  std::optional<double> foot_height_m = {};  // null: as it was
};

struct FromSupport {
  std::size_t support = 0;
  PointSet points = {};  // ascending
};

// The hypotheses that a pass wants to replace, and their replacement. The products' points are
// those of the consumed hypotheses and `from_support`, each once. Products are modelled in their
// order until one is not admitted, so the likeliest to fail comes first.
struct Proposal {
  std::vector<Consumed> consumes = {};
  std::vector<Product> products = {};
  std::vector<RestingUpdate> resting_updates = {};
  std::optional<FromSupport> from_support = {};
};

// A proposal whose products have models.
struct ModelledProposal {
  const SceneState& state;
  const Proposal& proposal;
  std::span<const ModelPtr> products;
  const RefinementContext& context;
};

// chosen: for passes that may propose for most objects: more objects than one image contains.
inline constexpr int kMaxTrials = 32;

// The largest work of a pass in one scene, over all rounds.
struct TrialBudget {
  // Number of proposals that are examined, whether or not they are modelled. A proposal that was
  // outranked counts again. measured: no more than three merges of occluded parts in 317 scenes,
  // and more than six merges of vessel walls in one of 45 real scans, of clutter.
  int max_trials = 8;
  // The proposals that are modelled may have one in this many of the scene's points in sum. chosen:
  // bounds the work in clutter, where there are many proposals and few gains.
  std::size_t points_divisor = 4;
  std::string_view note;  // added to the object whose trial was not allowed
};

class RefinementPass {
 public:
  virtual ~RefinementPass() = default;

  // The name in InterpretOptions::disabled_passes, such as "merge.occluded_parts".
  virtual std::string_view Name() const = 0;
  // Passes that must run before this one.
  virtual std::span<const std::string_view> After() const { return {}; }
  virtual TrialBudget MaxWork() const = 0;

  // Promising proposals. If the budget does not suffice for all, the first ones are examined;
  // most passes propose in the order of output. All hypotheses have models.
  virtual std::vector<Proposal> Propose(const SceneState& state,
                                        const RefinementContext& context) const = 0;

  // A second, more expensive examination of a proposal, which counts as a trial: returns its final
  // form, or empty. While its hypotheses exist, a proposal is examined again only if another one
  // outranked it.
  virtual std::optional<Proposal> Examine(const SceneState& state, Proposal proposal,
                                          const RefinementContext& context) const {
    (void)state, (void)context;
    return proposal;
  }

  // True if the shapes of a product are the expected ones.
  virtual bool Admits(const SceneState& state, const Proposal& proposal, std::size_t product,
                      const ObjectModel& found) const {
    (void)state, (void)proposal, (void)product, (void)found;
    return true;
  }

  // The improvement by the products over what they replace: the proposal is committed if it is more
  // than 0. If proposals compete for a hypothesis, the greater gain wins.
  virtual double Gain(const ModelledProposal& modelled) const = 0;
};

}  // namespace cwm::perception
