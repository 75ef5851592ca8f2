#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/spheres/sphere_lanes.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each instruction set
//
#include <algorithm>
#include <bit>

#include "collision/spheres/lane_geometry-inl.h"
#include "collision/spheres/sphere_lanes.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace cwm::collision {
namespace HWY_NAMESPACE {
namespace {

using Tag = hn::CappedTag<float, kMaxLanes>;
using Lane = hn::Vec<Tag>;
using LaneMask = hn::Mask<Tag>;
constexpr Tag kTag;

using Point = LanePoint<Lane>;
using Frame = LaneFrame<Lane>;

Lane All(float value) { return hn::Set(kTag, value); }

// Processes states, one vector at a time.
class StateChecker {
 public:
  StateChecker(const LaneProgram& program, const LaneScene& scene, LaneMemory& memory)
      : program_(program), scene_(scene) {
    const std::size_t numbers = program.joints.size() * 12 + program.spheres.size() * 3 +
                                (program.clusters.size() + program.groups.size()) * 3 + 1;
    memory.numbers.resize(numbers * width());
    memory.indices.resize(program.groups.size() + program.clusters.size() +
                          std::max(scene.obstacles.size(), program.cluster_pairs.size()) + 1);
    const auto address = reinterpret_cast<std::uintptr_t>(memory.numbers.data());
    const std::size_t step = width() * sizeof(float);
    frames_ = memory.numbers.data() + (step - address % step) % step / sizeof(float);
    centres_ = frames_ + program.joints.size() * 12 * width();
    bounds_ = centres_ + program.spheres.size() * 3 * width();
    groups_ = bounds_ + program.clusters.size() * 3 * width();
    placed_ = memory.indices.data();
    group_placed_ = placed_ + program.clusters.size();
    near_ = group_placed_ + program.groups.size();
    Frame root;
    for (int k = 0; k < 12; ++k)
      root.of[k] = All(k % 4 < 3 ? scene.rotation[k / 4 * 3 + k % 4] : 0);
    StoreFrame(0, root);
    std::fill(memory.indices.begin(), memory.indices.end(), 0);
    std::fill_n(open_worlds_, kTags, hn::FirstN(kTag, 0));
    std::fill_n(open_pairs_, kTags, hn::FirstN(kTag, 0));
    for (std::size_t g = 0; g < program.groups.size(); ++g) {
      const LaneGroup& group = program.groups[g];
      if (group.frame == 0) StorePoint(groups_, g, LoadFrame(0).Place(group.bound.centre_m));
    }
  }

  // Sets the tags of the lanes that are not shown to be free, except those that are hit.
  void Run(const float* values, std::size_t stride, UnresolvedTags* open) {
    open_ = open;
    std::fill_n(open_, width(), UnresolvedTags{});
    Forget(known_.worlds, open_worlds_);
    Forget(known_.pairs, open_pairs_);
    hit_ = hn::FirstN(kTag, 0);
    for (std::size_t k = 1; k < program_.joints.size(); ++k) {
      const LaneJoint& joint = program_.joints[k];
      StoreFrame(k, ChildFrame(LoadFrame(joint.parent), joint,
                               hn::LoadU(kTag, values + (k - 1) * stride)));
    }
    // Groups of the root frame do not move and stay placed.
    for (std::size_t g = 0; g < program_.groups.size(); ++g) {
      const LaneGroup& group = program_.groups[g];
      if (group.frame == 0) continue;
      group_placed_[g] = 0;
      std::fill_n(placed_ + group.first, group.count, 0);
      StorePoint(groups_, g, LoadFrame(group.frame).Place(group.bound.centre_m));
    }
    for (const LaneGroupPair& pair : program_.group_pairs) CheckSelf(pair);
    for (std::size_t g = 0; g < program_.groups.size() && !IsDone(); ++g) CheckWorld(g);
  }

  void WriteVerdicts(std::size_t count, LaneVerdict* verdicts) const {
    std::uint8_t hit[8] = {};
    hn::StoreMaskBits(kTag, hit_, hit);
    const unsigned hits = hit[0] | unsigned{hit[1]} << 8;
    for (std::size_t i = 0; i < count; ++i) {
      const bool is_open = (open_[i].worlds | open_[i].pairs) != 0;
      verdicts[i] = (hits >> i & 1) != 0 ? LaneVerdict::kHit
                    : is_open            ? LaneVerdict::kUnresolved
                                         : LaneVerdict::kFree;
    }
  }

  // Constant on most instruction sets, so that offsets computed from it fold into addresses.
  static std::size_t width() { return hn::Lanes(kTag); }

 private:
  Frame LoadFrame(std::int32_t index) const {
    const float* from = frames_ + static_cast<std::size_t>(index) * 12 * width();
    Frame frame;
    for (std::size_t k = 0; k < 12; ++k) frame.of[k] = hn::Load(kTag, from + k * width());
    return frame;
  }
  void StoreFrame(std::size_t index, const Frame& frame) {
    float* to = frames_ + index * 12 * width();
    for (std::size_t k = 0; k < 12; ++k) hn::Store(frame.of[k], kTag, to + k * width());
  }
  Point LoadPoint(const float* from, std::size_t index) const {
    from += index * 3 * width();
    return {hn::Load(kTag, from), hn::Load(kTag, from + width()),
            hn::Load(kTag, from + 2 * width())};
  }
  void StorePoint(float* to, std::size_t index, const Point& point) const {
    to += index * 3 * width();
    hn::Store(point.x, kTag, to);
    hn::Store(point.y, kTag, to + width());
    hn::Store(point.z, kTag, to + 2 * width());
  }

  void PlaceBounds(std::size_t g) {
    if (group_placed_[g] != 0) return;
    group_placed_[g] = 1;
    const LaneGroup& group = program_.groups[g];
    const Frame frame = LoadFrame(group.frame);
    for (std::int32_t c = group.first; c < group.first + group.count; ++c) {
      const auto at = static_cast<std::size_t>(c);
      StorePoint(bounds_, at, frame.Place(program_.clusters[at].bound.centre_m));
    }
  }
  void PlaceSpheres(std::size_t c) {
    if (placed_[c] != 0) return;
    placed_[c] = 1;
    const LaneCluster& cluster = program_.clusters[c];
    const Frame frame = LoadFrame(cluster.frame);
    for (std::int32_t s = cluster.first; s < cluster.first + cluster.count; ++s) {
      const auto at = static_cast<std::size_t>(s);
      StorePoint(centres_, at, frame.Place(program_.spheres[at].centre_m));
    }
  }

  bool IsDone() const { return hn::AllTrue(kTag, hit_); }
  // True if some lane that is not in `done` may be in contact.
  static bool Matters(Lane beyond, float band_m2, LaneMask done) {
    return !hn::AllFalse(kTag, hn::AndNot(done, hn::Lt(beyond, All(band_m2))));
  }

  // Lanes that are open for some tag, by tag, and the tags for which there are any.
  using OpenLanes = LaneMask[kTags];
  static void Forget(std::uint64_t& tags, OpenLanes& lanes) {
    for (; tags != 0; tags &= tags - 1) lanes[std::countr_zero(tags)] = hn::FirstN(kTag, 0);
  }
  LaneMask Done(const OpenLanes& lanes, std::int32_t tag) const { return hn::Or(hit_, lanes[tag]); }

  // Records the lanes in contact, and those that may be.
  void Keep(Lane beyond, float band_m2, LaneProof proof, std::uint64_t UnresolvedTags::*what,
            OpenLanes& lanes, std::int32_t tag) {
    if (proof.of_contact) hit_ = hn::Or(hit_, hn::Lt(beyond, All(-band_m2)));
    if (!proof.of_gap) return;
    const LaneMask open = hn::AndNot(Done(lanes, tag), hn::Lt(beyond, All(band_m2)));
    if (hn::AllFalse(kTag, open)) return;
    lanes[tag] = hn::Or(lanes[tag], open);
    known_.*what |= std::uint64_t{1} << tag;
    std::uint8_t some[8] = {};
    hn::StoreMaskBits(kTag, open, some);
    for (unsigned bits = some[0] | unsigned{some[1]} << 8; bits != 0; bits &= bits - 1) {
      open_[std::countr_zero(bits)].*what |= std::uint64_t{1} << tag;
    }
  }

  static Lane BeyondReach(const Point& a, const Point& b, float reach_m2) {
    const Lane x = hn::Sub(a.x, b.x), y = hn::Sub(a.y, b.y), z = hn::Sub(a.z, b.z);
    return hn::MulAdd(x, x, hn::MulAdd(y, y, hn::MulSub(z, z, All(reach_m2))));
  }

  void CheckSelf(const LaneGroupPair& pair) {
    const auto a = static_cast<std::size_t>(pair.first), b = static_cast<std::size_t>(pair.second);
    const Lane apart = BeyondReach(LoadPoint(groups_, a), LoadPoint(groups_, b), pair.reach_m2);
    if (!Matters(apart, pair.band.bounds_m2, hit_)) return;
    PlaceBounds(a);
    PlaceBounds(b);
    // Spheres that prove gaps only leave lanes open, which are skipped for further pairs of the tag.
    if (!program_.cluster_pairs[static_cast<std::size_t>(pair.begin)].proof.of_contact) {
      for (std::int32_t k = pair.begin; k < pair.end; ++k) {
        const LaneClusterPair& two = program_.cluster_pairs[static_cast<std::size_t>(k)];
        if (IsNear(two)) CheckSpheres(two);
      }
      return;
    }
    std::int32_t* end = near_;
    for (std::int32_t k = pair.begin; k < pair.end; ++k) {
      *end = k;
      end += IsNear(program_.cluster_pairs[static_cast<std::size_t>(k)]) ? 1 : 0;
    }
    for (const std::int32_t* k = near_; k < end; ++k) {
      CheckSpheres(program_.cluster_pairs[static_cast<std::size_t>(*k)]);
    }
  }

  bool IsNear(const LaneClusterPair& pair) const {
    const auto a = static_cast<std::size_t>(pair.first), b = static_cast<std::size_t>(pair.second);
    const Lane apart = BeyondReach(LoadPoint(bounds_, a), LoadPoint(bounds_, b), pair.reach_m2);
    return Matters(apart, pair.band.bounds_m2, Done(open_pairs_, pair.tag));
  }

  void CheckSpheres(const LaneClusterPair& pair) {
    if (hn::AllTrue(kTag, Done(open_pairs_, pair.tag))) return;
    PlaceSpheres(static_cast<std::size_t>(pair.first));
    PlaceSpheres(static_cast<std::size_t>(pair.second));
    const Lane lowest = pair.begin == pair.end ? LowestOfAll(pair) : LowestOfListed(pair);
    Keep(lowest, pair.band.spheres_m2, pair.proof, &UnresolvedTags::pairs, open_pairs_, pair.tag);
  }

  Lane LowestOfListed(const LaneClusterPair& pair) const {
    Lane lowest = All(1);
    for (std::int32_t k = pair.begin; k < pair.end; ++k) {
      const LaneSpherePair& two = program_.sphere_pairs[static_cast<std::size_t>(k)];
      lowest =
          hn::Min(lowest, BeyondReach(LoadPoint(centres_, static_cast<std::size_t>(two.first)),
                                      LoadPoint(centres_, static_cast<std::size_t>(two.second)),
                                      two.reach_m2));
    }
    return lowest;
  }

  Lane LowestOfAll(const LaneClusterPair& pair) const {
    const LaneCluster& one = program_.clusters[static_cast<std::size_t>(pair.first)];
    const LaneCluster& other = program_.clusters[static_cast<std::size_t>(pair.second)];
    Lane lowest = All(1);
    for (std::int32_t s = one.first; s < one.first + one.count; ++s) {
      const auto a = static_cast<std::size_t>(s);
      const Point at = LoadPoint(centres_, a);
      for (std::int32_t t = other.first; t < other.first + other.count; ++t) {
        const auto b = static_cast<std::size_t>(t);
        const float reach_m =
            program_.spheres[a].radius_m + program_.spheres[b].radius_m + pair.margin_m;
        lowest = hn::Min(lowest, BeyondReach(at, LoadPoint(centres_, b), reach_m * reach_m));
      }
    }
    return lowest;
  }

  void CheckWorld(std::size_t g) {
    const LaneScene::Range range = scene_.near_group[g];
    const LaneGroup& group = program_.groups[g];
    const Point bound = LoadPoint(groups_, g);
    std::int32_t* end = near_;
    for (std::int32_t k = range.begin; k < range.end; ++k) {
      const std::int32_t o = scene_.near[static_cast<std::size_t>(k)];
      const LaneObstacle& obstacle = scene_.obstacles[static_cast<std::size_t>(o)];
      const Lane beyond = Beyond(obstacle, bound, All(group.bound.radius_m + obstacle.margin_m));
      *end = o;
      end += Matters(beyond, range.band.bounds_m2, hit_) ? 1 : 0;
    }
    for (const std::int32_t* o = near_; o < end; ++o) {
      CheckObstacle(g, scene_.obstacles[static_cast<std::size_t>(*o)], range.band);
    }
  }

  void CheckObstacle(std::size_t g, const LaneObstacle& obstacle, const LaneBand& band) {
    PlaceBounds(g);
    const LaneGroup& group = program_.groups[g];
    for (std::int32_t c = group.first; c < group.first + group.count; ++c) {
      const auto at = static_cast<std::size_t>(c);
      const LaneCluster& cluster = program_.clusters[at];
      const Lane reach = All(cluster.bound.radius_m + obstacle.margin_m);
      const LaneProof proof = cluster.proof.With(obstacle.is_hull);
      if (!proof.of_gap && !proof.of_contact) continue;
      if (!Matters(Beyond(obstacle, LoadPoint(bounds_, at), reach), band.bounds_m2,
                   Done(open_worlds_, cluster.tag))) {
        continue;
      }
      PlaceSpheres(at);
      Keep(Lowest(obstacle, cluster), band.spheres_m2, proof, &UnresolvedTags::worlds, open_worlds_,
           cluster.tag);
    }
  }

  static Lane Beyond(const LaneObstacle& obstacle, const Point& p, Lane reach) {
    return ForForm(obstacle, [&]<LaneObstacle::Form kForm, bool kIsAligned>() HWY_ATTR {
      return LaneSolid(obstacle).Beyond<kForm, kIsAligned>(p, reach);
    });
  }

  Lane Lowest(const LaneObstacle& obstacle, const LaneCluster& cluster) const {
    return ForForm(obstacle, [&]<LaneObstacle::Form kForm, bool kIsAligned>() HWY_ATTR {
      const LaneSolid solid(obstacle);
      Lane lowest = All(1);
      for (std::int32_t s = cluster.first; s < cluster.first + cluster.count; ++s) {
        const auto at = static_cast<std::size_t>(s);
        const Lane reach = All(program_.spheres[at].radius_m + obstacle.margin_m);
        lowest = hn::Min(lowest, solid.Beyond<kForm, kIsAligned>(LoadPoint(centres_, at), reach));
      }
      return lowest;
    });
  }

  const LaneProgram& program_;
  const LaneScene& scene_;
  float* frames_ = nullptr;               // twelve vectors per frame
  float* centres_ = nullptr;              // three vectors per sphere, for placed clusters
  float* bounds_ = nullptr;               // three vectors per cluster
  float* groups_ = nullptr;               // three vectors per group
  std::int32_t* placed_ = nullptr;        // by cluster: true if its spheres are placed
  std::int32_t* near_ = nullptr;          // candidates of a walk, collected without branches
  std::int32_t* group_placed_ = nullptr;  // by group: true if its clusters' bounds are placed
  LaneMask hit_;
  UnresolvedTags* open_ = nullptr;  // by lane
  UnresolvedTags known_;            // tags that are open in some lane
  OpenLanes open_worlds_, open_pairs_;
};

void CheckAll(const LaneProgram& program, const LaneScene& scene, const float* values,
              std::size_t stride, std::size_t count, LaneMemory& memory, LaneVerdict* verdicts,
              UnresolvedTags* open) {
  StateChecker checker(program, scene, memory);
  UnresolvedTags found[kMaxLanes];
  for (std::size_t first = 0; first < count; first += checker.width()) {
    const std::size_t some = HWY_MIN(checker.width(), count - first);
    checker.Run(values + first, stride, found);
    checker.WriteVerdicts(some, verdicts + first);
    std::copy_n(found, some, open + first);
  }
}

void SinesOfAll(const float* angles, std::size_t count, float* sines, float* cosines) {
  alignas(64) float sine[kMaxLanes], cosine[kMaxLanes];
  for (std::size_t i = 0; i < count; ++i) {
    const LaneTurn<Lane> turn = TurnBy(All(angles[i]));
    hn::Store(turn.sine, kTag, sine);
    hn::Store(turn.cosine, kTag, cosine);
    sines[i] = sine[0];
    cosines[i] = cosine[0];
  }
}

const char* NameOfTarget() { return hwy::TargetName(HWY_TARGET); }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace cwm::collision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cwm::collision {

HWY_EXPORT(CheckAll);
HWY_EXPORT(SinesOfAll);
HWY_EXPORT(NameOfTarget);

void CheckStates(const LaneProgram& program, const LaneScene& scene, const float* values,
                 std::size_t stride, std::size_t count, LaneMemory& memory, LaneVerdict* verdicts,
                 UnresolvedTags* open) {
  HWY_DYNAMIC_DISPATCH(CheckAll)
  (program, scene, values, stride, count, memory, verdicts, open);
}

void LaneSines(const float* angles, std::size_t count, float* sines, float* cosines) {
  HWY_DYNAMIC_DISPATCH(SinesOfAll)(angles, count, sines, cosines);
}

const char* LaneTarget() { return HWY_DYNAMIC_DISPATCH(NameOfTarget)(); }

}  // namespace cwm::collision
#endif  // HWY_ONCE
