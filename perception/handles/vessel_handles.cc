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
#include "perception/search/connectivity.h"
#include "perception/search/model_points.h"

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

// Assumed, not measured on a data set: the sizes of the handles of cups, mugs, pans and jugs for
// the table, 5 to 15 mm thick, bars of pans up to 25, and somewhat wider, with room for fingers.
constexpr double kLeastLength_m = 0.02;  // of what is seen of it
constexpr double kMostLength_m = 0.25;
constexpr double kLeastElongation = 2;   // length to mean width
constexpr double kLeastReach_m = 0.022;  // from the wall: a finger and the handle's own thickness
// As SeenWidth_m has it, of strips 18 mm wide with ragged edges. A bow that returns to its wall is
// none of the spouts, which are as wide where they begin and end free: it may be wider at a bend.
constexpr double kMostWidth_m = 0.030;
constexpr double kMostWidthOfBow_m = 0.034;
constexpr double kMostWidthOfBar_m = 0.0345;
// A hand within a bow, and the bow: what reaches out farther is a bar, which is straight.
constexpr double kMostReachOfBow_m = 0.065;
constexpr double kMostBend_m = 0.0235;
constexpr double kLeastBarElongation = 4.7;  // to the seen width: for a hand, 110 mm to 18 mm
constexpr double kBesideWide_m = 0.01;       // corners of a box, and the noise at its edges
constexpr double kTail = 0.1;                // on either side, noise among it
constexpr double kReturned_m = 0.02;         // from the wall: an end without its root
constexpr double kLeastCell_m = 0.006;       // 4 sigma of a Kinect at 0.8 m: noise parts no handle
constexpr double kCellPitches = 3;           // as in Connectivity
constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Of what is left beside something wide, near that: a handle touches a box at one end, the edge of a
// box all along.
constexpr double kMostTouching = 0.75;
constexpr std::size_t kLeastPartPoints = 12;  // one independent sample
constexpr double kLeastPartShare = 0.2;       // of the handle; less may be noise at its edge
constexpr std::size_t kMostForGap = 500;      // within a spacing or two of the gap
// Of the height of the wall, to which a vessel is filled: a spout that ended lower would let it run over.
// It rises by so much of what it reaches out at least, 27 degrees; bars rise by less.
constexpr double kFull = 0.9;
constexpr double kLeastRise = 0.5;
constexpr double kMostSpoutWidth_m = 0.045;     // by SeenWidth_m, of spouts 36 mm wide at the root
constexpr double kTip = 0.05, kTipReach = 0.5;  // of its points; of its reach, where those are
constexpr double kMixed = 0.02;                 // on either side: mixed pixels
constexpr double kLeastStandOut = 0.6;  // of a whole handle's points; the rest are its roots

// Extent of the points along the axis of their second largest extent: the width of a straight bar,
// or how far what is bent leaves its chord.
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
  return (Quantile(along, 1 - kTail) - Quantile(along, kTail)) / (1 - 2 * kTail);
}

std::vector<Vector3f> PlacesOf(const OrientedPoints& points,
                               const std::vector<std::uint32_t>& members) {
  std::vector<Vector3f> places;
  for (std::uint32_t i : members) places.push_back(points.points[i]);
  return places;
}

// Between the nearest two of both; of many points every other one or fewer.
double GapBetween_m(const std::vector<Vector3f>& a, const std::vector<Vector3f>& b) {
  float nearest_m2 = std::numeric_limits<float>::infinity();
  for (std::size_t i = 0; i < a.size(); i += 1 + a.size() / kMostForGap) {
    for (std::size_t k = 0; k < b.size(); k += 1 + b.size() / kMostForGap) {
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

double Vessel::StandsOut_m(const Eigen::Vector3f& p) const {
  double out_m = std::numeric_limits<double>::infinity();
  for (const RevolvedWall& wall : walls_) {
    out_m = std::min(out_m, wall.StandsOut_m(p.cast<double>()));
  }
  return out_m;
}

Vessel::Cluster Vessel::StandOut(const OrientedPoints& points,
                                 const std::vector<char>& among) const {
  Cluster out;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (!among[i] || !points.points[i].allFinite()) continue;
    const double out_m = StandsOut_m(points.points[i]);
    const bool near = out_m <= kMostLength_m + kMostHandleGap_m;
    if (near && out_m > kDistanceGate_sigma * double{points.sigma_m[i]}) out.push_back(i);
  }
  return out;
}

bool Vessel::IsHandle(const OrientedPoints& points, const Cluster& cluster, double gap_m) const {
  const std::vector<Vector3f> members = PlacesOf(points, cluster);
  double farthest_m = 0;
  Eigen::AlignedBox3f bounds;
  for (const Vector3f& p : members) {
    const double out_m = StandsOut_m(p);
    gap_m = std::min(gap_m, out_m);
    farthest_m = std::max(farthest_m, out_m);
    bounds.extend(p);
  }
  if (gap_m > kMostHandleGap_m || farthest_m < kLeastReach_m ||
      bounds.sizes().maxCoeff() > kMostLength_m) {  // along it, it is no shorter
    return false;
  }
  const Slenderness bar = MeasureSlenderness(members, points.viewpoint, pitch_m_);
  if (bar.length_m < std::max(kLeastLength_m, kLeastElongation * bar.width_m) ||
      bar.length_m > kMostLength_m || bar.width_m > kMostWidth_m) {
    return false;
  }
  if (EndsAsSpout(members)) return false;
  const double width_m = SeenWidth_m(members, points.viewpoint);
  if (farthest_m > kMostReachOfBow_m) {
    return width_m <= kMostWidthOfBar_m && bar.length_m >= kLeastBarElongation * width_m &&
           BendOf_m(members) <= kMostBend_m;
  }
  const bool returns = StandsOut_m(bar.ends[0].cast<float>()) <= kReturned_m &&
                       StandsOut_m(bar.ends[1].cast<float>()) <= kReturned_m;
  return width_m <= (returns ? kMostWidthOfBow_m : kMostWidth_m);
}

// Whether it rises to where it is as high as the vessel, and ends there, free: bows end at the wall.
bool Vessel::EndsAsSpout(const std::vector<Vector3f>& members) const {
  const auto nearest_m = [&](const RevolvedWall& wall) {
    double out_m = kInfinity;
    for (const Vector3f& p : members) out_m = std::min(out_m, wall.StandsOut_m(p.cast<double>()));
    return out_m;
  };
  const RevolvedWall& wall = *std::ranges::min_element(walls_, {}, nearest_m);
  std::vector<double> heights_m, out_m;
  for (const Vector3f& p : members) {
    heights_m.push_back(wall.R_LW.col(2).dot(p.cast<double>()));
    out_m.push_back(wall.StandsOut_m(p.cast<double>()));
  }
  const double full_m = std::lerp(wall.low_z_m, wall.high_z_m, kFull);
  if (Quantile(heights_m, 1 - kMixed) < full_m) return false;
  const double tip_m = Quantile(heights_m, 1 - kTip);
  double of_tip_m = 0, count = 0;
  for (std::size_t k = 0; k < members.size(); ++k) {
    if (heights_m[k] < tip_m) continue;
    of_tip_m += out_m[k];
    ++count;
  }
  const double farthest_m = Quantile(out_m, 1 - kMixed), nearest = Quantile(out_m, kMixed);
  return of_tip_m > std::max(kReturned_m, kTipReach * farthest_m) * count &&
         tip_m - Quantile(heights_m, kMixed) > kLeastRise * (farthest_m - nearest);
}

bool Vessel::IsSpout(const OrientedPoints& points, const Cluster& cluster) const {
  const std::vector<Vector3f> members = PlacesOf(points, cluster);
  return EndsAsSpout(members) && SeenWidth_m(members, points.viewpoint) <= kMostSpoutWidth_m;
}

double Vessel::Gap_m(const OrientedPoints& points, const Cluster& cluster) const {
  double gap_m = kInfinity;
  for (std::uint32_t i : cluster) gap_m = std::min(gap_m, StandsOut_m(points.points[i]));
  return std::max(gap_m, 0.0);
}

// Of what is left when something wide was taken away: the tip of a spout does not.
bool Vessel::BeginsAtWall(const OrientedPoints& points, const Cluster& cluster) const {
  return Gap_m(points, cluster) <= kReturned_m;
}

// Slim as the handle is, near it, and straight with it or within its bow.
bool Vessel::Continues(const std::vector<Vector3f>& handle, const std::vector<Vector3f>& part,
                       const Vector3& viewpoint) const {
  if (GapBetween_m(handle, part) > kMostHandleGap_m) return false;
  std::vector<Vector3f> both = handle;
  both.insert(both.end(), part.begin(), part.end());
  double farthest_m = 0;
  for (const Vector3f& p : both) farthest_m = std::max(farthest_m, StandsOut_m(p));
  if (farthest_m > kMostReachOfBow_m && BendOf_m(both) > kMostBend_m) return false;
  return SeenWidth_m(part, viewpoint) <= kMostWidth_m;
}

Vessel::Fixed Vessel::FindFixed(const OrientedPoints& object, const std::vector<char>& among,
                                const Work& work) const {
  Fixed found;
  std::vector<Cluster>& handles = found.handles;
  std::vector<Cluster> parts;
  const Cluster out = StandOut(object, among);
  if (out.size() < kLeastHandlePoints) return found;
  Cluster all(out.size());
  std::iota(all.begin(), all.end(), 0u);
  const Connectivity connectivity(
      PlacesOf(object, out), static_cast<float>(std::max(kLeastCell_m, kCellPitches * pitch_m_)));
  const auto in_object = [&](Cluster cluster) {
    for (std::uint32_t& k : cluster) k = out[k];
    return cluster;
  };
  const auto is_handle = [&](const Cluster& cluster) {
    return cluster.size() >= kLeastHandlePoints && IsHandle(object, cluster, kInfinity);
  };
  for (const Cluster& cluster : connectivity.Components(all)) {
    work.Poll();
    if (cluster.size() < kLeastPartPoints) break;  // largest first
    if (Cluster members = in_object(cluster); is_handle(members)) {
      handles.push_back(std::move(members));
      continue;
    }
    if (Cluster members = in_object(cluster); IsSpout(object, members)) {
      found.spouts.push_back(std::move(members));
      continue;
    }
    // What is wider may be a box that touches a handle.
    const std::vector<char> wide = SeenAsWide(PlacesOf(object, in_object(cluster)),
                                              object.viewpoint, kMostWidthOfBow_m, kBesideWide_m);
    Cluster slim, removed;
    for (std::size_t k = 0; k < cluster.size(); ++k) {
      (wide[k] ? removed : slim).push_back(cluster[k]);
    }
    std::vector<char> beside(out.size(), 0);
    for (std::uint32_t k : connectivity.Beside(removed)) beside[k] = 1;
    for (const Cluster& rest : connectivity.Components(slim)) {
      if (rest.size() < kLeastPartPoints) break;
      const auto touching =
          std::count_if(rest.begin(), rest.end(), [&](std::uint32_t k) { return beside[k] != 0; });
      const bool is_edge =
          static_cast<double>(touching) > kMostTouching * static_cast<double>(rest.size());
      Cluster members = in_object(rest);
      const bool whole = !is_edge && is_handle(members) && BeginsAtWall(object, members);
      (whole ? handles : parts).push_back(std::move(members));
    }
  }
  // Where they leave the wall, spouts hide themselves in part.
  std::erase_if(handles, [&](const Cluster& handle) {
    return std::ranges::any_of(found.spouts, [&](const Cluster& spout) {
      return GapBetween_m(PlacesOf(object, spout), PlacesOf(object, handle)) <= kMostHandleGap_m;
    });
  });
  JoinParts(object, std::move(parts), handles);
  return found;
}

void Vessel::Join(const OrientedPoints& object, std::vector<Cluster>& handles) const {
  JoinParts(object, {}, handles);
}

// Handles that were measured in parts become one.
void Vessel::JoinParts(const OrientedPoints& object, std::vector<Cluster> parts,
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
      const double least = kLeastPartShare * static_cast<double>(handles[h].size());
      if (static_cast<double>(part.size()) < least || !continues(handles[h], part)) return false;
      take(handles[h], part);
      return true;
    });
  }
}

std::vector<Vessel::Cluster> Vessel::FindHandlesIn(const OrientedPoints& other,
                                                   const Work& work) const {
  const std::vector<char> all(other.size(), 1);
  if (!BeginsAtWall(other, StandOut(other, all))) return {};
  std::vector<Cluster> handles = FindFixed(other, all, work).handles;
  std::erase_if(handles, [&](const Cluster& handle) { return !BeginsAtWall(other, handle); });
  return handles;
}

double Vessel::ShareOnWalls(const OrientedPoints& other, const std::vector<char>& among) const {
  double on = 0, all = 0;
  for (std::size_t i = 0; i < other.size(); ++i) {
    if (!among[i] || !other.points[i].allFinite()) continue;
    const double gate_m = kDistanceGate_sigma * double{other.sigma_m[i]};
    const double out_m = StandsOut_m(other.points[i]);
    on += out_m <= gate_m && out_m >= -gate_m - kWallThickness_m;
    all += 1;
  }
  return all > 0 ? on / all : 1;
}

bool Vessel::HasHandle(const OrientedPoints& other, const std::vector<Vector3f>& known) const {
  const Cluster out = StandOut(other, std::vector<char>(other.size(), 1));
  return out.size() >= kLeastHandlePoints &&
         static_cast<double>(out.size()) >= kLeastStandOut * static_cast<double>(other.size()) &&
         IsHandle(other, out, GapBetween_m(known, other.points));
}

}  // namespace cwm::perception
