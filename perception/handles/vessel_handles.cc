#include "perception/handles/vessel_handles.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "perception/cloud/quantile.h"
#include "perception/cloud/seen_width.h"
#include "perception/cloud/slenderness.h"
#include "perception/cloud/tolerances.h"
#include "perception/search/connectivity.h"
#include "perception/search/model_points.h"

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

// chosen: distance from the wall. A handle's end that is nearer counts as an end at the wall
// without its root; a handle that reaches no farther leaves no room for a finger and its own
// thickness.
constexpr double kWallRoot_m = 0.02;
// chosen: the largest BendOf_m of a straight bar.
constexpr double kMaxBend_m = 0.0235;
// chosen: the least ratio of a bar's length to its seen width: for a hand, 110 mm to 18 mm.
constexpr double kMinBarElongation = 4.7;
// chosen: points this near to a wide part are removed with it: corners of a box, and the noise at
// its edges.
constexpr double kBesideWide_m = 0.01;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
// chosen: the largest SeenWidth_m of a spout, for spouts 36 mm wide at the root.
constexpr double kMaxSpoutWidth_m = 0.045;
// chosen: the share of a spout's points, the highest ones, that form its tip.
constexpr double kTip = 0.05;
// chosen: the share of a whole handle's points that stand out; the rest are its roots.
constexpr double kMinProtrudingShare = 0.6;

// The extent of the points along the axis of their second largest extent, without the noise on
// either side: the width of a straight bar, or how far a bent one leaves its chord.
double BendOf_m(const std::vector<Eigen::Vector3f>& points) {
  Vector3 mean = Vector3::Zero();
  for (const Eigen::Vector3f& p : points) mean += p.cast<double>();
  mean /= static_cast<double>(points.size());
  Matrix3 covariance = Matrix3::Zero();
  for (const Eigen::Vector3f& p : points) {
    const Vector3 x = p.cast<double>() - mean;
    covariance += x * x.transpose();
  }
  const Vector3 second = Eigen::SelfAdjointEigenSolver<Matrix3>(covariance).eigenvectors().col(1);
  std::vector<double> along;
  for (const Eigen::Vector3f& p : points) along.push_back(second.dot(p.cast<double>()));
  return (Quantile(along, kNearlyAll) - Quantile(along, 1 - kNearlyAll)) / (2 * kNearlyAll - 1);
}

std::vector<Vector3f> PlacesOf(const OrientedPoints& points,
                               const std::vector<std::uint32_t>& members) {
  std::vector<Vector3f> places;
  for (std::uint32_t i : members) places.push_back(points.points[i]);
  return places;
}

// The distance between the nearest points of both sets, exact to a spacing or two because large
// sets are thinned.
double GapBetween_m(const std::vector<Vector3f>& a, const std::vector<Vector3f>& b) {
  float nearest_m2 = std::numeric_limits<float>::infinity();
  for (std::size_t i = 0; i < a.size(); i += 1 + a.size() / kMaxComparedPoints) {
    for (std::size_t k = 0; k < b.size(); k += 1 + b.size() / kMaxComparedPoints) {
      nearest_m2 = std::min(nearest_m2, (a[i] - b[k]).squaredNorm());
    }
  }
  return std::sqrt(nearest_m2);
}

}  // namespace

Vessel::Vessel(const OrientedPoints& object, std::vector<RevolvedWall> walls)
    : walls_(std::move(walls)), pitch_m_(SeenPitch_m(object.points, object.viewpoint)) {}

std::optional<Vessel> Vessel::Find(const OrientedPoints& object, const Work& work) {
  std::vector<RevolvedWall> walls = FitRevolvedWalls(object, work);
  if (walls.empty()) return std::nullopt;
  return Vessel(object, std::move(walls));
}

double Vessel::Protrusion_m(const Eigen::Vector3f& p) const {
  double out_m = std::numeric_limits<double>::infinity();
  for (const RevolvedWall& wall : walls_) {
    out_m = std::min(out_m, wall.Protrusion_m(p.cast<double>()));
  }
  return out_m;
}

Vessel::Cluster Vessel::ProtrudingPoints(const OrientedPoints& points,
                                         const std::vector<char>& among) const {
  Cluster out;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (!among[i] || !points.points[i].allFinite()) continue;
    const double out_m = Protrusion_m(points.points[i]);
    const bool near = out_m <= kMaxHandleLength_m + kMaxTouchingGap_m;
    if (near && out_m > kDistanceGate_sigma * double{points.sigma_m[i]}) out.push_back(i);
  }
  return out;
}

bool Vessel::IsHandle(const OrientedPoints& points, const Cluster& cluster, double gap_m) const {
  const std::vector<Vector3f> members = PlacesOf(points, cluster);
  double farthest_m = 0;
  Eigen::AlignedBox3f bounds;
  for (const Vector3f& p : members) {
    const double out_m = Protrusion_m(p);
    gap_m = std::min(gap_m, out_m);
    farthest_m = std::max(farthest_m, out_m);
    bounds.extend(p);
  }
  if (gap_m > kMaxTouchingGap_m || farthest_m < kWallRoot_m ||
      bounds.sizes().maxCoeff() > kMaxHandleLength_m) {  // its length is at least that
    return false;
  }
  const Slenderness bar = MeasureSlenderness(members, points.viewpoint, pitch_m_);
  if (bar.length_m < std::max(kMinHandleLength_m, kMinElongation * bar.width_m) ||
      bar.length_m > kMaxHandleLength_m || bar.width_m > kMaxHandleWidth_m) {
    return false;
  }
  if (HasSpoutTip(members)) return false;
  const double width_m = SeenWidth_m(members, points.viewpoint);
  if (farthest_m > kMaxBowReach_m) {
    return width_m <= kMaxSeenHandleWidth_m && bar.length_m >= kMinBarElongation * width_m &&
           BendOf_m(members) <= kMaxBend_m;
  }
  const bool returns = Protrusion_m(bar.ends[0].cast<float>()) <= kWallRoot_m &&
                       Protrusion_m(bar.ends[1].cast<float>()) <= kWallRoot_m;
  return width_m <= (returns ? kMaxSeenHandleWidth_m : kMaxHandleWidth_m);
}

// True if the cluster rises nearly as high as the vessel and ends there freely, at half of its
// reach or beyond. A vessel would overflow through a lower spout; bows end at the wall. A spout
// also rises by at least half of its reach, 27 degrees; bars rise by less.
bool Vessel::HasSpoutTip(const std::vector<Vector3f>& members) const {
  const auto nearest_m = [&](const RevolvedWall& wall) {
    double out_m = kInfinity;
    for (const Vector3f& p : members) out_m = std::min(out_m, wall.Protrusion_m(p.cast<double>()));
    return out_m;
  };
  const RevolvedWall& wall = *std::ranges::min_element(walls_, {}, nearest_m);
  std::vector<double> heights_m, out_m;
  for (const Vector3f& p : members) {
    heights_m.push_back(wall.R_LW.col(2).dot(p.cast<double>()));
    out_m.push_back(wall.Protrusion_m(p.cast<double>()));
  }
  const double full_m = std::lerp(wall.low_z_m, wall.high_z_m, kNearlyAll);
  if (Quantile(heights_m, 1 - kMixedPixels) < full_m) return false;
  const double tip_m = Quantile(heights_m, 1 - kTip);
  double of_tip_m = 0, count = 0;
  for (std::size_t k = 0; k < members.size(); ++k) {
    if (heights_m[k] < tip_m) continue;
    of_tip_m += out_m[k];
    ++count;
  }
  const double farthest_m = Quantile(out_m, 1 - kMixedPixels),
               nearest = Quantile(out_m, kMixedPixels);
  return of_tip_m > std::max(kWallRoot_m, farthest_m / 2) * count &&
         2 * (tip_m - Quantile(heights_m, kMixedPixels)) > farthest_m - nearest;
}

bool Vessel::IsSpout(const OrientedPoints& points, const Cluster& cluster) const {
  const std::vector<Vector3f> members = PlacesOf(points, cluster);
  return HasSpoutTip(members) && SeenWidth_m(members, points.viewpoint) <= kMaxSpoutWidth_m;
}

double Vessel::Gap_m(const OrientedPoints& points, const Cluster& cluster) const {
  double gap_m = kInfinity;
  for (std::uint32_t i : cluster) gap_m = std::min(gap_m, Protrusion_m(points.points[i]));
  return std::max(gap_m, 0.0);
}

// True if the cluster begins at the wall. After a wide part was removed, the tip of a spout does
// not.
bool Vessel::BeginsAtWall(const OrientedPoints& points, const Cluster& cluster) const {
  return Gap_m(points, cluster) <= kWallRoot_m;
}

// True if the part is slim, near the handle, and in line with it or within its bow.
bool Vessel::Continues(const std::vector<Vector3f>& handle, const std::vector<Vector3f>& part,
                       const Vector3& viewpoint) const {
  if (GapBetween_m(handle, part) > kMaxTouchingGap_m) return false;
  std::vector<Vector3f> both = handle;
  both.insert(both.end(), part.begin(), part.end());
  double farthest_m = 0;
  for (const Vector3f& p : both) farthest_m = std::max(farthest_m, Protrusion_m(p));
  if (farthest_m > kMaxBowReach_m && BendOf_m(both) > kMaxBend_m) return false;
  return SeenWidth_m(part, viewpoint) <= kMaxHandleWidth_m;
}

Vessel::FixedParts Vessel::FindFixedParts(const OrientedPoints& object,
                                          const std::vector<char>& among, const Work& work) const {
  FixedParts found;
  std::vector<Cluster>& handles = found.handles;
  std::vector<Cluster> parts;
  const Cluster out = ProtrudingPoints(object, among);
  if (out.size() < kMinHandlePoints) return found;
  Cluster all(out.size());
  std::iota(all.begin(), all.end(), 0u);
  const Connectivity connectivity(
      PlacesOf(object, out),
      static_cast<float>(std::max(kNoiseReach_m, kSpacingsPerCell * pitch_m_)));
  const auto in_object = [&](Cluster cluster) {
    for (std::uint32_t& k : cluster) k = out[k];
    return cluster;
  };
  const auto is_handle = [&](const Cluster& cluster) {
    return cluster.size() >= kMinHandlePoints && IsHandle(object, cluster, kInfinity);
  };
  for (const Cluster& cluster : connectivity.Components(all)) {
    work.Poll();
    if (cluster.size() < kOneSample) break;  // largest first
    if (Cluster members = in_object(cluster); is_handle(members)) {
      handles.push_back(std::move(members));
      continue;
    }
    if (Cluster members = in_object(cluster); IsSpout(object, members)) {
      found.spouts.push_back(std::move(members));
      continue;
    }
    // A wider cluster may be a box that touches a handle.
    const std::vector<char> wide =
        MarkWideParts(PlacesOf(object, in_object(cluster)), object.viewpoint, kMaxSeenHandleWidth_m,
                      kBesideWide_m);
    Cluster slim, removed;
    for (std::size_t k = 0; k < cluster.size(); ++k) {
      (wide[k] ? removed : slim).push_back(cluster[k]);
    }
    std::vector<char> beside(out.size(), 0);
    for (std::uint32_t k : connectivity.Beside(removed)) beside[k] = 1;
    for (const Cluster& rest : connectivity.Components(slim)) {
      if (rest.size() < kOneSample) break;
      // A handle touches a box at one end, but the edge of a box touches it along its whole length.
      const auto touching =
          std::count_if(rest.begin(), rest.end(), [&](std::uint32_t k) { return beside[k] != 0; });
      const bool is_edge =
          static_cast<double>(touching) > kMainShare * static_cast<double>(rest.size());
      Cluster members = in_object(rest);
      const bool whole = !is_edge && is_handle(members) && BeginsAtWall(object, members);
      (whole ? handles : parts).push_back(std::move(members));
    }
  }
  // Spouts partly occlude their own root, which then looks like a handle beside them.
  std::erase_if(handles, [&](const Cluster& handle) {
    return std::ranges::any_of(found.spouts, [&](const Cluster& spout) {
      return GapBetween_m(PlacesOf(object, spout), PlacesOf(object, handle)) <= kMaxTouchingGap_m;
    });
  });
  MergeParts(object, std::move(parts), handles);
  return found;
}

void Vessel::MergeHandles(const OrientedPoints& object, std::vector<Cluster>& handles) const {
  MergeParts(object, {}, handles);
}

// Merges handles that were measured in parts.
void Vessel::MergeParts(const OrientedPoints& object, std::vector<Cluster> parts,
                        std::vector<Cluster>& handles) const {
  const auto continues = [&](const Cluster& handle, const Cluster& part) {
    return Continues(PlacesOf(object, handle), PlacesOf(object, part), object.viewpoint);
  };
  const auto take = [](Cluster& handle, const Cluster& part) {
    handle.insert(handle.end(), part.begin(), part.end());
    std::sort(handle.begin(), handle.end());
  };
  for (std::size_t h = 0; h < handles.size(); ++h) {
    for (std::size_t other = handles.size(); other-- > h + 1;) {
      if (!continues(handles[h], handles[other])) continue;
      take(handles[h], handles[other]);
      handles.erase(handles.begin() + static_cast<std::ptrdiff_t>(other));
    }
    std::erase_if(parts, [&](const Cluster& part) {
      const double min_points = kMinSignificantShare * static_cast<double>(handles[h].size());
      if (static_cast<double>(part.size()) < min_points || !continues(handles[h], part))
        return false;
      take(handles[h], part);
      return true;
    });
  }
}

std::vector<Vessel::Cluster> Vessel::FindHandlesIn(const OrientedPoints& other,
                                                   const Work& work) const {
  const std::vector<char> all(other.size(), 1);
  if (!BeginsAtWall(other, ProtrudingPoints(other, all))) return {};
  std::vector<Cluster> handles = FindFixedParts(other, all, work).handles;
  std::erase_if(handles, [&](const Cluster& handle) { return !BeginsAtWall(other, handle); });
  return handles;
}

double Vessel::ShareOnWalls(const OrientedPoints& other, const std::vector<char>& among) const {
  double on = 0, all = 0;
  for (std::size_t i = 0; i < other.size(); ++i) {
    if (!among[i] || !other.points[i].allFinite()) continue;
    const double gate_m = kDistanceGate_sigma * double{other.sigma_m[i]};
    const double out_m = Protrusion_m(other.points[i]);
    on += out_m <= gate_m && out_m >= -gate_m - kWallThickness_m;
    all += 1;
  }
  return all > 0 ? on / all : 1;
}

bool Vessel::HasHandle(const OrientedPoints& other, const std::vector<Vector3f>& known) const {
  const Cluster out = ProtrudingPoints(other, std::vector<char>(other.size(), 1));
  return out.size() >= kMinHandlePoints &&
         static_cast<double>(out.size()) >=
             kMinProtrudingShare * static_cast<double>(other.size()) &&
         IsHandle(other, out, GapBetween_m(known, other.points));
}

}  // namespace cwm::perception
