// RMSAC: the randomised search for the next shape that explains many points (paper, section V).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "perception/cloud/work.h"
#include "perception/model/modeler_options.h"
#include "perception/search/candidate_list.h"
#include "perception/search/octree.h"

namespace cwm::perception {

// The points of the largest minimal sample, a cone's, and a point to test the model; all are
// different.
struct DrawnSample {
  std::array<std::uint32_t, 4> points = {};
  std::uint32_t cell = 0;  // cell of the octree that holds them all
};

// Draws a sample inside one cell around a random available point; the cell is that of a random
// level among those that hold enough points, each level equally likely. Empty if too few of the
// cell's points are available to be hit. At least one point is available, and `available` has one
// flag per point.
std::optional<DrawnSample> DrawSample(const Octree& octree, const std::vector<char>& available,
                                      std::mt19937_64& random);

// Draws minimal samples inside one cell of a random level of the octree around a random point
// (DrawSample). A model must agree with its own sample and with one more point of the cell (the
// T(1,1) test) before it becomes a candidate.
class ShapeSearch {
 public:
  // All arguments must outlive the search.
  ShapeSearch(const ModelPoints& points, const Octree& octree, CandidateList& candidates,
              const ModelerOptions& options, const Work& work);

  // Draws until a shape better than the best candidate would be missed with less than the
  // probability options.missed_shape_probability; or, without a candidate, until the same holds for
  // any shape of min_inliers points. Draws are counted afresh on every call.
  std::optional<Candidate> Next();

  bool is_exhausted() const { return is_exhausted_; }  // true if the draws ran out before that

 private:
  void Draw();
  template <ShapeModel M>
  void Propose(std::span<const std::uint32_t> sample, std::uint32_t tester);

  const ModelPoints& points_;
  const Octree& octree_;
  CandidateList& candidates_;
  const ModelerOptions& options_;
  const Work& work_;
  std::mt19937_64 random_;
  std::int64_t draws_left_;
  bool is_exhausted_ = false;
};

}  // namespace cwm::perception
