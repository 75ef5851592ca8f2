#include "collision/spheres/sphere_program.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <tuple>
#include <utility>

#include "collision/spheres/lane_frames.h"
#include "collision/spheres/revolute_pair.h"
#include "collision/spheres/sphere_lanes.h"

namespace cwm::collision {
namespace {

constexpr double kRoundedUp = 1 + 4 * kFloatRounding;

// The squared reach as SIMD code computes it.
float Squared(double reach_m) {
  const auto reach = static_cast<float>(reach_m);
  return reach * reach;
}

// A sphere that is fixed in a frame.
struct FixedSphere {
  std::size_t frame = 0;
  Vector3 centre_F = Vector3::Zero();
  double radius_m = 0;
};

class Compiler {
 public:
  explicit Compiler(LaneFrames frames) : frames_(frames.frames()), links_(frames.links()) {
    program_.lanes.joints = frames.joints();
    program_.inputs = frames.inputs();
  }

  void AddSpheres(std::span<const PlacedSphere> spheres) {
    LaneProgram& lanes = program_.lanes;
    lane_of_.resize(spheres.size());
    cluster_of_.resize(spheres.size());
    std::vector<std::size_t> order(spheres.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto frame_of = [&](std::size_t k) {
      return links_[static_cast<std::size_t>(spheres[k].link)].frame;
    };
    // A group has the spheres of one frame and class.
    const auto group_of = [&](std::size_t k) {
      return std::pair(frame_of(k), spheres[k].scene_class);
    };
    const auto key_of = [&](std::size_t k) {
      const LaneProof& proof = spheres[k].proof;
      return std::tuple(group_of(k), spheres[k].link, proof.of_gap, proof.of_contact, k);
    };
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return key_of(a) < key_of(b); });
    const std::span<std::size_t> all(order);
    for (std::size_t begin = 0; begin < all.size();) {
      std::size_t end = begin;
      while (end < all.size() && group_of(all[end]) == group_of(all[begin])) ++end;
      AddGroup(spheres, all.subspan(begin, end - begin));
      begin = end;
    }
    group_of_cluster_.resize(lanes.clusters.size());
    for (std::size_t g = 0; g < lanes.groups.size(); ++g) {
      std::fill_n(group_of_cluster_.begin() + lanes.groups[g].first, lanes.groups[g].count,
                  static_cast<std::int32_t>(g));
    }
  }

  void AddPairs(std::span<const PlacedSphere> spheres, std::span<const SpherePair> pairs) {
    LaneProgram& lanes = program_.lanes;
    const std::size_t clusters = lanes.clusters.size();
    const auto slot_of = [&](const SpherePair& pair) {
      return static_cast<std::size_t>(ClusterOf(pair.first)) * clusters +
             static_cast<std::size_t>(ClusterOf(pair.second));
    };
    const std::vector<SpherePair> touching = PairsThatMayTouch(spheres, pairs);
    struct Slot {
      std::int32_t count = 0, next = 0, tag = 0;
      double margin_m = 0;
    };
    std::vector<Slot> slots(clusters * clusters);
    for (const SpherePair& pair : touching) {
      Slot& slot = slots[slot_of(pair)];
      ++slot.count;
      slot.tag = pair.tag;
      slot.margin_m = std::max(slot.margin_m, pair.margin_m);
    }
    // In the order of pairs of groups; the clusters of a group are consecutive.
    std::int32_t begin = 0;
    for (const LaneGroup& one : lanes.groups) {
      for (const LaneGroup& other : lanes.groups) {
        for (std::int32_t a = one.first; a < one.first + one.count; ++a) {
          for (std::int32_t b = other.first; b < other.first + other.count; ++b) {
            Slot& slot =
                slots[static_cast<std::size_t>(a) * clusters + static_cast<std::size_t>(b)];
            if (slot.count == 0) continue;
            AddClusterPair(a, b, {begin, begin + slot.count}, slot.margin_m);
            lanes.cluster_pairs.back().tag = slot.tag;
            slot.next = begin;
            begin += slot.count;
          }
        }
      }
    }
    lanes.sphere_pairs.resize(touching.size());
    for (const SpherePair& pair : touching) {
      const auto a = static_cast<std::size_t>(pair.first),
                 b = static_cast<std::size_t>(pair.second);
      lanes.sphere_pairs[static_cast<std::size_t>(slots[slot_of(pair)].next++)] = {
          lane_of_[a], lane_of_[b],
          Squared(spheres[a].radius_m + spheres[b].radius_m + pair.margin_m)};
    }
  }

  // Adds all pairs of clusters of two links, ordered by pairs of groups.
  void AddPairs(std::span<const SphereLinkPair> pairs) {
    struct ClusterPair {
      std::int32_t first, second;
      const SphereLinkPair* of;
      LaneProof proof;
    };
    std::vector<ClusterPair> all;
    const auto clusters = static_cast<std::int32_t>(program_.lanes.clusters.size());
    std::vector<std::vector<std::int32_t>> of_link(links_.size());
    for (std::int32_t c = 0; c < clusters; ++c) {
      of_link[static_cast<std::size_t>(link_of_cluster_[static_cast<std::size_t>(c)])].push_back(c);
    }
    for (const SphereLinkPair& pair : pairs) {
      for (std::int32_t a : of_link[static_cast<std::size_t>(pair.links.first)]) {
        for (std::int32_t b : of_link[static_cast<std::size_t>(pair.links.second)]) {
          const LaneProof proof = (ProofOf(a) & ProofOf(b)).With(pair.proves_gap_only);
          const bool proves = proof.of_gap || proof.of_contact;
          if (!proves || StayApart(BoundOf(a), BoundOf(b), pair.margin_m)) continue;
          all.push_back({a, b, &pair, proof});
        }
      }
    }
    const auto groups_of = [&](const ClusterPair& pair) {
      return std::pair(group_of_cluster_[static_cast<std::size_t>(pair.first)],
                       group_of_cluster_[static_cast<std::size_t>(pair.second)]);
    };
    std::ranges::stable_sort(all, {}, groups_of);
    for (const ClusterPair& pair : all) {
      AddClusterPair(pair.first, pair.second, {0, 0}, pair.of->margin_m);
      LaneClusterPair& added = program_.lanes.cluster_pairs.back();
      added.tag = pair.of->tag;
      added.proof = pair.proof;
    }
  }

  SphereProgram Take() {
    SetTags();
    SetVelocityError();
    return std::move(program_);
  }

 private:
  // Adds the spheres of one frame as a group.
  void AddGroup(std::span<const PlacedSphere> spheres, std::span<std::size_t> some) {
    LaneProgram& lanes = program_.lanes;
    const LaneFrames::Fixed& fixed = links_[static_cast<std::size_t>(spheres[some[0]].link)];
    const LaneFrames::Frame& frame = frames_[fixed.frame];
    LaneGroup group{.frame = frame.index,
                    .first = static_cast<std::int32_t>(lanes.clusters.size())};
    for (std::size_t begin = 0; begin < some.size();) {
      std::size_t end = begin;
      const PlacedSphere& first = spheres[some[begin]];
      const auto is_alike = [&](const PlacedSphere& other) {
        return other.link == first.link && other.proof == first.proof;
      };
      while (end < some.size() && is_alike(spheres[some[end]])) ++end;
      AddClusters(spheres, some.subspan(begin, end - begin));
      begin = end;
    }
    group.count = static_cast<std::int32_t>(lanes.clusters.size()) - group.first;
    const SphereProgram::Ball around = Around(spheres, some);
    LaneCluster as_one;
    program_.class_of_group.push_back(spheres[some[0]].scene_class);
    group.bound = InLanes(frame, around.centre, kRoundedUp * around.radius_m, as_one);
    for (std::int32_t c = group.first; c < group.first + group.count; ++c) {
      LaneCluster& cluster = lanes.clusters[static_cast<std::size_t>(c)];
      cluster.centre_error_m = std::max(cluster.centre_error_m, as_one.centre_error_m);
      cluster.motion_error_m = std::max(cluster.motion_error_m, as_one.motion_error_m);
    }
    lanes.groups.push_back(group);
    const double out_m = around.centre.norm() + around.radius_m;
    program_.reach_of_group.push_back(
        frame.index == 0 ? around
                         : SphereProgram::Ball{frame.reach.centre, frame.reach.radius_m + out_m});
    double lever_m = out_m;
    for (auto f = static_cast<std::size_t>(frame.index); f > 0;
         f = static_cast<std::size_t>(lanes.joints[f].parent)) {
      double& max_lever_m = program_.inputs[f - 1].lever_m;
      max_lever_m = std::max(max_lever_m, lever_m);
      lever_m += Eigen::Map<const Eigen::Vector3f>(lanes.joints[f].shift_m).cast<double>().norm();
    }
  }

  // Splits the spheres of one link in halves across the longest side, down to clusters of a few.
  void AddClusters(std::span<const PlacedSphere> spheres, std::span<std::size_t> some) {
    constexpr std::size_t kMaxClusterSize = 4;  // tuned: 3 and 6 are as fast
    if (some.size() <= kMaxClusterSize) return AddCluster(spheres, some);
    Eigen::AlignedBox3d box;
    for (std::size_t k : some) box.extend(spheres[k].centre_L);
    int axis = 0;
    box.sizes().maxCoeff(&axis);
    const auto half = static_cast<std::ptrdiff_t>(some.size() / 2);
    std::nth_element(
        some.begin(), some.begin() + half, some.end(), [&](std::size_t a, std::size_t b) {
          return std::pair(spheres[a].centre_L[axis], a) < std::pair(spheres[b].centre_L[axis], b);
        });
    AddClusters(spheres, some.first(static_cast<std::size_t>(half)));
    AddClusters(spheres, some.subspan(static_cast<std::size_t>(half)));
  }

  void AddCluster(std::span<const PlacedSphere> spheres, std::span<const std::size_t> some) {
    LaneProgram& lanes = program_.lanes;
    const LaneFrames::Fixed& fixed = links_[static_cast<std::size_t>(spheres[some[0]].link)];
    const LaneFrames::Frame& frame = frames_[fixed.frame];
    LaneCluster cluster{.frame = frame.index,
                        .first = static_cast<std::int32_t>(lanes.spheres.size()),
                        .count = static_cast<std::int32_t>(some.size()),
                        .tag = spheres[some[0]].link % kTags,
                        .proof = spheres[some[0]].proof};
    link_of_cluster_.push_back(spheres[some[0]].link);
    for (std::size_t k : some) {
      lane_of_[k] = static_cast<std::int32_t>(lanes.spheres.size());
      cluster_of_[k] = static_cast<std::int32_t>(lanes.clusters.size());
      lanes.spheres.push_back(
          InLanes(frame, fixed.X_FL * spheres[k].centre_L, spheres[k].radius_m, cluster));
      cluster.max_radius_m = std::max(cluster.max_radius_m, lanes.spheres.back().radius_m);
    }
    const SphereProgram::Ball around = Around(spheres, some);
    cluster.bound = InLanes(frame, around.centre, kRoundedUp * around.radius_m, cluster);
    lanes.clusters.push_back(cluster);
  }

  // A small ball around the spheres, in the frame that they share: its centre moves from the middle
  // of their box towards the farthest sphere in ever smaller steps (Badoiu and Clarkson 2003).
  SphereProgram::Ball Around(std::span<const PlacedSphere> spheres,
                             std::span<const std::size_t> some) const {
    std::vector<Vector3> centres_F;
    Eigen::AlignedBox3d box;
    for (std::size_t k : some) {
      centres_F.push_back(links_[static_cast<std::size_t>(spheres[k].link)].X_FL *
                          spheres[k].centre_L);
      box.extend(centres_F.back());
    }
    Vector3 middle = box.center();
    SphereProgram::Ball best{middle, std::numeric_limits<double>::infinity()};
    constexpr int kSteps = 8;
    for (int step = 2; step < kSteps; ++step) {
      std::pair<double, std::size_t> farthest{-1, 0};
      for (std::size_t i = 0; i < some.size(); ++i) {
        const double out_m = (centres_F[i] - middle).norm() + spheres[some[i]].radius_m;
        if (out_m > farthest.first) farthest = {out_m, i};
      }
      if (farthest.first < best.radius_m) best = {middle, farthest.first};
      middle += (centres_F[farthest.second] - middle) / step;
    }
    return best;
  }

  LaneProof ProofOf(std::int32_t cluster) const {
    return program_.lanes.clusters[static_cast<std::size_t>(cluster)].proof;
  }

  std::int32_t ClusterOf(std::int32_t sphere) const {
    return cluster_of_[static_cast<std::size_t>(sphere)];
  }

  FixedSphere BoundOf(std::int32_t index) const {
    const LaneCluster& cluster = program_.lanes.clusters[static_cast<std::size_t>(index)];
    const Eigen::Map<const Eigen::Vector3f> centre_F(cluster.bound.centre_m);
    return {static_cast<std::size_t>(cluster.frame), centre_F.cast<double>(),
            cluster.bound.radius_m};
  }

  FixedSphere Fix(const PlacedSphere& sphere) const {
    const LaneFrames::Fixed& link = links_[static_cast<std::size_t>(sphere.link)];
    return {link.frame, link.X_FL * sphere.centre_L, sphere.radius_m};
  }

  // True if the two are proven apart in every state, which is tried if one or two rotary joints
  // connect their frames.
  bool StayApart(const FixedSphere& a, const FixedSphere& b, double margin_m) const {
    if (a.frame > b.frame) return StayApart(b, a, margin_m);  // a frame comes after its parent
    const LaneFrames::Frame& outer = frames_[b.frame];
    if (!outer.turning) return false;
    const double reach_m = a.radius_m + b.radius_m + margin_m + Rounding_m(program_.lanes.reach_m);
    if (outer.parent == a.frame) {
      return RevolutePair(*outer.turning).KeepsApart(a.centre_F, b.centre_F, reach_m);
    }
    const LaneFrames::Frame& inner = frames_[outer.parent];
    if (!inner.turning || inner.parent != a.frame) return false;
    return RevolutePair(*inner.turning, *outer.turning).KeepsApart(a.centre_F, b.centre_F, reach_m);
  }

  std::vector<SpherePair> PairsThatMayTouch(std::span<const PlacedSphere> spheres,
                                            std::span<const SpherePair> pairs) const {
    std::map<std::tuple<std::int32_t, std::int32_t, double>, bool> clusters_stay_apart;
    std::vector<SpherePair> touching;
    for (const SpherePair& pair : pairs) {
      const std::int32_t a = ClusterOf(pair.first), b = ClusterOf(pair.second);
      const auto [known, is_new] = clusters_stay_apart.try_emplace({a, b, pair.margin_m}, false);
      if (is_new) known->second = StayApart(BoundOf(a), BoundOf(b), pair.margin_m);
      if (known->second) continue;
      if (StayApart(Fix(spheres[static_cast<std::size_t>(pair.first)]),
                    Fix(spheres[static_cast<std::size_t>(pair.second)]), pair.margin_m))
        continue;
      touching.push_back(pair);
    }
    return touching;
  }

  struct Range {
    std::int32_t begin, end;
  };
  void AddClusterPair(std::int32_t first, std::int32_t second, const Range& of, double margin_m) {
    LaneProgram& lanes = program_.lanes;
    const LaneCluster& a = lanes.clusters[static_cast<std::size_t>(first)];
    const LaneCluster& b = lanes.clusters[static_cast<std::size_t>(second)];
    const double reach_m = double{a.bound.radius_m} + double{b.bound.radius_m} + margin_m;
    const double error_m =
        double{a.centre_error_m} + double{b.centre_error_m} + Rounding_m(lanes.reach_m);
    // Rounding of the distance itself is relative to it (motion_lanes.cc).
    const double motion_error_m =
        double{a.motion_error_m} + double{b.motion_error_m} + 4 * kFloatRounding * reach_m;
    LaneBand band =
        BandOf(error_m, double{a.max_radius_m} + double{b.max_radius_m} + margin_m, reach_m);
    band.motion_error_m = static_cast<float>(kRoundedUp * motion_error_m);
    const auto index = static_cast<std::int32_t>(lanes.cluster_pairs.size());
    lanes.cluster_pairs.push_back({.first = first,
                                   .second = second,
                                   .reach_m2 = Squared(kRoundedUp * reach_m),
                                   .begin = of.begin,
                                   .end = of.end,
                                   .band = band,
                                   .proof = a.proof & b.proof,
                                   .margin_m = static_cast<float>(margin_m)});
    const std::int32_t group_a = group_of_cluster_[static_cast<std::size_t>(first)];
    const std::int32_t group_b = group_of_cluster_[static_cast<std::size_t>(second)];
    const double groups_m =
        kRoundedUp *
        (double{lanes.groups[static_cast<std::size_t>(group_a)].bound.radius_m} +
         double{lanes.groups[static_cast<std::size_t>(group_b)].bound.radius_m} + margin_m);
    if (lanes.group_pairs.empty() || lanes.group_pairs.back().first != group_a ||
        lanes.group_pairs.back().second != group_b) {
      lanes.group_pairs.push_back({.first = group_a,
                                   .second = group_b,
                                   .begin = index,
                                   .ancestor = CommonAncestor(a.frame, b.frame)});
    }
    // The margins of its pairs of clusters can differ: the widest counts.
    LaneGroupPair& groups = lanes.group_pairs.back();
    groups.end = index + 1;
    groups.reach_m = std::max(groups.reach_m, static_cast<float>(groups_m));
    groups.reach_m2 = Squared(groups.reach_m);
    groups.band.bounds_m2 =
        std::max(groups.band.bounds_m2, BandOf(error_m, 0, groups.reach_m).bounds_m2);
    groups.band.motion_error_m = std::max(groups.band.motion_error_m, band.motion_error_m);
  }

  void SetTags() {
    LaneProgram& lanes = program_.lanes;
    const auto bit = [](std::int32_t tag) { return std::uint64_t{1} << tag; };
    for (LaneGroup& group : lanes.groups) {
      for (std::int32_t c = group.first; c < group.first + group.count; ++c) {
        group.tags |= bit(lanes.clusters[static_cast<std::size_t>(c)].tag);
      }
    }
    for (LaneGroupPair& pair : lanes.group_pairs) {
      for (std::int32_t k = pair.begin; k < pair.end; ++k) {
        pair.tags |= bit(lanes.cluster_pairs[static_cast<std::size_t>(k)].tag);
      }
    }
  }

  std::int32_t CommonAncestor(std::int32_t a, std::int32_t b) const {
    while (a != b) {  // parents have lower indices
      std::int32_t& later = a > b ? a : b;
      later = program_.lanes.joints[static_cast<std::size_t>(later)].parent;
    }
    return a;
  }

  // The velocity of a centre c is the sum of a_j x (c - o_j) over the turning joints, with axes a_j
  // and origins o_j, and of a_j over the sliding ones. SIMD code adds up the joints' angular
  // velocities, and the products a_j x o_j apart from them.
  void SetVelocityError() {
    constexpr double u = kFloatRounding;
    double motion_error_m = 0, farthest_m = 1;
    for (const LaneFrames::Frame& frame : frames_) {
      farthest_m = std::max(farthest_m, frame.reach.centre.norm() + frame.reach.radius_m);
    }
    for (const LaneCluster& cluster : program_.lanes.clusters) {
      motion_error_m = std::max(motion_error_m, double{cluster.motion_error_m});
    }
    farthest_m = std::max(farthest_m, double{program_.lanes.reach_m});
    const double error =
        motion_error_m + (72 + 4 * static_cast<double>(frames_.size())) * u * farthest_m;
    program_.lanes.velocity_error = static_cast<float>(1.01 * error);
  }

  LaneSphere InLanes(const LaneFrames::Frame& frame, const Vector3& centre_F, double radius_m,
                     LaneCluster& cluster) {
    constexpr double u = kFloatRounding;
    LaneProgram& lanes = program_.lanes;
    LaneSphere sphere{.centre_m = {}, .radius_m = static_cast<float>(radius_m)};
    for (int i = 0; i < 3; ++i) sphere.centre_m[i] = static_cast<float>(centre_F[i]);
    const double out_m = frame.reach.centre.norm() + frame.reach.radius_m + centre_F.norm();
    const double error_m = frame.origin_error_m + frame.rotation_error * centre_F.norm() +
                           8 * u * (out_m + centre_F.norm());
    lanes.reach_m = std::max(lanes.reach_m, static_cast<float>(kRoundedUp * out_m));
    cluster.centre_error_m =
        std::max(cluster.centre_error_m, static_cast<float>(kRoundedUp * error_m));
    // derived: a frame that is rounded from double precision and the centre in it have an error of
    // u in each number, and three products and sums round numbers no larger than out_m.
    const double motion_error_m = 9 * u * out_m;
    cluster.motion_error_m =
        std::max(cluster.motion_error_m, static_cast<float>(kRoundedUp * motion_error_m));
    return sphere;
  }

  const std::vector<LaneFrames::Frame> frames_;
  const std::vector<LaneFrames::Fixed> links_;
  std::vector<std::int32_t> lane_of_, cluster_of_;  // by index of the given sphere
  std::vector<std::int32_t> group_of_cluster_, link_of_cluster_;
  SphereProgram program_;
};

}  // namespace

std::optional<SphereProgram> CompileSpheres(const RobotModel& model, const JointGroup& group,
                                            std::span<const double> base, const SphereSet& set) {
  std::optional<LaneFrames> frames = LaneFrames::Of(model, group, base, set.fixed_frames);
  if (!frames) return std::nullopt;
  Compiler compiler(*std::move(frames));
  compiler.AddSpheres(set.spheres);
  compiler.AddPairs(set.spheres, set.pairs.spheres);
  compiler.AddPairs(set.pairs.links);
  return compiler.Take();
}

double Rounding_m(double coordinate_m) {
  constexpr double kRoundings = 32 * kFloatRounding;
  constexpr double kSlack_m = 1e-8;
  return kRoundings * coordinate_m + kSlack_m;
}

LaneBand BandOf(double error_m, double max_sphere_radius_m, double max_bound_radius_m) {
  const auto beyond = [&](double reach_m) {
    return static_cast<float>(1.001 * (2 * reach_m * error_m + error_m * error_m +
                                       16 * kFloatRounding * reach_m * reach_m));
  };
  return {.spheres_m2 = beyond(max_sphere_radius_m), .bounds_m2 = beyond(max_bound_radius_m)};
}

}  // namespace cwm::collision
