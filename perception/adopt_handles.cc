#include "perception/adopt_handles.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "perception/cloud/parallel_for.h"
#include "perception/cloud/quantile.h"
#include "perception/give_things.h"
#include "perception/model/model_points.h"
#include "perception/model/vessel_handles.h"
#include "perception/thing_sample.h"

namespace cwm::perception {
namespace {

// What ends within this of the support stands on it, as a pen does: the band above a support that
// is given to it, and a little of what noise leaves.
constexpr double kStanding_sigma = 4;
constexpr float kLowest = 0.05f;    // quantile of heights: what stands has its foot there
constexpr int kMostRounds = 4;      // a handle in as many parts, each beyond the one before
constexpr double kMostShare = 0.5;  // of the vessel's points, that its handle may have
// Of what a thing keeps beside the handle, on the vessel's wall: then it is a part of the vessel.
constexpr double kOnWall = 0.8;

// Points that may be looked at for handles of other things, in those of the scene: kitchens with their
// walls ask for five, a thousand balls that touch for fifty.
constexpr std::size_t kMostLooks = 10;

using Points = std::vector<std::uint32_t>;

Eigen::AlignedBox3f BoundsOf(const OrientedPoints& points, const Points& members) {
  Eigen::AlignedBox3f bounds;
  for (std::uint32_t i : members) bounds.extend(points.points[i]);
  return bounds;
}

// On the support that the vessel stands on, if it is known.
bool Stands(const SegmentedScene& scene, const Points& members, std::int32_t support) {
  if (support < 0) return false;
  const Pose X_SL =
      scene.supports[static_cast<std::size_t>(support)].plate.X_FS.inverse(Eigen::Isometry);
  std::vector<double> heights_m;
  double sigma_m = 0;
  for (std::uint32_t i : members) {
    heights_m.push_back((X_SL * scene.points.points[i].cast<double>()).z());
    sigma_m = std::max(sigma_m, double{scene.points.sigma_m[i]});
  }
  return Quantile(std::move(heights_m), kLowest) <= kStanding_sigma * sigma_m;
}

// Points of a thing, by their places in its list, and the thing that they are given to.
struct GivenPart {
  std::size_t from = 0, to = 0;
  Points places;
};

class Adoption {
 public:
  Adoption(const SegmentedScene& scene, const Work& work)
      : scene_(scene),
        work_(work),
        vessels_(scene.things.size()),
        known_(scene.things.size()),
        asked_(scene.things.size(), 0),
        given_to_(scene.things.size()),
        looks_left_(kMostLooks * scene.points.size()) {
    std::iota(given_to_.begin(), given_to_.end(), std::size_t{0});
    for (const SegmentedThing& thing : scene.things) {
      bounds_.push_back(BoundsOf(scene.points, thing.points));
    }
  }

  // Of all things that others touch at once, since each takes long: those will be asked for.
  void AskAhead() {
    std::vector<std::size_t> touched;
    for (std::size_t k = 0; k < scene_.things.size(); ++k) {
      work_.Poll();
      if (IsTouched(k)) touched.push_back(k);
    }
    ParallelFor(touched.size(), 1, work_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t n = begin; n < end; ++n) Ask(touched[n]);
    });
  }

  // One round over all things; true when something was given. What was given may reach out to more.
  bool Give() {
    bool any = false;
    for (std::size_t part = 0; part < given_to_.size(); ++part) {
      work_.Poll();
      if (given_to_[part] != part || !IsLarge(part)) continue;
      const std::size_t vessel = VesselOf(part);
      if (vessel == part) continue;
      Know(ThingSample(scene_, scene_.things[part]).Points().points, vessel);
      bounds_[vessel].extend(bounds_[part]);
      given_to_[part] = vessel;
      any = true;
    }
    return any;
  }

  // Of things that stay: what of their points is a handle of another one's wall, which they touch.
  void GiveParts() {
    for (std::size_t k = 0; k < given_to_.size(); ++k) {
      if (given_to_[k] != k) continue;
      for (std::size_t from = 0; from < given_to_.size(); ++from) {
        work_.Poll();
        if (from == k || given_to_[from] != from || !IsLarge(from) ||
            bounds_[from].exteriorDistance(bounds_[k]) > kMostHandleGap_m) {
          continue;
        }
        if (!asked_[k]) Ask(k);
        if (!vessels_[k]) break;
        if (scene_.things[from].points.size() > looks_left_) {
          all_looked_at_ = false;
          return;
        }
        looks_left_ -= scene_.things[from].points.size();
        GivePartsOf(from, k);
      }
    }
  }

  // Per thing the one that it is given to: itself where none.
  const std::vector<std::size_t>& given_to() const { return given_to_; }
  bool all_looked_at() const { return all_looked_at_; }
  // Places in their lists of the points of things that go to another one without the rest.
  const std::vector<GivenPart>& given_parts() const { return given_parts_; }

 private:
  bool IsLarge(std::size_t k) const { return scene_.things[k].points.size() >= kLeastHandlePoints; }

  bool IsTouched(std::size_t k) const {
    for (std::size_t other = 0; other < scene_.things.size(); ++other) {
      if (other != k && IsLarge(other) &&
          bounds_[other].exteriorDistance(bounds_[k]) <= kMostHandleGap_m) {
        return true;
      }
    }
    return false;
  }

  std::size_t VesselOf(std::size_t part) {
    const SegmentedThing& thing = scene_.things[part];
    const double most = static_cast<double>(thing.points.size()) / kMostShare;
    for (std::size_t k = 0; k < scene_.things.size(); ++k) {
      const SegmentedThing& vessel = scene_.things[k];
      if (k == part || given_to_[k] != k) continue;
      if (static_cast<double>(vessel.points.size()) < most) continue;
      if (bounds_[part].exteriorDistance(bounds_[k]) > kMostHandleGap_m) continue;
      if (IsHandleOf(thing, k)) return k;
    }
    return part;
  }

  void Know(const std::vector<Eigen::Vector3f>& points, std::size_t vessel) {
    known_[vessel].insert(known_[vessel].end(), points.begin(), points.end());
  }

  void Ask(std::size_t k) {
    asked_[k] = 1;
    const OrientedPoints points = ThingSample(scene_, scene_.things[k]).Points();
    vessels_[k] = Vessel::Find(points, work_);
    if (!vessels_[k]) return;
    const std::vector<char> all(points.size(), 1);
    for (const Vessel::Cluster& handle : vessels_[k]->FindFixed(points, all, work_).handles) {
      for (std::uint32_t i : handle) known_[k].push_back(points.points[i]);
    }
  }

  bool IsHandleOf(const SegmentedThing& part, std::size_t k) {
    if (!asked_[k]) Ask(k);
    return vessels_[k] && !Stands(scene_, part.points, scene_.things[k].supported_by) &&
           vessels_[k]->HasHandle(ThingSample(scene_, part).Points(), known_[k]);
  }

  void GivePartsOf(std::size_t from, std::size_t k) {
    const ThingSample sample(scene_, scene_.things[from]);
    const OrientedPoints points = sample.Points();
    std::vector<Vessel::Cluster> handles = vessels_[k]->FindHandlesIn(points, work_);
    std::vector<char> rest(points.size(), 1);
    for (const Vessel::Cluster& handle : handles) {
      for (std::uint32_t i : handle) rest[i] = 0;
    }
    const bool is_of_vessel = vessels_[k]->ShareOnWalls(points, rest) >= kOnWall;
    std::erase_if(handles, [&](const Vessel::Cluster& handle) {
      return !is_of_vessel && IsItsOwn(points, handle, from, *vessels_[k]);
    });
    std::vector<std::int32_t> part(points.size(), -1);
    for (const Vessel::Cluster& handle : handles) {
      for (std::uint32_t i : handle) part[i] = 0;
    }
    Points places;
    const std::vector<std::int32_t> of_all = sample.OfAll(part, work_);
    for (std::uint32_t i = 0; i < of_all.size(); ++i) {
      if (of_all[i] == 0) places.push_back(i);
    }
    const double most = kMostShare * static_cast<double>(scene_.things[k].points.size());
    if (places.empty() || static_cast<double>(places.size()) > most || HasGivenPart(from) ||
        Stands(scene_, PointsAt(from, places), scene_.things[k].supported_by)) {
      return;
    }
    if (is_of_vessel) {
      given_to_[from] = k;
      bounds_[k].extend(bounds_[from]);
    } else {
      given_parts_.push_back({from, k, std::move(places)});
    }
  }

  // A thing gives once: its places are those of its list as it was.
  bool HasGivenPart(std::size_t from) const {
    return std::any_of(given_parts_.begin(), given_parts_.end(),
                       [&](const GivenPart& part) { return part.from == from; });
  }

  Points PointsAt(std::size_t k, const Points& places) const {
    Points points;
    for (std::uint32_t i : places) points.push_back(scene_.things[k].points[i]);
    return points;
  }

  // Whether a cluster of a thing's points stands out from that thing's own wall rather than from
  // the wall of `vessel`.
  bool IsItsOwn(const OrientedPoints& points, const Vessel::Cluster& cluster, std::size_t k,
                const Vessel& vessel) {
    if (!asked_[k]) Ask(k);
    return vessels_[k] && vessels_[k]->Gap_m(points, cluster) < vessel.Gap_m(points, cluster);
  }

  const SegmentedScene& scene_;
  const Work& work_;
  std::vector<Eigen::AlignedBox3f> bounds_;
  std::vector<std::optional<Vessel>> vessels_;       // of the things that were asked for
  std::vector<std::vector<Eigen::Vector3f>> known_;  // points of their handles
  std::vector<char> asked_;
  std::vector<std::size_t> given_to_;
  std::vector<GivenPart> given_parts_;
  std::size_t looks_left_;
  bool all_looked_at_ = true;
};

void MovePart(const GivenPart& part, std::vector<SegmentedThing>& things) {
  SegmentedThing &from = things[part.from], &to = things[part.to];
  const double share =
      static_cast<double>(part.places.size()) / static_cast<double>(from.points.size());
  const auto nodes = static_cast<std::size_t>(share * static_cast<double>(from.node_count));
  from.node_count -= nodes;
  to.node_count += nodes;
  Points kept;
  auto next = part.places.begin();
  for (std::uint32_t i = 0; i < from.points.size(); ++i) {
    const bool moves = next != part.places.end() && *next == i;
    if (moves) ++next;
    (moves ? to.points : kept).push_back(from.points[i]);
  }
  from.points = std::move(kept);
}

}  // namespace

bool AdoptHandles(SegmentedScene& scene, const Work& work) {
  Adoption adoption(scene, work);
  adoption.AskAhead();
  for (int round = 0; round < kMostRounds && adoption.Give();) ++round;
  adoption.GiveParts();
  for (const GivenPart& part : adoption.given_parts()) MovePart(part, scene.things);
  GiveThings(adoption.given_to(), scene.things);
  return adoption.all_looked_at();
}

}  // namespace cwm::perception
