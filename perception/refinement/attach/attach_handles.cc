#include "perception/refinement/attach/attach_handles.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "perception/cloud/parallel_for.h"
#include "perception/cloud/quantile.h"
#include "perception/cloud/tolerances.h"
#include "perception/handles/vessel_handles.h"
#include "perception/hypotheses/point_sample.h"

namespace cwm::perception {
namespace {

// measured: the number of points that may be searched for other objects' handles, in multiples of
// the scene's points. Kitchens with their walls need 5; a thousand touching balls need 50, which is
// more than this budget.
constexpr std::size_t kMaxSearchesPerPoint = 10;

Eigen::AlignedBox3f BoundsOf(const OrientedPoints& points, const PointSet& members) {
  Eigen::AlignedBox3f bounds;
  for (std::uint32_t i : members) bounds.extend(points.points[i]);
  return bounds;
}

// True if the points stand on the vessel's support, if that is known: their lower end is within the
// reach of its noise, like that of a pen that lies there.
bool Stands(const SegmentedScene& measured, const PointSet& members, std::int32_t support) {
  if (support < 0) return false;
  const Pose X_SL =
      measured.supports[static_cast<std::size_t>(support)].plate.X_FS.inverse(Eigen::Isometry);
  std::vector<double> heights_m;
  double sigma_m = 0;
  for (std::uint32_t i : members) {
    heights_m.push_back((X_SL * measured.points.points[i].cast<double>()).z());
    sigma_m = std::max(sigma_m, double{measured.points.sigma_m[i]});
  }
  return Quantile(std::move(heights_m), kFootQuantile) <= kNoiseReach_sigma * sigma_m;
}

// Points of one hypothesis that another one receives.
struct PartTransfer {
  std::size_t from = 0, to = 0;
  PointSet points;
};

class HandleAttacher {
 public:
  HandleAttacher(const SceneState& state, const Work& work)
      : state_(state),
        work_(work),
        vessels_(state.hypotheses().size()),
        known_(state.hypotheses().size()),
        is_searched_(state.hypotheses().size(), 0),
        transferred_to_(state.hypotheses().size()),
        point_budget_(kMaxSearchesPerPoint * state.points().size()) {
    std::iota(transferred_to_.begin(), transferred_to_.end(), std::size_t{0});
    for (const HypothesisPtr& hypothesis : state.hypotheses()) {
      bounds_.push_back(BoundsOf(state.points(), hypothesis->points));
    }
  }

  // Searches all objects that others touch in parallel, because each takes long and its result is
  // needed.
  void SearchTouchedVessels() {
    std::vector<std::size_t> touched;
    for (std::size_t k = 0; k < transferred_to_.size(); ++k) {
      work_.Poll();
      if (IsTouched(k)) touched.push_back(k);
    }
    ParallelFor(touched.size(), 1, work_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t n = begin; n < end; ++n) SearchVessel(touched[n]);
    });
  }

  // One round over all objects; true if any part was given. More parts may be attached to it in the
  // next round.
  bool AttachRound() {
    bool any = false;
    for (std::size_t part = 0; part < transferred_to_.size(); ++part) {
      work_.Poll();
      if (transferred_to_[part] != part || !IsLarge(part)) continue;
      const std::size_t vessel = VesselOf(part);
      if (vessel == part) continue;
      AddKnownPoints(SampleOf(At(part)).Points().points, vessel);
      bounds_[vessel].extend(bounds_[part]);
      transferred_to_[part] = vessel;
      any = true;
    }
    return any;
  }

  // For objects that remain: gives their points that are handles of the wall of another object that
  // they touch.
  void AttachParts() {
    for (std::size_t k = 0; k < transferred_to_.size(); ++k) {
      if (transferred_to_[k] != k) continue;
      for (std::size_t from = 0; from < transferred_to_.size(); ++from) {
        work_.Poll();
        if (from == k || transferred_to_[from] != from || !IsLarge(from) ||
            bounds_[from].exteriorDistance(bounds_[k]) > kMaxTouchingGap_m) {
          continue;
        }
        if (!is_searched_[k]) SearchVessel(k);
        if (!vessels_[k]) break;
        if (At(from).points.size() > point_budget_) {
          all_searched_ = false;
          return;
        }
        point_budget_ -= At(from).points.size();
        AttachPartsOf(from, k);
      }
    }
  }

  FoundHandles Result() const {
    FoundHandles found{.transfers = {}, .all_searched = all_searched_};
    for (const PartTransfer& part : part_transfers_) {
      found.transfers.push_back({At(part.from).id, At(part.to).id, part.points});
    }
    for (std::size_t k = 0; k < transferred_to_.size(); ++k) {
      if (transferred_to_[k] != k)
        found.transfers.push_back({At(k).id, At(transferred_to_[k]).id, {}});
    }
    return found;
  }

 private:
  const ObjectHypothesis& At(std::size_t k) const { return *state_.hypotheses()[k]; }
  PointSample SampleOf(const ObjectHypothesis& hypothesis) const {
    return {state_.points(), hypothesis.points, hypothesis.node_count};
  }

  bool IsLarge(std::size_t k) const { return At(k).points.size() >= kMinHandlePoints; }

  bool IsTouched(std::size_t k) const {
    for (std::size_t other = 0; other < transferred_to_.size(); ++other) {
      if (other != k && IsLarge(other) &&
          bounds_[other].exteriorDistance(bounds_[k]) <= kMaxTouchingGap_m) {
        return true;
      }
    }
    return false;
  }

  std::size_t VesselOf(std::size_t part) {
    const ObjectHypothesis& hypothesis = At(part);
    const double min_points = static_cast<double>(hypothesis.points.size()) / kMajority;
    for (std::size_t k = 0; k < transferred_to_.size(); ++k) {
      const ObjectHypothesis& vessel = At(k);
      if (k == part || transferred_to_[k] != k) continue;
      if (static_cast<double>(vessel.points.size()) < min_points) continue;
      if (bounds_[part].exteriorDistance(bounds_[k]) > kMaxTouchingGap_m) continue;
      if (IsHandleOf(hypothesis, k)) return k;
    }
    return part;
  }

  void AddKnownPoints(const std::vector<Eigen::Vector3f>& points, std::size_t vessel) {
    known_[vessel].insert(known_[vessel].end(), points.begin(), points.end());
  }

  void SearchVessel(std::size_t k) {
    is_searched_[k] = 1;
    const OrientedPoints points = SampleOf(At(k)).Points();
    vessels_[k] = Vessel::Find(points, work_);
    if (!vessels_[k]) return;
    const std::vector<char> all(points.size(), 1);
    for (const Vessel::Cluster& handle : vessels_[k]->FindFixedParts(points, all, work_).handles) {
      for (std::uint32_t i : handle) known_[k].push_back(points.points[i]);
    }
  }

  bool IsHandleOf(const ObjectHypothesis& part, std::size_t k) {
    if (!is_searched_[k]) SearchVessel(k);
    return vessels_[k] && !Stands(state_.measured(), part.points, At(k).resting.support) &&
           vessels_[k]->HasHandle(SampleOf(part).Points(), known_[k]);
  }

  void AttachPartsOf(std::size_t from, std::size_t k) {
    const PointSample sample = SampleOf(At(from));
    const OrientedPoints points = sample.Points();
    std::vector<Vessel::Cluster> handles = vessels_[k]->FindHandlesIn(points, work_);
    std::vector<char> rest(points.size(), 1);
    for (const Vessel::Cluster& handle : handles) {
      for (std::uint32_t i : handle) rest[i] = 0;
    }
    // The rest of its points is on the wall too.
    const bool is_of_vessel = vessels_[k]->ShareOnWalls(points, rest) >= kMainShare;
    std::erase_if(handles, [&](const Vessel::Cluster& handle) {
      return !is_of_vessel && IsPartOfOwnWall(points, handle, from, *vessels_[k]);
    });
    std::vector<std::int32_t> part(points.size(), -1);
    for (const Vessel::Cluster& handle : handles) {
      for (std::uint32_t i : handle) part[i] = 0;
    }
    PointSet part_points;
    const std::vector<std::int32_t> of_all = sample.PartsOfAllPoints(part, work_);
    for (std::size_t i = 0; i < of_all.size(); ++i) {
      if (of_all[i] == 0) part_points.push_back(At(from).points[i]);
    }
    const double max_points = kMajority * static_cast<double>(At(k).points.size());
    if (part_points.empty() || static_cast<double>(part_points.size()) > max_points ||
        HasPartTransfer(from) || Stands(state_.measured(), part_points, At(k).resting.support)) {
      return;
    }
    if (is_of_vessel || part_points.size() == At(from).points.size()) {
      transferred_to_[from] = k;
      bounds_[k].extend(bounds_[from]);
    } else {
      part_transfers_.push_back({from, k, std::move(part_points)});
    }
  }

  // A hypothesis gives a part only once: the part refers to its points as they were.
  bool HasPartTransfer(std::size_t from) const {
    return std::any_of(part_transfers_.begin(), part_transfers_.end(),
                       [&](const PartTransfer& part) { return part.from == from; });
  }

  // True if a cluster of an object's points is nearer to that object's own wall than to the wall of
  // `vessel`.
  bool IsPartOfOwnWall(const OrientedPoints& points, const Vessel::Cluster& cluster, std::size_t k,
                       const Vessel& vessel) {
    if (!is_searched_[k]) SearchVessel(k);
    return vessels_[k] && vessels_[k]->Gap_m(points, cluster) < vessel.Gap_m(points, cluster);
  }

  const SceneState& state_;
  const Work& work_;
  std::vector<Eigen::AlignedBox3f> bounds_;
  std::vector<std::optional<Vessel>> vessels_;       // of the objects searched so far
  std::vector<std::vector<Eigen::Vector3f>> known_;  // points of their handles
  std::vector<char> is_searched_;
  std::vector<std::size_t> transferred_to_;
  std::vector<PartTransfer> part_transfers_;
  std::size_t point_budget_;
  bool all_searched_ = true;
};

}  // namespace

FoundHandles FindCutOffHandles(const SceneState& state, const Work& work) {
  HandleAttacher attacher(state, work);
  attacher.SearchTouchedVessels();
  for (int round = 0; round < kMaxTransferRounds && attacher.AttachRound();) ++round;
  attacher.AttachParts();
  return attacher.Result();
}

}  // namespace cwm::perception
