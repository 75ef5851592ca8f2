// The one driver of all passes: it models what they propose, asks them, commits what gains, and
// remembers what did not.
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

// What became of one proposal.
struct Trial {
  enum class Outcome {
    kOpen,         // under way
    kTooDear,      // the pass's work was spent
    kNotExamined,  // the pass's second look found nothing in it
    kNotAdmitted,  // a product was not what was hoped for
    kNoGain,
    kOutbid,  // another proposal for the same hypothesis gains more
    kCommitted,
  };
  std::string_view pass;
  Outcome outcome = Outcome::kOpen;
  double gain = 0;
  std::vector<HypothesisId> consumed = {};
  std::vector<HypothesisId> produced = {};  // of kCommitted
};

struct RefinedScene {
  SceneState state;
  std::vector<Trial> trials = {};
  std::vector<std::pair<HypothesisId, std::string>> notes = {};  // limits of work that were reached
};

// Runs the passes in their order, each until it gains no more, and all again until none does.
// `disabled` names passes that are left out. Precondition: all hypotheses have models. Throws Stopped
// when the work is stopped. The result is the same on any number of threads.
RefinedScene Refine(SceneState state, const Passes& passes, std::span<const std::string> disabled,
                    const RefinementContext& context);

// Names of passes that run before one that they must follow; empty of a sound order.
std::vector<std::string> OutOfOrder(const Passes& passes);

}  // namespace cwm::perception
