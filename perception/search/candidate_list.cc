#include "perception/search/candidate_list.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "perception/cloud/tolerances.h"
#include "perception/search/random_index.h"

namespace cwm::perception {
namespace {

// chosen: upper bounds within a tenth do not change the leader.
constexpr double kLeaderSlack = 1.1;

// chosen: enough points to distinguish 5 % of inliers from 20 %.
constexpr std::size_t kFirstSubset = 128;
// chosen: standard deviations of the bound of a score; 99 % on one side.
constexpr double kConfidence_sigma = 2.5;
// chosen: a candidate that shares more of its inliers with a rejected one is nearly the same.
constexpr double kRejectedShare = 0.7;
// chosen: bounds the candidates that each choice of a leader goes through.
constexpr std::size_t kMaxCandidates = 400;

unsigned char KindBit(const AnyModel& model) {
  return static_cast<unsigned char>(1U << model.index());
}

double ScoreOf(double distance_m, double gate_m) {
  const double ratio = distance_m / gate_m;
  return 1 - ratio * ratio;
}

}  // namespace

CandidateList::CandidateList(const ModelPoints& points, const Connectivity& connectivity,
                             std::uint64_t seed, const Work& work)
    : points_(points),
      connectivity_(connectivity),
      work_(work),
      shuffled_(points.size()),
      available_(points.size(), 1),
      rejected_kinds_(points.size(), 0) {
  std::mt19937_64 random(seed);
  for (std::size_t i = 0; i < shuffled_.size(); ++i) shuffled_[i] = static_cast<std::uint32_t>(i);
  for (std::size_t i = shuffled_.size(); i > 1; --i) {
    std::swap(shuffled_[i - 1], shuffled_[RandomIndex(random, i)]);
  }
  for (std::size_t end = kFirstSubset; end < shuffled_.size(); end = 2 * end + kFirstSubset) {
    subset_end_.push_back(end);
  }
  subset_end_.push_back(shuffled_.size());
  GatherAvailable();
}

void CandidateList::GatherAvailable() {
  remaining_.clear();
  subset_remaining_.clear();
  std::size_t i = 0;
  for (std::size_t end : subset_end_) {
    for (; i < end; ++i) {
      if (available_[shuffled_[i]]) remaining_.push_back(shuffled_[i]);
    }
    subset_remaining_.push_back(remaining_.size());
  }
  available_count_ = remaining_.size();
  remaining_lanes_ = PointLanes(points_, remaining_);
}

void CandidateList::Add(const AnyModel& model) {
  work_.Poll();
  Candidate candidate;
  candidate.model = model;
  EvaluateNextSubset(candidate);
  if (candidate.inliers.empty() && candidate.subsets_done < subset_end_.size()) {
    EvaluateNextSubset(candidate);  // small shapes may have no point in the first subset
  }
  if (candidate.inliers.empty() || IsRejected(candidate)) return;
  candidates_.push_back(std::move(candidate));
  if (candidates_.size() > kMaxCandidates) Prune();
}

void CandidateList::EvaluateNextSubset(Candidate& candidate) const {
  const std::size_t k = candidate.subsets_done++;
  const PointLanes::Range subset{k == 0 ? 0 : subset_remaining_[k - 1], subset_remaining_[k]};
  for (const Hit& hit : remaining_lanes_.HitsIn(candidate.model, {&subset, 1})) {
    const std::uint32_t i = remaining_[hit.at];
    candidate.inliers.push_back(i);
    candidate.score += ScoreOf(hit.distance_m, points_.gate_m[i]);
  }
  candidate.bound = UpperBound(candidate);
}

void CandidateList::Rescore(Candidate& candidate) const {
  candidate.score = std::visit(
      [&](const auto& model) {
        double score = 0;
        for (std::uint32_t i : candidate.inliers) {
          score += ScoreOf(model.Distance_m(points_.p[i]), points_.gate_m[i]);
        }
        return score;
      },
      candidate.model);
}

void CandidateList::KeepLargestComponent(Candidate& candidate) const {
  std::sort(candidate.inliers.begin(), candidate.inliers.end());
  candidate.inliers = connectivity_.LargestComponent(candidate.inliers);
  candidate.connected = true;
  Rescore(candidate);
  candidate.bound = UpperBound(candidate);
}

double CandidateList::UpperBound(const Candidate& candidate) const {
  if (candidate.subsets_done == subset_end_.size()) return candidate.score;
  const auto seen = static_cast<double>(subset_remaining_[candidate.subsets_done - 1]);
  if (seen < 1) return static_cast<double>(available_count_);
  // The binomial share of inliers in the points seen, with one added for a sample without inliers.
  const double share = std::min(1.0, candidate.score / seen);
  const double sd = std::sqrt((share * (1 - share) + 1 / seen) / seen);
  return static_cast<double>(available_count_) * std::min(1.0, share + kConfidence_sigma * sd);
}

bool CandidateList::IsRejected(const Candidate& candidate) const {
  std::size_t rejected = 0;
  for (std::uint32_t i : candidate.inliers) {
    rejected += (rejected_kinds_[i] & KindBit(candidate.model)) ? 1 : 0;
  }
  return static_cast<double>(rejected) >
         kRejectedShare * static_cast<double>(candidate.inliers.size());
}

const Candidate* CandidateList::Leader() {
  std::size_t leader = candidates_.size();
  while (!candidates_.empty()) {
    work_.Poll();
    std::size_t best = 0, rejected = candidates_.size();
    double best_bound = -1;
    for (std::size_t c = 0; c < candidates_.size(); ++c) {
      if (candidates_[c].bound > best_bound) best = c, best_bound = candidates_[c].bound;
    }
    if (leader < candidates_.size() && best_bound <= kLeaderSlack * candidates_[leader].score) {
      return &candidates_[leader];
    }
    Candidate& candidate = candidates_[best];
    if (candidate.connected) return &candidate;
    if (candidate.subsets_done < subset_end_.size()) {
      EvaluateNextSubset(candidate);
    } else {
      KeepLargestComponent(candidate);
      if (candidate.inliers.empty() || IsRejected(candidate)) rejected = best;
    }
    if (rejected < candidates_.size()) {
      candidates_.erase(candidates_.begin() + static_cast<std::ptrdiff_t>(rejected));
      leader = candidates_.size();
      for (std::size_t c = 0; c < candidates_.size(); ++c) {
        if (!candidates_[c].connected) continue;
        if (leader == candidates_.size() || candidates_[c].score > candidates_[leader].score) {
          leader = c;
        }
      }
    } else if (candidate.connected &&
               (leader >= candidates_.size() || candidate.score > candidates_[leader].score)) {
      leader = best;
    }
  }
  return nullptr;
}

void CandidateList::Remove(std::span<const std::uint32_t> taken) {
  for (std::uint32_t i : taken) available_[i] = 0;
  GatherAvailable();
  for (Candidate& candidate : candidates_) {
    work_.Poll();
    const std::size_t before = candidate.inliers.size();
    std::erase_if(candidate.inliers, [this](std::uint32_t i) { return !available_[i]; });
    if (candidate.inliers.size() != before) {
      candidate.connected = false;  // the rest may have fallen apart
      Rescore(candidate);
    }
    candidate.bound = UpperBound(candidate);
  }
  std::erase_if(candidates_, [](const Candidate& c) { return c.inliers.empty(); });
}

void CandidateList::Reject(const Candidate& leader) {
  for (std::uint32_t i : leader.inliers) rejected_kinds_[i] |= KindBit(leader.model);
  std::erase_if(candidates_, [this](const Candidate& c) { return IsRejected(c); });
}

void CandidateList::Prune() {
  std::vector<std::pair<double, std::size_t>> bounds;
  for (std::size_t c = 0; c < candidates_.size(); ++c) {
    bounds.emplace_back(-candidates_[c].bound, c);
  }
  std::sort(bounds.begin(), bounds.end());
  std::vector<Candidate> kept;
  for (std::size_t k = 0; k < kMaxCandidates / 2; ++k) {
    kept.push_back(std::move(candidates_[bounds[k].second]));
  }
  candidates_ = std::move(kept);
}

}  // namespace cwm::perception
