// All models that the search has generated, scored lazily (paper, section V: "we maintain a list of
// all models ... the rest of the models get rescored quickly by subtracting the inliers of the
// extracted model from their inlier lists").
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "perception/cloud/work.h"
#include "perception/search/any_model.h"
#include "perception/search/connectivity.h"
#include "perception/search/model_points.h"
#include "perception/search/point_lanes.h"

namespace cwm::perception {

struct Candidate {
  AnyModel model;
  std::vector<std::uint32_t> inliers;  // available points of the subsets evaluated so far
  std::size_t subsets_done = 0;
  double score = 0;        // MSAC over `inliers`: sum of 1 - (distance / gate)^2
  bool connected = false;  // true if all subsets are done and `inliers` are one component
  double bound = 0;        // upper confidence bound of the score over all available points
};

// Points are split into disjoint random subsets of doubling size. A candidate is scored on the
// first subset, which bounds its score on all points with confidence. Further subsets are evaluated
// only if the bounds leave the leader open.
class CandidateList {
 public:
  // All arguments but the seed must outlive the list. `seed` determines the order of the subsets.
  CandidateList(const ModelPoints& points, const Connectivity& connectivity, std::uint64_t seed,
                const Work& work = kSerialWork);

  void Add(const AnyModel& model);

  // Returns the candidate with the best exact score over its largest connected component; null if
  // the list is empty. Candidates whose upper bound exceeds it by less than a tenth stay
  // unevaluated, since the refinement makes up for that. Valid until the list changes.
  const Candidate* Leader();

  // Removes points and rescores all candidates by subtraction.
  void Remove(std::span<const std::uint32_t> taken);

  // Drops the candidates of the leader's kind that mostly consist of its points. Called when the
  // model selection rejected the leader.
  void Reject(const Candidate& leader);

  const std::vector<char>& available() const { return available_; }  // one flag per point
  std::size_t available_count() const { return available_count_; }
  const std::vector<Candidate>& candidates() const { return candidates_; }

 private:
  void EvaluateNextSubset(Candidate& candidate) const;
  void KeepLargestComponent(Candidate& candidate) const;
  void Rescore(Candidate& candidate) const;
  double UpperBound(const Candidate& candidate) const;  // the value of Candidate::bound
  bool IsRejected(const Candidate& candidate) const;
  void GatherAvailable();
  void Prune();

  const ModelPoints& points_;
  const Connectivity& connectivity_;
  const Work& work_;
  std::vector<std::uint32_t> shuffled_;        // all points, in random order
  std::vector<std::size_t> subset_end_;        // end of each subset in shuffled_
  std::vector<std::size_t> subset_remaining_;  // available points in the subsets up to each one
  std::vector<std::uint32_t> remaining_;       // the available points of shuffled_, in that order
  PointLanes remaining_lanes_;                 // the same points
  std::vector<char> available_;
  std::vector<unsigned char> rejected_kinds_;  // per point: bit k for the k-th kind of AnyModel
  std::size_t available_count_ = 0;
  std::vector<Candidate> candidates_;
};

}  // namespace cwm::perception
