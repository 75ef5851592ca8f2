// Passes that change what the hypotheses of a scene are: two become one, one becomes several, or
// points change their owner. A pass proposes; the driver (refine.h) models, asks, and commits.
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

// What a product is to be: one object alone is modelled without a look for objects that touch.
enum class Expectation { kAny, kOneObject };

struct Product {
  PointSet points = {};
  std::size_t node_count = 0;
  // What it rests on: a hypothesis, or, if `on_product` is set, that product of the same proposal.
  Resting resting = {};
  std::optional<std::size_t> on_product = {};
  std::vector<Placed<Plate>> plates = {};
  Expectation expects = Expectation::kAny;
  std::optional<std::vector<ShapePart>> given_shapes = {};  // level frame; nothing is searched then
};

struct Consumed {
  HypothesisId id;
  std::size_t heir = 0;  // product on which rests what rested on it
};

// A hypothesis that is left alone otherwise, and rests on a product from now on.
struct Reseat {
  HypothesisId id;
  std::size_t on_product = 0;
  std::optional<double> foot_height_m = {};  // null: as it was
};

struct FromSupport {
  std::size_t support = 0;
  PointSet points = {};  // ascending
};

// Data: what a pass wants to replace, and by what. The points of the products are those of what is
// consumed and `from_support`, each once. Products are modelled in their order, and none after one
// that is not admitted: the likeliest to fail comes first.
struct Proposal {
  std::vector<Consumed> consumes = {};
  std::vector<Product> products = {};
  std::vector<Reseat> reseats = {};
  std::optional<FromSupport> from_support = {};
};

// A proposal whose products have models.
struct ModelledProposal {
  const SceneState& state;
  const Proposal& proposal;
  std::span<const ModelPtr> products;
  const RefinementContext& context;
};

// chosen: for passes that may ask at most objects: more than one image holds.
inline constexpr int kMaxTrials = 32;

// The work that a pass may cause in one scene.
struct Allowance {
  // Proposals that are modelled. measured: of 317 scenes none asked for more than three joins of
  // parts that something hides, of 45 real scans one, of clutter, for more than six of vessels'
  // walls.
  int max_trials = 8;
  // Of all points, one in so many may be modelled anew. chosen: bounds the work in clutter, where
  // much is proposed and little gained.
  std::size_t points_divisor = 4;
  std::string_view note;  // of the object whose trial was not allowed
};

class RefinementPass {
 public:
  virtual ~RefinementPass() = default;

  // As users name it in InterpretOptions::disabled_passes: "merge.occluded_parts".
  virtual std::string_view Name() const = 0;
  // Passes that must have run before.
  virtual std::span<const std::string_view> After() const { return {}; }
  virtual Allowance MaxWork() const = 0;

  // Proposals that look worth their price, likeliest first. All hypotheses have models.
  virtual std::vector<Proposal> Propose(const SceneState& state,
                                        const RefinementContext& context) const = 0;

  // A second, dearer look at one of them, which counts as a trial: the proposal in its final form, or
  // null. Asked once while the hypotheses live.
  virtual std::optional<Proposal> Examine(const SceneState& state, Proposal proposal,
                                          const RefinementContext& context) const {
    (void)state, (void)context;
    return proposal;
  }

  // Whether the shapes of a product are what was hoped for.
  virtual bool Admits(const SceneState& state, const Proposal& proposal, std::size_t product,
                      const ObjectModel& found) const {
    (void)state, (void)proposal, (void)product, (void)found;
    return true;
  }

  // What the products are better by than what they replace: the proposal is committed where that is
  // more than 0. Where proposals compete for a hypothesis, the greater gain wins.
  virtual double Gain(const ModelledProposal& modelled) const = 0;
};

}  // namespace cwm::perception
