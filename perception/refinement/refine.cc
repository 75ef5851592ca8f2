#include "perception/refinement/refine.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <set>
#include <stdexcept>
#include <tuple>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "perception/cloud/parallel_for.h"
#include "perception/hypotheses/invariants.h"
#include "perception/refinement/commit.h"
#include "perception/refinement/evidence.h"

namespace cwm::perception {
namespace {

// chosen: bounds the work; a change may give an earlier pass new proposals.
constexpr int kMaxRounds = 3;

// Proposals are equal if they consume the same hypotheses and divide them equally.
using ProposalKey = std::tuple<std::vector<HypothesisId>, std::uint64_t>;

ProposalKey KeyOf(const Proposal& proposal) {
  std::vector<HypothesisId> consumed;
  for (const Consumed& one : proposal.consumes) consumed.push_back(one.id);
  std::ranges::sort(consumed);
  std::uint64_t hash = 14695981039346656037ULL;  // cited: FNV-1a, Fowler, Noll and Vo
  const auto mix = [&hash](std::uint64_t value) { hash = (hash ^ value) * 1099511628211ULL; };
  for (const Product& product : proposal.products) {
    mix(product.points.size());
    for (std::uint32_t i : product.points) mix(i);
  }
  return {std::move(consumed), hash};
}

std::vector<HypothesisId> IdsOf(const Proposal& proposal) {
  std::vector<HypothesisId> ids;
  for (const Consumed& consumed : proposal.consumes) ids.push_back(consumed.id);
  return ids;
}

// One proposal in progress.
struct Attempt {
  Proposal proposal;
  ProposalKey key;
  Trial trial = {};
  std::vector<ModelPtr> models = {};
};

// Runs one pass, over all rounds.
class PassRunner {
 public:
  PassRunner(const RefinementPass& pass, const RefinementContext& context, std::size_t points)
      : pass_(pass),
        context_(context),
        trials_left_(pass.MaxWork().max_trials),
        points_left_(points / pass.MaxWork().points_divisor) {}

  // True if a proposal was committed.
  bool Run(RefinedScene& refined) {
    bool any = false;
    while (RunOnce(refined)) any = true;
    return any;
  }

 private:
  bool RunOnce(RefinedScene& refined) {
    context_.work.Poll();
    std::vector<Attempt> attempts = NewAttempts(refined);
    ForEach(attempts, [&](Attempt& attempt) { Examine(refined.state, attempt); });
    SpendPoints(attempts, refined);
    ForEach(attempts, [&](Attempt& attempt) { Try(refined.state, attempt); });
    const bool any = CommitBest(attempts, refined);
    for (Attempt& attempt : attempts) refined.trials.push_back(std::move(attempt.trial));
    return any;
  }

  // Calls body for the attempts that are still open, in parallel.
  template <class Body>
  void ForEach(std::vector<Attempt>& attempts, const Body& body) const {
    ParallelFor(attempts.size(), 1, context_.work, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        if (attempts[k].trial.outcome == Trial::Outcome::kOpen) body(attempts[k]);
      }
    });
  }

  void NoteLimit(const Proposal& proposal, RefinedScene& refined) {
    if (std::exchange(told_of_limit_, true)) return;
    refined.notes.emplace_back(proposal.consumes.front().id, pass_.MaxWork().note);
  }

  // Attempts for the proposals that were not tried before.
  std::vector<Attempt> NewAttempts(RefinedScene& refined) {
    std::vector<Attempt> attempts;
    for (Proposal& proposal : pass_.Propose(refined.state, context_)) {
      ProposalKey key = KeyOf(proposal);
      if (!known_.insert(key).second) continue;
      if (trials_left_ == 0) {
        NoteLimit(proposal, refined);
        break;
      }
      --trials_left_;
      Trial trial{.pass = pass_.Name(), .consumed = IdsOf(proposal)};
      attempts.push_back({std::move(proposal), std::move(key), std::move(trial)});
    }
    return attempts;
  }

  void Examine(const SceneState& state, Attempt& attempt) const {
    std::optional<Proposal> examined = pass_.Examine(state, std::move(attempt.proposal), context_);
    if (!examined) {
      attempt.trial.outcome = Trial::Outcome::kRejected;
      return;
    }
    attempt.proposal = *std::move(examined);
    attempt.trial.consumed = IdsOf(attempt.proposal);
  }

  void SpendPoints(std::vector<Attempt>& attempts, RefinedScene& refined) {
    for (Attempt& attempt : attempts) {
      if (attempt.trial.outcome != Trial::Outcome::kOpen) continue;
      const std::size_t points = CountPoints(refined.state, attempt.proposal);
      if (points <= points_left_) {
        points_left_ -= points;
        continue;
      }
      attempt.trial.outcome = Trial::Outcome::kOverBudget;
      NoteLimit(attempt.proposal, refined);
    }
  }

  void Try(const SceneState& state, Attempt& attempt) const {
    for (std::size_t k = 0; k < attempt.proposal.products.size(); ++k) {
      context_.work.Poll();
      ModelPtr model = ModelOf(state, attempt.proposal, k);
      if (!model) {
        attempt.trial.outcome = Trial::Outcome::kNotAdmitted;
        return;
      }
      attempt.models.push_back(std::move(model));
    }
    attempt.trial.gain = pass_.Gain({state, attempt.proposal, attempt.models, context_});
    if (!(attempt.trial.gain > 0)) attempt.trial.outcome = Trial::Outcome::kNoGain;
  }

  ModelPtr ModelOf(const SceneState& state, const Proposal& proposal, std::size_t k) const {
    const Product& product = proposal.products[k];
    const ObjectHypothesis hypothesis = HypothesisOf(product);
    if (product.given_shapes) {
      return context_.modeler.ModelGiven(hypothesis, *product.given_shapes);
    }
    ModelingOptions options = context_.options;
    if (product.expects == Expectation::kSingleObject) options.modeler.split_touching = false;
    const auto admits = [&](const ObjectModel& found) {
      return pass_.Admits(state, proposal, k, found);
    };
    return context_.modeler.ModelIf(admits, hypothesis, options);
  }

  // Commits the greatest gains first; proposals that compete with one of them must be proposed
  // again.
  bool CommitBest(std::vector<Attempt>& attempts, RefinedScene& refined) {
    std::vector<Attempt*> gaining;
    for (Attempt& attempt : attempts) {
      if (attempt.trial.outcome == Trial::Outcome::kOpen) gaining.push_back(&attempt);
    }
    std::ranges::stable_sort(gaining, std::ranges::greater(),
                             [](const Attempt* attempt) { return attempt->trial.gain; });
    std::set<HypothesisId> changed;
    std::set<std::size_t> supports;
    for (Attempt* attempt : gaining) {
      const Proposal& proposal = attempt->proposal;
      bool is_free = !proposal.from_support || !supports.contains(proposal.from_support->support);
      for (const Consumed& consumed : proposal.consumes) is_free &= !changed.contains(consumed.id);
      for (const RestingUpdate& update : proposal.resting_updates)
        is_free &= !changed.contains(update.id);
      for (const Product& product : proposal.products) {
        is_free &= !product.resting.on || !changed.contains(*product.resting.on);
      }
      if (!is_free) {
        attempt->trial.outcome = Trial::Outcome::kOutranked;
        known_.erase(attempt->key);
        continue;
      }
      for (const Consumed& consumed : proposal.consumes) changed.insert(consumed.id);
      for (const RestingUpdate& update : proposal.resting_updates) changed.insert(update.id);
      if (proposal.from_support) supports.insert(proposal.from_support->support);
      attempt->trial.outcome = Trial::Outcome::kCommitted;
      for (std::size_t k = 0; k < proposal.products.size(); ++k) {
        attempt->trial.produced.push_back(refined.state.NextId(k));
      }
      refined.state = Commit(refined.state, proposal, attempt->models);
      CheckInvariants(refined.state);
    }
    return !changed.empty();
  }

  void CheckInvariants(const SceneState& state) const {
#ifndef NDEBUG
    if (const std::vector<std::string> broken = ViolatedInvariants(state); !broken.empty()) {
      throw std::logic_error(
          absl::StrCat(std::string(pass_.Name()), ": ", absl::StrJoin(broken, "; ")));
    }
#else
    (void)state;
#endif
  }

  const RefinementPass& pass_;
  const RefinementContext& context_;
  int trials_left_;
  std::size_t points_left_;
  std::set<ProposalKey> known_;  // proposals that were tried
  bool told_of_limit_ = false;
};

}  // namespace

RefinedScene Refine(SceneState state, const Passes& passes, std::span<const std::string> disabled,
                    const RefinementContext& context) {
  std::vector<PassRunner> runners;
  for (const auto& pass : passes) {
    if (std::ranges::count(disabled, pass->Name()) > 0) continue;
    runners.emplace_back(*pass, context, state.points().size());
  }
  RefinedScene refined{.state = std::move(state)};
  bool any = true;
  for (int round = 0; round < kMaxRounds && any; ++round) {
    any = false;
    for (PassRunner& runner : runners) any |= runner.Run(refined);
  }
  return refined;
}

std::vector<std::string> PassesOutOfOrder(const Passes& passes) {
  std::vector<std::string> wrong;
  for (std::size_t k = 0; k < passes.size(); ++k) {
    for (const std::string_view before : passes[k]->After()) {
      const bool comes_before =
          std::any_of(passes.begin(), passes.begin() + static_cast<std::ptrdiff_t>(k),
                      [&](const auto& other) { return other->Name() == before; });
      if (!comes_before)
        wrong.push_back(
            absl::StrCat(std::string(passes[k]->Name()), " before ", std::string(before)));
    }
  }
  return wrong;
}

}  // namespace cwm::perception
