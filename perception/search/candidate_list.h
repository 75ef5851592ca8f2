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
  std::vector<std::uint32_t> inliers;  // available ones, of the subsets evaluated so far
  std::size_t subsets_done = 0;
  double score = 0;        // MSAC over `inliers`: sum of 1 - (distance / gate)^2
  bool connected = false;  // all subsets done, and `inliers` are one component
  double bound = 0;        // of the score over all available points, from above, with confidence
};

// Points are split into disjoint random subsets of doubling size. A candidate is scored on the
// first one; its score on all points is bounded from that with confidence, and further subsets are
// evaluated only where the bounds leave the leader open.
class CandidateList {
 public:
  // All but the seed must outlive the list. The order of the subsets follows `seed`.
  CandidateList(const ModelPoints& points, const Connectivity& connectivity, std::uint64_t seed,
                const Work& work = kUnbounded);

  void Add(const AnyModel& model);

  // The candidate with the best score over its largest connected component, exactly; null when
  // the list is empty. Rivals whose upper bound exceeds it by less than a tenth stay unevaluated:
  // the refinement makes up for that. Valid until the list changes.
  const Candidate* Leader();

  // Takes points away and rescores all candidates by subtraction.
  void Remove(std::span<const std::uint32_t> taken);

  // Drops the candidates of the leader's kind that mostly consist of its points: the leader was
  // looked at closer and refused.
  void Refuse(const Candidate& leader);

  const std::vector<char>& available() const { return available_; }  // per point
  std::size_t available_count() const { return available_count_; }
  const std::vector<Candidate>& candidates() const { return candidates_; }

 private:
  void EvaluateNextSubset(Candidate& candidate) const;
  void KeepLargestComponent(Candidate& candidate) const;
  void Rescore(Candidate& candidate) const;
  double UpperBound(const Candidate& candidate) const;  // what Candidate::bound holds
  bool IsRefused(const Candidate& candidate) const;
  void GatherAvailable();
  void Prune();

  const ModelPoints& points_;
  const Connectivity& connectivity_;
  const Work& work_;
  std::vector<std::uint32_t> shuffled_;    // all points, in random order
  std::vector<std::size_t> subset_end_;    // into shuffled_
  std::vector<std::size_t> subset_alive_;  // available points in the subsets up to each one
  std::vector<std::uint32_t> alive_;       // the available points of shuffled_, in that order
  PointLanes alive_lanes_;                 // the same
  std::vector<char> available_;
  std::vector<unsigned char> refused_kinds_;  // per point: bit k for the k-th kind of AnyModel
  std::size_t available_count_ = 0;
  std::vector<Candidate> candidates_;
};

}  // namespace cwm::perception
