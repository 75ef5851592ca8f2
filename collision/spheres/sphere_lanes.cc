#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/spheres/sphere_lanes.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each instruction set
//
#include <algorithm>
#include <bit>

#include "collision/spheres/sphere_lanes.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace cwm::collision {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, kMaxLanes>;
using Lane = hn::Vec<Tag>;
using LaneMask = hn::Mask<Tag>;
constexpr Tag kTag;

Lane All(float value) { return hn::Set(kTag, value); }

struct Point {
  Lane x, y, z;
};

// Row-major 3 x 4; the fourth column is the origin.
struct Frame {
  Lane of[12];

  Point Place(const float* p) const {
    const Lane x = All(p[0]), y = All(p[1]), z = All(p[2]);
    const auto row = [&](int k) HWY_ATTR {
      return hn::MulAdd(of[k], x, hn::MulAdd(of[k + 1], y, hn::MulAdd(of[k + 2], z, of[k + 3])));
    };
    return {row(0), row(4), row(8)};
  }
};

struct Turn {
  Lane sine, cosine;
};

// Sine and cosine: Cody and Waite's reduction to [-pi/4, pi/4] with the constants of Cephes
// (Moshier), sinf and cosf.
Turn TurnBy(Lane angle) {
  const auto quadrant = hn::NearestInt(hn::Mul(angle, All(0.636619772F)));
  const Lane turns = hn::ConvertTo(kTag, quadrant);
  Lane x = hn::NegMulAdd(turns, All(1.5703125F), angle);
  x = hn::NegMulAdd(turns, All(4.837512969970703125e-4F), x);
  x = hn::NegMulAdd(turns, All(7.54978995489188216e-8F), x);
  const Lane z = hn::Mul(x, x);
  Lane s = hn::MulAdd(z, All(-1.9515295891e-4F), All(8.3321608736e-3F));
  s = hn::MulAdd(s, z, All(-1.6666654611e-1F));
  s = hn::MulAdd(hn::Mul(s, z), x, x);
  Lane c = hn::MulAdd(z, All(2.443315711809948e-5F), All(-1.388731625493765e-3F));
  c = hn::MulAdd(c, z, All(4.166664568298827e-2F));
  c = hn::MulAdd(hn::Mul(c, z), z, hn::NegMulAdd(z, All(0.5F), All(1.0F)));
  const hn::RebindToSigned<Tag> whole;
  const auto one = hn::Set(whole, 1), two = hn::Set(whole, 2);
  const LaneMask odd = hn::RebindMask(kTag, hn::TestBit(quadrant, one));
  const auto sign_of = [&](auto in) HWY_ATTR {
    return hn::BitCast(kTag, hn::ShiftLeft<30>(hn::And(in, two)));
  };
  return {hn::Xor(hn::IfThenElse(odd, c, s), sign_of(quadrant)),
          hn::Xor(hn::IfThenElse(odd, s, c), sign_of(hn::Add(quadrant, one)))};
}

Frame ChildFrame(const Frame& parent, const LaneJoint& joint, Lane value) {
  Frame now;
  const float* r = joint.rotation;
  const Turn turn = joint.turns ? TurnBy(value) : Turn{value, value};
  for (int row = 0; row < 12; row += 4) {
    const Lane a = parent.of[row], b = parent.of[row + 1], c = parent.of[row + 2];
    const auto times = [&](float u, float v, float w, Lane start) HWY_ATTR {
      return hn::MulAdd(a, All(u), hn::MulAdd(b, All(v), hn::MulAdd(c, All(w), start)));
    };
    const Lane x = times(r[0], r[3], r[6], hn::Zero(kTag));
    const Lane y = times(r[1], r[4], r[7], hn::Zero(kTag));
    const Lane z = times(r[2], r[5], r[8], hn::Zero(kTag));
    Lane at = times(joint.shift_m[0], joint.shift_m[1], joint.shift_m[2], parent.of[row + 3]);
    if (joint.turns) {
      now.of[row] = hn::MulAdd(x, turn.cosine, hn::Mul(y, turn.sine));
      now.of[row + 1] = hn::NegMulAdd(x, turn.sine, hn::Mul(y, turn.cosine));
    } else {
      now.of[row] = x;
      now.of[row + 1] = y;
      at = hn::MulAdd(z, value, at);
    }
    now.of[row + 2] = z;
    now.of[row + 3] = at;
  }
  return now;
}

// Computes the squared distance of points from a solid, 0 inside, minus a squared reach.
class Solid {
 public:
  explicit Solid(const LaneObstacle& from) : from_(from) {}

  template <LaneObstacle::Form kForm, bool kIsAligned>
  Lane Beyond(const Point& p, Lane reach) const {
    const Lane zero = hn::Zero(kTag);
    const auto along = [&](int k, Lane coordinate) HWY_ATTR {
      return kIsAligned ? hn::Sub(coordinate, All(from_.offset_m[k])) : Along(k, p);
    };
    const Lane w = along(2, p.z);
    if constexpr (kForm == LaneObstacle::Form::kHalfSpace) {
      const Lane out = hn::Max(w, zero);
      return hn::MulSub(out, out, hn::Mul(reach, reach));
    }
    const Lane u = along(0, p.x), v = along(1, p.y);
    if constexpr (kForm == LaneObstacle::Form::kBox) {
      const Lane out_u = hn::Max(hn::Sub(hn::Abs(u), Size(0)), zero);
      const Lane out_v = hn::Max(hn::Sub(hn::Abs(v), Size(1)), zero);
      const Lane out_w = hn::Max(hn::Sub(hn::Abs(w), Size(2)), zero);
      return hn::MulAdd(out_u, out_u,
                        hn::MulAdd(out_v, out_v, hn::MulSub(out_w, out_w, hn::Mul(reach, reach))));
    }
    const Lane across = hn::MulAdd(u, u, hn::Mul(v, v));
    const Lane out_w = hn::Max(hn::Sub(hn::Abs(w), Size(1)), zero);
    if constexpr (kForm == LaneObstacle::Form::kRound) {
      const Lane all = hn::Add(reach, Size(0));
      return hn::MulAdd(out_w, out_w, hn::NegMulAdd(all, all, across));
    }
    const Lane out = hn::Max(hn::Sub(hn::Sqrt(across), Size(0)), zero);
    return hn::MulAdd(out, out, hn::MulSub(out_w, out_w, hn::Mul(reach, reach)));
  }

 private:
  Lane Size(int k) const { return All(from_.size_m[k]); }
  Lane Along(std::size_t k, const Point& p) const {
    const float* a = &from_.axis[3 * k];
    return hn::MulAdd(
        p.x, All(a[0]),
        hn::MulAdd(p.y, All(a[1]), hn::MulSub(p.z, All(a[2]), All(from_.offset_m[k]))));
  }

  const LaneObstacle& from_;
};

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
    for (std::size_t g = 0; g < program.groups.size(); ++g) {
      const LaneGroup& group = program.groups[g];
      if (group.frame == 0) StorePoint(groups_, g, LoadFrame(0).Place(group.bound.centre_m));
    }
  }

  void Run(const float* values, std::size_t stride) {
    hit_ = open_ = hn::FirstN(kTag, 0);
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

  void Find(const float* values, std::size_t stride, UnresolvedTags* found) {
    std::fill_n(found, width(), UnresolvedTags{});
    found_ = found;
    std::fill_n(worlds_, kTags, hn::FirstN(kTag, 0));
    std::fill_n(pairs_, kTags, hn::FirstN(kTag, 0));
    Run(values, stride);
  }

  void WriteVerdicts(std::size_t count, LaneVerdict* verdicts) const {
    alignas(64) float result[kMaxLanes] = {};
    const auto as = [](LaneVerdict verdict) HWY_ATTR { return All(static_cast<float>(verdict)); };
    hn::Store(
        hn::IfThenElse(hit_, as(LaneVerdict::kHit),
                       hn::IfThenElse(open_, as(LaneVerdict::kUnresolved), as(LaneVerdict::kFree))),
        kTag, result);
    for (std::size_t i = 0; i < count; ++i) verdicts[i] = static_cast<LaneVerdict>(result[i]);
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
  bool Matters(Lane beyond, float band_m2) const { return Matters(beyond, band_m2, hit_); }
  static bool Matters(Lane beyond, float band_m2, LaneMask done) {
    return !hn::AllFalse(kTag, hn::AndNot(done, hn::Lt(beyond, All(band_m2))));
  }
  void Keep(Lane beyond, float band_m2, bool is_hull) {
    open_ = hn::Or(open_, hn::Lt(beyond, All(band_m2)));
    if (!is_hull) hit_ = hn::Or(hit_, hn::Lt(beyond, All(-band_m2)));
  }
  // Records the open lanes for a tag, each of them once; `known` has the lanes recorded before.
  void Note(Lane beyond, float band_m2, std::uint64_t UnresolvedTags::*what, std::int32_t tag,
            LaneMask& known) {
    const LaneMask open = hn::AndNot(known, hn::Lt(beyond, All(band_m2)));
    if (hn::AllFalse(kTag, open)) return;
    known = hn::Or(known, open);
    std::uint8_t some[8] = {};
    hn::StoreMaskBits(kTag, open, some);
    for (unsigned bits = some[0] | unsigned{some[1]} << 8; bits != 0; bits &= bits - 1) {
      found_[std::countr_zero(bits)].*what |= std::uint64_t{1} << tag;
    }
  }

  static Lane BeyondReach(const Point& a, const Point& b, float reach_m2) {
    const Lane x = hn::Sub(a.x, b.x), y = hn::Sub(a.y, b.y), z = hn::Sub(a.z, b.z);
    return hn::MulAdd(x, x, hn::MulAdd(y, y, hn::MulSub(z, z, All(reach_m2))));
  }

  void CheckSelf(const LaneGroupPair& pair) {
    const auto a = static_cast<std::size_t>(pair.first), b = static_cast<std::size_t>(pair.second);
    const Lane apart = BeyondReach(LoadPoint(groups_, a), LoadPoint(groups_, b), pair.reach_m2);
    if (!Matters(apart, pair.bounds_m2)) return;
    PlaceBounds(a);
    PlaceBounds(b);
    if (found_ != nullptr) {  // lanes open for one pair are skipped for the next
      for (std::int32_t k = pair.begin; k < pair.end; ++k) {
        const LaneClusterPair& two = program_.cluster_pairs[static_cast<std::size_t>(k)];
        if (IsNear(two, pairs_[two.tag])) CheckSpheres(two);
      }
      return;
    }
    std::int32_t* end = near_;
    for (std::int32_t k = pair.begin; k < pair.end; ++k) {
      *end = k;
      end += IsNear(program_.cluster_pairs[static_cast<std::size_t>(k)], hit_) ? 1 : 0;
    }
    for (const std::int32_t* k = near_; k < end; ++k) {
      CheckSpheres(program_.cluster_pairs[static_cast<std::size_t>(*k)]);
    }
  }

  bool IsNear(const LaneClusterPair& pair, LaneMask done) const {
    const auto a = static_cast<std::size_t>(pair.first), b = static_cast<std::size_t>(pair.second);
    const Lane apart = BeyondReach(LoadPoint(bounds_, a), LoadPoint(bounds_, b), pair.reach_m2);
    return Matters(apart, pair.band.bounds_m2, done);
  }

  void CheckSpheres(const LaneClusterPair& pair) {
    PlaceSpheres(static_cast<std::size_t>(pair.first));
    PlaceSpheres(static_cast<std::size_t>(pair.second));
    if (pair.begin == pair.end) return CheckAllSpheres(pair);
    Lane lowest = All(1);
    for (std::int32_t k = pair.begin; k < pair.end; ++k) {
      const LaneSpherePair& two = program_.sphere_pairs[static_cast<std::size_t>(k)];
      lowest =
          hn::Min(lowest, BeyondReach(LoadPoint(centres_, static_cast<std::size_t>(two.first)),
                                      LoadPoint(centres_, static_cast<std::size_t>(two.second)),
                                      two.reach_m2));
    }
    Keep(lowest, pair.band.spheres_m2, false);
  }

  void CheckAllSpheres(const LaneClusterPair& pair) {
    const LaneCluster& one = program_.clusters[static_cast<std::size_t>(pair.first)];
    const LaneCluster& other = program_.clusters[static_cast<std::size_t>(pair.second)];
    Lane lowest = All(1);
    for (std::int32_t s = one.first; s < one.first + one.count; ++s) {
      const auto a = static_cast<std::size_t>(s);
      const Point at = LoadPoint(centres_, a);
      for (std::int32_t t = other.first; t < other.first + other.count; ++t) {
        const auto b = static_cast<std::size_t>(t);
        const float reach_m =
            program_.spheres[a].radius_m + program_.spheres[b].radius_m + program_.pair_margin_m;
        lowest = hn::Min(lowest, BeyondReach(at, LoadPoint(centres_, b), reach_m * reach_m));
      }
    }
    Note(lowest, pair.band.spheres_m2, &UnresolvedTags::pairs, pair.tag, pairs_[pair.tag]);
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
      end += Matters(beyond, range.band.bounds_m2) ? 1 : 0;
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
      const LaneMask done = found_ == nullptr ? hit_ : worlds_[cluster.tag];
      if (!Matters(Beyond(obstacle, LoadPoint(bounds_, at), reach), band.bounds_m2, done)) continue;
      PlaceSpheres(at);
      const Lane lowest = Lowest(obstacle, cluster);
      if (found_ == nullptr) {
        Keep(lowest, band.spheres_m2, obstacle.is_hull);
      } else {
        Note(lowest, band.spheres_m2, &UnresolvedTags::worlds, cluster.tag, worlds_[cluster.tag]);
      }
    }
  }

  static Lane Beyond(const LaneObstacle& obstacle, const Point& p, Lane reach) {
    return Dispatch(obstacle, [&]<LaneObstacle::Form kForm, bool kIsAligned>() HWY_ATTR {
      return Solid(obstacle).Beyond<kForm, kIsAligned>(p, reach);
    });
  }

  Lane Lowest(const LaneObstacle& obstacle, const LaneCluster& cluster) const {
    return Dispatch(obstacle, [&]<LaneObstacle::Form kForm, bool kIsAligned>() HWY_ATTR {
      const Solid solid(obstacle);
      Lane lowest = All(1);
      for (std::int32_t s = cluster.first; s < cluster.first + cluster.count; ++s) {
        const auto at = static_cast<std::size_t>(s);
        const Lane reach = All(program_.spheres[at].radius_m + obstacle.margin_m);
        lowest = hn::Min(lowest, solid.Beyond<kForm, kIsAligned>(LoadPoint(centres_, at), reach));
      }
      return lowest;
    });
  }

  // Calls `find`, instantiated for the obstacle's form and alignment.
  template <typename Find>
  static Lane Dispatch(const LaneObstacle& obstacle, const Find& find) {
    return obstacle.is_aligned ? Dispatch<true>(obstacle.form, find)
                               : Dispatch<false>(obstacle.form, find);
  }
  template <bool kIsAligned, typename Find>
  static Lane Dispatch(LaneObstacle::Form form, const Find& find) {
    using Form = LaneObstacle::Form;
    switch (form) {
      case Form::kRound:
        return find.template operator()<Form::kRound, kIsAligned>();
      case Form::kBox:
        return find.template operator()<Form::kBox, kIsAligned>();
      case Form::kCylinder:
        return find.template operator()<Form::kCylinder, kIsAligned>();
      case Form::kHalfSpace:
        break;
    }
    return find.template operator()<Form::kHalfSpace, kIsAligned>();
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
  LaneMask hit_, open_;
  UnresolvedTags* found_ = nullptr;        // by lane; null in Run, which computes verdicts only
  LaneMask worlds_[kTags], pairs_[kTags];  // lanes that were found open, by tag
};

void CheckAll(const LaneProgram& program, const LaneScene& scene, const float* values,
              std::size_t stride, std::size_t count, LaneMemory& memory, LaneVerdict* verdicts) {
  StateChecker checker(program, scene, memory);
  for (std::size_t first = 0; first < count; first += checker.width()) {
    checker.Run(values + first, stride);
    checker.WriteVerdicts(HWY_MIN(checker.width(), count - first), verdicts + first);
  }
}

void FindAll(const LaneProgram& program, const LaneScene& scene, const float* values,
             std::size_t stride, std::size_t count, LaneMemory& memory, UnresolvedTags* open) {
  StateChecker checker(program, scene, memory);
  UnresolvedTags found[kMaxLanes];
  for (std::size_t first = 0; first < count; first += checker.width()) {
    checker.Find(values + first, stride, found);
    std::copy_n(found, HWY_MIN(checker.width(), count - first), open + first);
  }
}

void SinesOfAll(const float* angles, std::size_t count, float* sines, float* cosines) {
  alignas(64) float sine[kMaxLanes], cosine[kMaxLanes];
  for (std::size_t i = 0; i < count; ++i) {
    const Turn turn = TurnBy(All(angles[i]));
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
HWY_EXPORT(FindAll);
HWY_EXPORT(SinesOfAll);
HWY_EXPORT(NameOfTarget);

void CheckStates(const LaneProgram& program, const LaneScene& scene, const float* values,
                 std::size_t stride, std::size_t count, LaneMemory& memory, LaneVerdict* verdicts) {
  HWY_DYNAMIC_DISPATCH(CheckAll)(program, scene, values, stride, count, memory, verdicts);
}

void FindUnresolved(const LaneProgram& program, const LaneScene& scene, const float* values,
                    std::size_t stride, std::size_t count, LaneMemory& memory,
                    UnresolvedTags* open) {
  HWY_DYNAMIC_DISPATCH(FindAll)(program, scene, values, stride, count, memory, open);
}

void LaneSines(const float* angles, std::size_t count, float* sines, float* cosines) {
  HWY_DYNAMIC_DISPATCH(SinesOfAll)(angles, count, sines, cosines);
}

const char* LaneTarget() { return HWY_DYNAMIC_DISPATCH(NameOfTarget)(); }

}  // namespace cwm::collision
#endif  // HWY_ONCE
