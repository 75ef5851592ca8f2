// The driver of all passes: it models their proposals, evaluates them, commits those that gain, and
// remembers the others.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "perception/refinement/pass.h"

namespace cwm::perception {

using Passes = std::vector<std::unique_ptr<const RefinementPass>>;

// The outcome of one proposal.
struct Trial {
  enum class Outcome {
    kOpen,         // in progress
    kOverBudget,   // the pass's budget of work was spent
    kRejected,     // the pass's second examination rejected it
    kNotAdmitted,  // a product was not as expected
    kNoGain,
    kOutranked,  // another proposal for the same hypothesis gains more
    kCommitted,
  };
  std::string_view pass;
  Outcome outcome = Outcome::kOpen;
  double gain = 0;
  std::vector<HypothesisId> consumed = {};
  std::vector<HypothesisId> produced = {};  // for kCommitted
};

struct RefinedScene {
  SceneState state;
  std::vector<Trial> trials = {};
  std::vector<std::pair<HypothesisId, std::string>> notes = {};  // limits of work that were reached
};

// Runs the passes in their order, each until it gains no more, in at most three rounds or until no
// pass gains, within each pass's budget of trials and points for all rounds together. `disabled`
// names passes that are left out. Precondition: all hypotheses have models.
// Throws Stopped when the work is stopped. The result is the same on any number of threads.
RefinedScene Refine(SceneState state, const Passes& passes, std::span<const std::string> disabled,
                    const RefinementContext& context);

// Names of passes that run before one that they must follow; empty if the order is valid.
std::vector<std::string> PassesOutOfOrder(const Passes& passes);

}  // namespace cwm::perception
