#include "perception/refinement/attach/attach_spouts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "perception/cloud/quantile.h"
#include "perception/cloud/tolerances.h"
#include "perception/handles/vessel_handles.h"
#include "perception/hypotheses/point_sample.h"
#include "perception/refinement/evidence.h"
#include "perception/segmentation/surface_graph.h"

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

// chosen: the share of lowest points of an object below which places are tested.
constexpr double kLowestShare = 0.1;
// chosen: the largest gap between a spout's points and the wall, or a part attached to it: the
// length of a spout whose root is hidden. Nothing floats.
constexpr double kMaxSpoutGap_m = 0.06;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

class SpoutAttacher {
 public:
  SpoutAttacher(const SceneState& state, const Work& work)
      : state_(state),
        work_(work),
        places_(state.hypotheses().size()),
        vessels_(state.hypotheses().size()),
        is_searched_(state.hypotheses().size(), 0),
        transferred_to_(state.hypotheses().size()) {
    std::iota(transferred_to_.begin(), transferred_to_.end(), std::size_t{0});
    for (const HypothesisPtr& hypothesis : state.hypotheses()) {
      Eigen::AlignedBox3f& bounds = bounds_.emplace_back();
      for (std::uint32_t i : hypothesis->points) bounds.extend(state.points().points[i]);
    }
  }

  // One round over all objects; true if any part was given. More parts may be attached to it in the
  // next round.
  bool AttachRound() {
    bool any = false;
    for (std::size_t part = 0; part < transferred_to_.size(); ++part) {
      work_.Poll();
      if (transferred_to_[part] != part) continue;
      const std::size_t vessel = VesselOf(part);
      if (vessel == part) continue;
      transferred_to_[part] = vessel;
      bounds_[vessel].extend(bounds_[part]);
      const std::vector<Vector3f>& places = PlacesOf(part);
      places_[vessel].insert(places_[vessel].end(), places.begin(), places.end());
      any = true;
    }
    return any;
  }

  std::vector<PointTransfer> Transfers() const {
    std::vector<PointTransfer> transfers;
    for (std::size_t k = 0; k < transferred_to_.size(); ++k) {
      if (transferred_to_[k] != k) transfers.push_back({At(k).id, At(transferred_to_[k]).id, {}});
    }
    return transfers;
  }

 private:
  const ObjectHypothesis& At(std::size_t k) const { return *state_.hypotheses()[k]; }
  PointSample SampleOf(std::size_t k) const {
    return {state_.points(), At(k).points, At(k).node_count};
  }

  // The nearest vessel that the part is a spout of; the part itself if there is none.
  std::size_t VesselOf(std::size_t part) {
    const ObjectHypothesis& hypothesis = At(part);
    if (!hypothesis.plates.empty() || hypothesis.points.size() < kMinHandlePoints) return part;
    std::size_t vessel = part;
    double nearest_m = kMaxSpoutGap_m;
    for (std::size_t k = 0; k < transferred_to_.size(); ++k) {
      const std::int32_t support = At(k).resting.support;
      if (k == part || transferred_to_[k] != k || support < 0) continue;
      const auto max_points = kMajority * static_cast<double>(At(k).points.size());
      if (static_cast<double>(hypothesis.points.size()) > max_points || RestsOnAnother(part, k) ||
          bounds_[part].exteriorDistance(bounds_[k]) > kMaxSpoutGap_m ||
          !Hangs(hypothesis, static_cast<std::size_t>(support))) {
        continue;
      }
      if (const double gap_m = GapToWall_m(part, k); gap_m <= nearest_m) {
        nearest_m = gap_m;
        vessel = k;
      }
    }
    return vessel;
  }

  bool RestsOnAnother(std::size_t part, std::size_t vessel) const {
    const std::optional<HypothesisId>& below = At(part).resting.on;
    return below && transferred_to_[state_.IndexOf(*below)] != vessel;
  }

  // True if the space below the object, at three heights, is seen to be empty. measured: below
  // simulated spouts 0.67 and more of the places are empty, below objects behind a vessel or in its
  // shadow 0.01 and less.
  bool Hangs(const ObjectHypothesis& hypothesis, std::size_t support) const {
    const Pose& X_LS = state_.measured().supports[support].plate.X_FS;
    const Pose X_SL = X_LS.inverse(Eigen::Isometry);
    std::vector<std::pair<double, std::uint32_t>> heights_m;
    for (std::uint32_t i : hypothesis.points) {
      heights_m.emplace_back((X_SL * state_.points().points[i].cast<double>()).z(), i);
    }
    std::ranges::sort(heights_m);
    const std::size_t lowest =
        static_cast<std::size_t>(kLowestShare * double(heights_m.size())) + 1;
    std::size_t tested = 0, empty = 0;
    for (std::size_t k = 0; k < lowest; k += lowest / kMaxTestedPoints + 1, ++tested) {
      const double height_m = heights_m[k].first;
      const std::uint32_t i = heights_m[k].second;
      empty +=
          std::ranges::any_of(std::initializer_list<double>{0.25, 0.5, 0.75}, [&](double share) {
            Vector3 below = X_SL * state_.points().points[i].cast<double>();
            below.z() = share * height_m;
            return state_.sight()->VisibilityAt((X_LS * below).cast<float>(),
                                                MaxJump_m(state_.points().sigma_m[i])) ==
                   Visibility::kSeenThrough;
          });
    }
    return 2 * empty >= tested;
  }

  // The distance to the outside of the wall, or to a part attached to it; infinite if the part is
  // not a spout of it.
  double GapToWall_m(std::size_t part, std::size_t k) {
    if (!std::exchange(is_searched_[k], 1)) {
      vessels_[k] = Vessel::Find(SampleOf(k).Points(), work_);
    }
    if (!vessels_[k]) return kInfinity;
    const OrientedPoints points = SampleOf(part).Points();
    const std::vector<char> all(points.size(), 1);
    const Vessel::Cluster outside = vessels_[k]->ProtrudingPoints(points, all);
    // Contents of a vessel are not part of it, and neither are objects on its rim, such as lids and
    // ladles.
    if (static_cast<double>(outside.size()) < kMainShare * static_cast<double>(points.size())) {
      return kInfinity;
    }
    std::vector<float> heights_m;
    for (const Vector3f& p : points.points) heights_m.push_back(p.z());
    const double foot_m = Quantile(std::move(heights_m), kFootQuantile);
    const auto is_below_rim = [&](const RevolvedWall& wall) {
      return foot_m < wall.high_z_m - kVesselRim_m;
    };
    if (!std::ranges::any_of(vessels_[k]->walls(), is_below_rim)) return kInfinity;
    return std::min(vessels_[k]->Gap_m(points, outside), Gap_m(part, k));
  }

  const std::vector<Vector3f>& PlacesOf(std::size_t k) {
    if (places_[k].empty()) places_[k] = SampleOf(k).Points().points;
    return places_[k];
  }

  // The distance of the nearest two points of both; if there are many, only a part of them is
  // tested.
  double Gap_m(std::size_t part, std::size_t k) {
    const Vector3f reach = Vector3f::Constant(float{kMaxSpoutGap_m});
    const Eigen::AlignedBox3f around(bounds_[part].min() - reach, bounds_[part].max() + reach);
    std::vector<Vector3f> near;
    for (const Vector3f& p : PlacesOf(k)) {
      if (around.contains(p)) near.push_back(p);
    }
    const std::vector<Vector3f>& places = PlacesOf(part);
    float nearest_m2 = std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < places.size(); i += 1 + places.size() / kMaxComparedPoints) {
      for (std::size_t j = 0; j < near.size(); j += 1 + near.size() / kMaxComparedPoints) {
        nearest_m2 = std::min(nearest_m2, (places[i] - near[j]).squaredNorm());
      }
    }
    return std::sqrt(nearest_m2);
  }

  const SceneState& state_;
  const Work& work_;
  std::vector<Eigen::AlignedBox3f> bounds_;
  std::vector<std::vector<Vector3f>> places_;   // of the objects searched so far
  std::vector<std::optional<Vessel>> vessels_;  // likewise
  std::vector<char> is_searched_;
  std::vector<std::size_t> transferred_to_;
};

}  // namespace

std::vector<PointTransfer> FindSpouts(const SceneState& state, const Work& work) {
  if (!state.sight()) return {};
  SpoutAttacher attacher(state, work);
  for (int round = 0; round < kMaxTransferRounds && attacher.AttachRound();) ++round;
  return attacher.Transfers();
}

}  // namespace cwm::perception
