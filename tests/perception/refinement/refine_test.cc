// The driver, with passes whose proposals and gains are set by the test.
#include "perception/refinement/refine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <utility>

#include "perception/hypotheses/invariants.h"
#include "perception/refinement/evidence.h"
#include "tests/perception/refinement/hand_built.h"

namespace cwm::perception {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// Proposes to merge the given pairs, each with the given gain.
class MergePairs : public RefinementPass {
 public:
  struct Pair {
    HypothesisId a, b;
    double gain = 1;
  };
  explicit MergePairs(std::vector<Pair> pairs,
                      TrialBudget allowance = {.points_divisor = 1, .note = "too much"})
      : pairs_(std::move(pairs)), allowance_(allowance) {}

  std::string_view Name() const override { return "test.merge"; }
  TrialBudget MaxWork() const override { return allowance_; }
  std::vector<Proposal> Propose(const SceneState& state, const RefinementContext&) const override {
    std::vector<Proposal> proposals;
    for (const Pair& pair : pairs_) {
      if (state.Find(pair.a) == nullptr || state.Find(pair.b) == nullptr) continue;
      const std::array both = {pair.a, pair.b};
      proposals.push_back({.consumes = {{pair.a}, {pair.b}}, .products = {Merged(state, both)}});
    }
    return proposals;
  }
  bool Admits(const SceneState&, const Proposal&, std::size_t, const ObjectModel&) const override {
    ++modelled_;
    return true;
  }
  double Gain(const ModelledProposal& modelled) const override {
    const Proposal& proposal = modelled.proposal;
    for (const Pair& pair : pairs_) {
      if (pair.a == proposal.consumes[0].id && pair.b == proposal.consumes[1].id) return pair.gain;
    }
    return 0;
  }
  int modelled() const { return modelled_; }

 private:
  std::vector<Pair> pairs_;
  TrialBudget allowance_;
  mutable std::atomic<int> modelled_ = 0;
};

class Driver : public ::testing::Test {
 protected:
  Driver() {
    HandBuilt scene;
    for (int k = 0; k < 3; ++k) {
      scene.Add({Standing(Box{{0.05, 0.05, 0.04}}, 0.1 * k - 0.1, 0.07 * k)});
    }
    const HypothesisId top = scene.Add({Standing(Sphere{0.02}, -0.1, 0, 0.04)});
    scene.Rest(top, {0}, 0.04);
    state_.emplace(scene.Modelled());
  }

  RefinedScene Run(const MergePairs& pass, int threads = 1) const {
    Passes passes;
    passes.push_back(std::make_unique<const Forward>(pass));
    const HypothesisModeler modeler(state_->measured(), kSerialWork);
    const ModelingOptions options;
    const Work work{.max_threads = threads};
    return Refine(*state_, passes, {}, {.options = options, .modeler = modeler, .work = work});
  }

  // Forwards to the test's pass, whose counts are read after the run.
  class Forward : public RefinementPass {
   public:
    explicit Forward(const MergePairs& pass) : pass_(pass) {}
    std::string_view Name() const override { return pass_.Name(); }
    TrialBudget MaxWork() const override { return pass_.MaxWork(); }
    std::vector<Proposal> Propose(const SceneState& s, const RefinementContext& c) const override {
      return pass_.Propose(s, c);
    }
    bool Admits(const SceneState& s, const Proposal& p, std::size_t k,
                const ObjectModel& found) const override {
      return pass_.Admits(s, p, k, found);
    }
    double Gain(const ModelledProposal& modelled) const override { return pass_.Gain(modelled); }

   private:
    const MergePairs& pass_;
  };

  std::optional<SceneState> state_;
};

TEST_F(Driver, CommitsWhatGains) {
  const MergePairs pass({{{0}, {1}, 1}});
  const RefinedScene refined = Run(pass);
  EXPECT_THAT(refined.state.hypotheses(), SizeIs(3));
  EXPECT_THAT(ViolatedInvariants(refined.state), IsEmpty());
  ASSERT_THAT(refined.trials, SizeIs(1));
  EXPECT_EQ(refined.trials[0].outcome, Trial::Outcome::kCommitted);
  EXPECT_THAT(refined.trials[0].consumed, ElementsAre(HypothesisId{0}, HypothesisId{1}));
}

TEST_F(Driver, RefusesWhatGainsNothing) {
  const MergePairs pass({{{0}, {1}, 0}});
  const RefinedScene refined = Run(pass);
  EXPECT_THAT(refined.state.hypotheses(), SizeIs(4));
  ASSERT_THAT(refined.trials, SizeIs(1));
  EXPECT_EQ(refined.trials[0].outcome, Trial::Outcome::kNoGain);
}

// A refused proposal is modelled once, in this round and in the next ones, as long as its
// hypotheses live.
TEST_F(Driver, ModelsARefusedProposalOnce) {
  const MergePairs pass({{{0}, {1}, 0}, {{2}, {3}, 1}});
  Run(pass);
  EXPECT_EQ(pass.modelled(), 2);
}

TEST_F(Driver, GivesAHypothesisToTheGreaterGain) {
  const MergePairs pass({{{0}, {1}, 1}, {{1}, {2}, 2}});
  const RefinedScene refined = Run(pass);
  EXPECT_EQ(refined.state.Find({1}), nullptr);
  EXPECT_EQ(refined.state.Find({2}), nullptr);
  EXPECT_NE(refined.state.Find({0}), nullptr);
  EXPECT_EQ(refined.trials[0].outcome, Trial::Outcome::kOutranked);
}

TEST_F(Driver, LetsWhatRestedOnTheConsumedRestOnTheHeir) {
  const MergePairs pass({{{0}, {1}, 1}});
  const RefinedScene refined = Run(pass);
  EXPECT_EQ(refined.state.Get({3}).resting.on, refined.trials[0].produced.front());
}

TEST_F(Driver, SaysOnceThatTheWorkOfAPassWasSpent) {
  const MergePairs pass({{{0}, {1}, 0}, {{1}, {2}, 0}, {{0}, {2}, 0}},
                        {.max_trials = 1, .points_divisor = 1, .note = "too much"});
  const RefinedScene refined = Run(pass);
  EXPECT_THAT(refined.trials, SizeIs(1));
  ASSERT_THAT(refined.notes, SizeIs(1));
  EXPECT_EQ(refined.notes[0].second, "too much");
}

TEST_F(Driver, ModelsNoMorePointsThanThePassMay) {
  const MergePairs pass({{{0}, {1}, 1}},
                        {.max_trials = 8, .points_divisor = 1'000'000, .note = "too much"});
  const RefinedScene refined = Run(pass);
  EXPECT_EQ(pass.modelled(), 0);
  ASSERT_THAT(refined.trials, SizeIs(1));
  EXPECT_EQ(refined.trials[0].outcome, Trial::Outcome::kOverBudget);
}

TEST_F(Driver, EndsAlikeOnAnyNumberOfThreads) {
  const std::vector<MergePairs::Pair> pairs = {{{0}, {1}, 1}, {{1}, {2}, 1}, {{2}, {3}, 1}};
  const MergePairs one(pairs), other(pairs);
  const RefinedScene alone = Run(one, 1), together = Run(other, 4);
  ASSERT_EQ(alone.trials.size(), together.trials.size());
  for (std::size_t k = 0; k < alone.trials.size(); ++k) {
    EXPECT_EQ(alone.trials[k].outcome, together.trials[k].outcome);
    EXPECT_EQ(alone.trials[k].consumed, together.trials[k].consumed);
  }
}

TEST_F(Driver, LeavesADisabledPassOut) {
  const MergePairs pass({{{0}, {1}, 1}});
  Passes passes;
  passes.push_back(std::make_unique<const Forward>(pass));
  const HypothesisModeler modeler(state_->measured(), kSerialWork);
  const ModelingOptions options;
  const std::vector<std::string> disabled = {"test.merge"};
  const RefinedScene refined = Refine(
      *state_, passes, disabled, {.options = options, .modeler = modeler, .work = kSerialWork});
  EXPECT_THAT(refined.trials, IsEmpty());
}

}  // namespace
}  // namespace cwm::perception
