#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/spheres/motion_lanes.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each instruction set
//
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "collision/spheres/lane_geometry-inl.h"
#include "collision/spheres/motion_lanes.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace cwm::collision {
namespace HWY_NAMESPACE {
namespace {

using IntervalTag = hn::CappedTag<float, kIntervals>;
using Real = hn::Vec<IntervalTag>;
using RealMask = hn::Mask<IntervalTag>;
constexpr IntervalTag kReal;
using ExactTag = hn::CappedTag<double, kIntervals>;
using Exact = hn::Vec<ExactTag>;
constexpr ExactTag kExact;

Real Same(float value) { return hn::Set(kReal, value); }

// A point and its velocity over the edge.
struct MovingPoint {
  LanePoint<Real> at, velocity;
};

// derived: the relative error of a few products and sums, in units of the last place.
constexpr float kRounding = 16 * 5.9604644775390625e-8F;

// What a sphere or a bound must keep of another: the distance of their surfaces, less the second
// order of the motion and the errors of single precision.
struct Terms {
  Real slack_m;  // A h^2 / 2 and the errors of distances and velocities
  Real half_width;
  float turned_m2;  // the error of u . c' by that of u
  float error_m;    // of a distance
};

// One vector of intervals of one edge.
class IntervalChecker {
 public:
  IntervalChecker(const LaneProgram& program, const LaneScene& scene, const LaneEdge& edge,
                  LaneMemory& memory)
      : program_(program), scene_(scene), edge_(edge) {
    const std::size_t points =
        program.spheres.size() + program.clusters.size() + program.groups.size();
    const std::size_t numbers = program.joints.size() * kPerFrame + points * kPerPoint + 1;
    memory.numbers.resize(numbers * width());
    memory.indices.resize(program.groups.size() + program.clusters.size());
    memory.reals.resize(program.joints.size() * kPerExactFrame * kIntervals);
    exact_frames_ = memory.reals.data();
    const auto address = reinterpret_cast<std::uintptr_t>(memory.numbers.data());
    const std::size_t step = width() * sizeof(float);
    frames_ = memory.numbers.data() + (step - address % step) % step / sizeof(float);
    centres_ = frames_ + program.joints.size() * kPerFrame * width();
    bounds_ = centres_ + program.spheres.size() * kPerPoint * width();
    groups_ = bounds_ + program.clusters.size() * kPerPoint * width();
    placed_ = memory.indices.data();
    group_placed_ = placed_ + program.clusters.size();
  }

  void Run(const Intervals& intervals, std::size_t first, IntervalResult* results) {
    results_ = results;
    needed_ = intervals.needed;
    half_width_ = hn::LoadU(kReal, &intervals.half_width[first]);
    least_share_ = hn::LoadU(kReal, &intervals.least_share[first]);
    hit_ = done_ = stuck_ = hn::FirstN(kReal, 0);
    clearance_m_ = Same(kLaneClearance_m);
    PlaceFrames(&intervals.middle[first]);
    for (std::size_t p = 0; p < program_.group_pairs.size() && !IsDone(); ++p) CheckSelf(p);
    for (std::size_t g = 0; g < program_.groups.size() && !IsDone(); ++g) CheckWorld(g);
    Write();
  }

  static std::size_t width() { return hn::Lanes(kReal); }

 private:
  static constexpr std::size_t kPerFrame = 18;  // twelve of the frame, six of its twist
  static constexpr std::size_t kPerExactFrame = 12;
  static constexpr std::size_t kPerPoint = 6;

  // The velocity of the frame's points p is linear + angular x p.
  struct Twist {
    LanePoint<Real> angular, linear;
  };

  LaneFrame<Real> LoadFrame(std::int32_t index) const {
    const float* from = frames_ + static_cast<std::size_t>(index) * kPerFrame * width();
    LaneFrame<Real> frame;
    for (std::size_t k = 0; k < 12; ++k) frame.of[k] = hn::Load(kReal, from + k * width());
    return frame;
  }
  Twist LoadTwist(std::int32_t index) const {
    const MovingPoint both =
        Load(frames_ + (static_cast<std::size_t>(index) * kPerFrame + 12) * width(), 0);
    return {both.at, both.velocity};
  }
  void StoreTwist(std::size_t index, const Twist& twist) {
    Store(frames_ + (index * kPerFrame + 12) * width(), 0, {twist.angular, twist.linear});
  }
  static MovingPoint Load(const float* from, std::size_t index) {
    from += index * kPerPoint * width();
    const auto one = [&](std::size_t k) HWY_ATTR { return hn::Load(kReal, from + k * width()); };
    return {{one(0), one(1), one(2)}, {one(3), one(4), one(5)}};
  }
  static void Store(float* to, std::size_t index, const MovingPoint& point) {
    to += index * kPerPoint * width();
    const auto one = [&](std::size_t k, Real value)
                         HWY_ATTR { hn::Store(value, kReal, to + k * width()); };
    one(0, point.at.x);
    one(1, point.at.y);
    one(2, point.at.z);
    one(3, point.velocity.x);
    one(4, point.velocity.y);
    one(5, point.velocity.z);
  }

  // Places the frames in double precision and rounds them.
  void RoundFrames(const double* middles) {
    const hn::Rebind<float, ExactTag> rounded;
    const std::size_t lanes = hn::Lanes(kExact);
    for (std::size_t first = 0; first < width(); first += lanes) {
      const auto at = [&](std::size_t k) {
        return exact_frames_ + k * kPerExactFrame * kIntervals;
      };
      const auto keep = [&](std::size_t k, const LaneFrame<Exact>& frame) HWY_ATTR {
        for (std::size_t i = 0; i < 12; ++i) {
          hn::StoreU(frame.of[i], kExact, at(k) + i * lanes);
          hn::StoreU(hn::DemoteTo(rounded, frame.of[i]), rounded,
                     frames_ + (k * kPerFrame + i) * width() + first);
        }
      };
      LaneFrame<Exact> root;
      for (int i = 0; i < 12; ++i) {
        root.of[i] = hn::Set(kExact, i % 4 < 3 ? scene_.rotation[i / 4 * 3 + i % 4] : 0);
      }
      keep(0, root);
      const Exact middle = hn::LoadU(kExact, middles + first);
      for (std::size_t k = 1; k < program_.joints.size(); ++k) {
        const LaneJoint& joint = program_.joints[k];
        const double* const from = at(static_cast<std::size_t>(joint.parent));
        LaneFrame<Exact> parent;
        for (std::size_t i = 0; i < 12; ++i) parent.of[i] = hn::LoadU(kExact, from + i * lanes);
        const Exact value =
            hn::MulAdd(middle, hn::Set(kExact, edge_.rates[k]), hn::Set(kExact, edge_.starts[k]));
        keep(k, ExactChildFrame(parent, joint, value));
      }
    }
  }

  void PlaceFrames(const double* middles) {
    RoundFrames(middles);
    const Real zero = hn::Zero(kReal);
    StoreTwist(0, {{zero, zero, zero}, {zero, zero, zero}});
    for (std::size_t k = 1; k < program_.joints.size(); ++k) {
      const LaneJoint& joint = program_.joints[k];
      const LaneFrame<Real> frame = LoadFrame(static_cast<std::int32_t>(k));
      Twist twist = LoadTwist(joint.parent);
      const Real rate = Same(static_cast<float>(edge_.rates[k]));
      const LanePoint<Real> axis = frame.AxisZ();
      const LanePoint<Real> moved{hn::Mul(rate, axis.x), hn::Mul(rate, axis.y),
                                  hn::Mul(rate, axis.z)};
      LanePoint<Real>& of = joint.turns ? twist.angular : twist.linear;
      of = {hn::Add(of.x, moved.x), hn::Add(of.y, moved.y), hn::Add(of.z, moved.z)};
      if (joint.turns) twist.linear = PlusCross(twist.linear, frame.Origin(), moved);
      StoreTwist(k, twist);
    }
    for (std::size_t g = 0; g < program_.groups.size(); ++g) {
      const LaneGroup& group = program_.groups[g];
      group_placed_[g] = 0;
      std::fill_n(placed_ + group.first, group.count, 0);
      Place(groups_, g, LoadFrame(group.frame), LoadTwist(group.frame), group.bound);
    }
  }

  static void Place(float* to, std::size_t index, const LaneFrame<Real>& frame, const Twist& twist,
                    const LaneSphere& sphere) {
    const LanePoint<Real> at = frame.Place(sphere.centre_m);
    Store(to, index, {at, PlusCross(twist.linear, twist.angular, at)});
  }
  void PlaceBounds(std::size_t g) {
    if (group_placed_[g] != 0) return;
    group_placed_[g] = 1;
    const LaneGroup& group = program_.groups[g];
    const LaneFrame<Real> frame = LoadFrame(group.frame);
    const Twist twist = LoadTwist(group.frame);
    for (std::int32_t c = group.first; c < group.first + group.count; ++c) {
      const auto at = static_cast<std::size_t>(c);
      Place(bounds_, at, frame, twist, program_.clusters[at].bound);
    }
  }
  void PlaceSpheres(std::size_t c) {
    if (placed_[c] != 0) return;
    placed_[c] = 1;
    const LaneCluster& cluster = program_.clusters[c];
    const LaneFrame<Real> frame = LoadFrame(cluster.frame);
    const Twist twist = LoadTwist(cluster.frame);
    for (std::int32_t s = cluster.first; s < cluster.first + cluster.count; ++s) {
      const auto at = static_cast<std::size_t>(s);
      Place(centres_, at, frame, twist, program_.spheres[at]);
    }
  }

  bool IsDone() const { return hn::AllTrue(kReal, done_); }

  Terms TermsOf(const LaneEdge::Bounds& bounds, float error_m) const {
    const Real h = half_width_;
    const Real second = hn::Mul(hn::Mul(h, h), Same(0.5F * bounds.bend_m));
    const float speed_error_m = edge_.velocity_error_m + kRounding * bounds.speed_m;
    return {.slack_m = hn::Add(second, hn::MulAdd(h, Same(speed_error_m), Same(error_m))),
            .half_width = h,
            .turned_m2 = 2 * bounds.speed_m * error_m,
            .error_m = error_m};
  }

  // The distance that is left of `reach_m` all along, times the distance of the centres.
  static Real Left(Real squared_m2, Real distance_m, Real along_m2, float reach_m,
                   const Terms& terms) {
    const Real closing =
        hn::Mul(terms.half_width, hn::Add(hn::Abs(along_m2), Same(terms.turned_m2)));
    const Real first = hn::MulSub(squared_m2, Same(1 - kRounding), closing);
    return hn::NegMulAdd(distance_m, hn::Add(terms.slack_m, Same(reach_m)), first);
  }

  // True if some lane may come nearer than kLaneClearance_m to the margin.
  bool IsNear(Real left) const {
    return !hn::AllTrue(kReal, hn::Or(done_, hn::Gt(left, hn::Zero(kReal))));
  }

  // The nearest pair of those that were looked at, by lane.
  struct Nearest {
    Real proven_m, gap_m;
    RealMask hit;

    static Nearest None() {
      return {Same(kLaneClearance_m), Same(kLaneClearance_m), hn::FirstN(kReal, 0)};
    }

    void Add(Real squared_m2, Real along_m2, float reach_m, const Terms& terms) {
      const Real distance_m = hn::Sqrt(squared_m2);
      const Real left = Left(squared_m2, distance_m, along_m2, reach_m, terms);
      constexpr float kTiny_m = 1e-9F;  // where the distance is 0, so is what is left
      proven_m = hn::Min(proven_m, hn::Div(left, hn::Max(distance_m, Same(kTiny_m))));
      gap_m = hn::Min(gap_m, hn::Sub(distance_m, Same(reach_m)));
      const float sure_m = reach_m - terms.error_m;
      if (sure_m > 0) {
        hit = hn::Or(hit, hn::Lt(squared_m2, Same(sure_m * sure_m * (1 - kRounding))));
      }
    }
  };

  void Keep(const Nearest& nearest, LaneProof proof, std::uint64_t UnresolvedTags::*what,
            std::int32_t tag) {
    RealMask hit = hn::FirstN(kReal, 0);
    if (proof.of_contact) {
      hit = hn::AndNot(done_, nearest.hit);
      if (!hn::AllFalse(kReal, hit)) {
        Note(hit, &IntervalResult::touching, what, tag);
        hit_ = hn::Or(hit_, hit);
        // Only what comes before the first contact matters.
        const auto first = static_cast<std::size_t>(hn::FindFirstTrue(kReal, hit_));
        done_ = hn::Not(hn::FirstN(kReal, first + 1));
      }
    }
    if (!proof.of_gap && hn::AllFalse(kReal, hit)) return;
    const Real least = Same(proof.of_contact ? 0.0F : edge_.gap_only_clearance_m);
    const Real wanted = hn::Max(least, hn::Mul(least_share_, nearest.gap_m));
    const RealMask open = hn::Or(hit, hn::Le(nearest.proven_m, wanted));
    clearance_m_ =
        hn::Min(clearance_m_, hn::IfThenElse(open, Same(kLaneClearance_m), nearest.proven_m));
    const RealMask new_open = hn::AndNot(done_, open);
    if (hn::AllFalse(kReal, new_open)) return;
    Note(new_open, &IntervalResult::open, what, tag);
    if (!proof.of_contact) stuck_ = hn::Or(stuck_, hn::And(new_open, hn::Le(nearest.gap_m, least)));
  }

  void Note(RealMask lanes, UnresolvedTags IntervalResult::*where,
            std::uint64_t UnresolvedTags::*what, std::int32_t tag) {
    std::uint8_t some[8] = {};
    hn::StoreMaskBits(kReal, lanes, some);
    for (unsigned bits = some[0]; bits != 0; bits &= bits - 1) {
      (results_[std::countr_zero(bits)].*where).*what |= std::uint64_t{1} << tag;
    }
  }
  static bool Has(std::uint64_t tags, std::int32_t tag) { return (tags >> tag & 1) != 0; }

  struct Between {
    Real squared_m2, along_m2;
  };
  static Between Of(const MovingPoint& a, const MovingPoint& b) {
    const LanePoint<Real> u = Minus(a.at, b.at);
    return {Dot(u, u), Dot(u, Minus(a.velocity, b.velocity))};
  }

  void CheckSelf(std::size_t p) {
    const LaneGroupPair& pair = program_.group_pairs[p];
    if ((pair.tags & needed_.pairs) == 0) return;
    const auto a = static_cast<std::size_t>(pair.first), b = static_cast<std::size_t>(pair.second);
    const LaneEdge::Bounds& bounds = edge_.of_pair[p];
    const Between groups = Of(Load(groups_, a), Load(groups_, b));
    const Terms terms = TermsOf(bounds, pair.band.motion_error_m);
    if (!IsNear(Left(groups.squared_m2, hn::Sqrt(groups.squared_m2), groups.along_m2,
                     pair.reach_m + kLaneClearance_m, terms))) {
      return;
    }
    PlaceBounds(a);
    PlaceBounds(b);
    for (std::int32_t k = pair.begin; k < pair.end && !IsDone(); ++k) {
      CheckClusters(program_.cluster_pairs[static_cast<std::size_t>(k)], bounds);
    }
  }

  void CheckClusters(const LaneClusterPair& pair, const LaneEdge::Bounds& bounds) {
    if (!Has(needed_.pairs, pair.tag)) return;
    const auto a = static_cast<std::size_t>(pair.first), b = static_cast<std::size_t>(pair.second);
    const LaneCluster &one = program_.clusters[a], &other = program_.clusters[b];
    const Terms terms = TermsOf(bounds, pair.band.motion_error_m);
    const Between between = Of(Load(bounds_, a), Load(bounds_, b));
    const float reach_m =
        one.bound.radius_m + other.bound.radius_m + pair.margin_m + kLaneClearance_m;
    if (!IsNear(Left(between.squared_m2, hn::Sqrt(between.squared_m2), between.along_m2, reach_m,
                     terms))) {
      return;
    }
    PlaceSpheres(a);
    PlaceSpheres(b);
    Nearest nearest = Nearest::None();
    const auto add = [&](std::int32_t s, std::int32_t t) HWY_ATTR {
      const auto first = static_cast<std::size_t>(s), second = static_cast<std::size_t>(t);
      const Between two = Of(Load(centres_, first), Load(centres_, second));
      const float sum_m =
          program_.spheres[first].radius_m + program_.spheres[second].radius_m + pair.margin_m;
      nearest.Add(two.squared_m2, two.along_m2, sum_m, terms);
    };
    for (std::int32_t k = pair.begin; k < pair.end; ++k) {
      const LaneSpherePair& two = program_.sphere_pairs[static_cast<std::size_t>(k)];
      add(two.first, two.second);
    }
    if (pair.begin == pair.end) {
      for (std::int32_t s = one.first; s < one.first + one.count; ++s) {
        for (std::int32_t t = other.first; t < other.first + other.count; ++t) add(s, t);
      }
    }
    Keep(nearest, pair.proof, &UnresolvedTags::pairs, pair.tag);
  }

  void CheckWorld(std::size_t g) {
    const LaneScene::Range& range = scene_.near_group[g];
    const LaneGroup& group = program_.groups[g];
    if ((group.tags & needed_.worlds) == 0) return;
    const MovingPoint bound = Load(groups_, g);
    const Terms terms = TermsOf(edge_.of_group[g], range.band.motion_error_m);
    for (std::int32_t k = range.begin; k < range.end; ++k) {
      const auto o = static_cast<std::size_t>(scene_.near[static_cast<std::size_t>(k)]);
      const LaneObstacle& obstacle = scene_.obstacles[o];
      const float reach_m = group.bound.radius_m + obstacle.margin_m + kLaneClearance_m;
      if (!IsNear(LeftOf(obstacle, bound, reach_m, terms))) continue;
      CheckObstacle(g, obstacle, terms);
      if (IsDone()) return;
    }
  }

  static Real LeftOf(const LaneObstacle& obstacle, const MovingPoint& point, float reach_m,
                     const Terms& terms) {
    return ForForm(obstacle, [&]<LaneObstacle::Form kForm, bool kIsAligned>() HWY_ATTR {
      const LaneSolid solid(obstacle);
      const LaneOffset<Real> offset = solid.template OffsetOf<kForm, kIsAligned>(point.at);
      const Real along = solid.template Along<kIsAligned>(offset.local, point.velocity);
      return Left(offset.squared_m2, hn::Sqrt(offset.squared_m2), along, reach_m + offset.grown_m,
                  terms);
    });
  }

  void CheckObstacle(std::size_t g, const LaneObstacle& obstacle, const Terms& terms) {
    PlaceBounds(g);
    const LaneGroup& group = program_.groups[g];
    for (std::int32_t c = group.first; c < group.first + group.count; ++c) {
      const auto at = static_cast<std::size_t>(c);
      const LaneCluster& cluster = program_.clusters[at];
      const LaneProof proof = cluster.proof.With(obstacle.is_hull);
      if (!Has(needed_.worlds, cluster.tag) || !(proof.of_gap || proof.of_contact)) continue;
      const float reach_m = cluster.bound.radius_m + obstacle.margin_m + kLaneClearance_m;
      if (!IsNear(LeftOf(obstacle, Load(bounds_, at), reach_m, terms))) continue;
      PlaceSpheres(at);
      Keep(NearestOf(obstacle, cluster, terms), proof, &UnresolvedTags::worlds, cluster.tag);
    }
  }

  Nearest NearestOf(const LaneObstacle& obstacle, const LaneCluster& cluster,
                    const Terms& terms) const {
    return ForForm(obstacle, [&]<LaneObstacle::Form kForm, bool kIsAligned>() HWY_ATTR {
      const LaneSolid solid(obstacle);
      Nearest nearest = Nearest::None();
      for (std::int32_t s = cluster.first; s < cluster.first + cluster.count; ++s) {
        const auto at = static_cast<std::size_t>(s);
        const MovingPoint point = Load(centres_, at);
        const LaneOffset<Real> offset = solid.template OffsetOf<kForm, kIsAligned>(point.at);
        const Real along = solid.template Along<kIsAligned>(offset.local, point.velocity);
        nearest.Add(offset.squared_m2, along,
                    program_.spheres[at].radius_m + obstacle.margin_m + offset.grown_m, terms);
      }
      return nearest;
    });
  }

  void Write() {
    alignas(64) float clearance_m[kIntervals];
    hn::Store(clearance_m_, kReal, clearance_m);
    std::uint8_t stuck[8] = {}, hit[8] = {};
    hn::StoreMaskBits(kReal, stuck_, stuck);
    hn::StoreMaskBits(kReal, hit_, hit);
    for (std::size_t i = 0; i < width(); ++i) {
      results_[i].is_stuck = (stuck[0] >> i & 1) != 0;
      results_[i].is_contact = (hit[0] >> i & 1) != 0;
      results_[i].clearance_m = clearance_m[i];
    }
  }

  const LaneProgram& program_;
  const LaneScene& scene_;
  const LaneEdge& edge_;
  double* exact_frames_ = nullptr;
  float* frames_ = nullptr;
  float *centres_ = nullptr, *bounds_ = nullptr, *groups_ = nullptr;
  std::int32_t* placed_ = nullptr;        // by cluster: true if its spheres are placed
  std::int32_t* group_placed_ = nullptr;  // by group: true if its clusters' bounds are placed
  UnresolvedTags needed_;
  Real half_width_, least_share_, clearance_m_;
  RealMask hit_, done_, stuck_;
  IntervalResult* results_ = nullptr;  // by lane
};

void CheckAllIntervals(const LaneProgram& program, const LaneScene& scene, const LaneEdge& edge,
                       const Intervals& intervals, LaneMemory& memory, IntervalResult* results) {
  IntervalChecker checker(program, scene, edge, memory);
  for (std::size_t first = 0; first < intervals.count; first += checker.width()) {
    IntervalResult some[kIntervals];
    checker.Run(intervals, first, some);
    const std::size_t count = HWY_MIN(checker.width(), intervals.count - first);
    for (std::size_t i = 0; i < count; ++i) {
      results[first + i] = some[i];
      if (some[i].is_contact) return;
    }
  }
}

}  // namespace
// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace HWY_NAMESPACE
}  // namespace cwm::collision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cwm::collision {

HWY_EXPORT(CheckAllIntervals);

void CheckIntervals(const LaneProgram& program, const LaneScene& scene, const LaneEdge& edge,
                    const Intervals& intervals, LaneMemory& memory,
                    std::array<IntervalResult, kIntervals>& results) {
  HWY_DYNAMIC_DISPATCH(CheckAllIntervals)
  (program, scene, edge, intervals, memory, results.data());
}

}  // namespace cwm::collision
#endif  // HWY_ONCE
