// Points, frames and solids of many states or instants at once, one per SIMD lane, in single
// precision. V is a vector of Highway's.
#if defined(CWM_LANE_GEOMETRY_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef CWM_LANE_GEOMETRY_INL_H
#undef CWM_LANE_GEOMETRY_INL_H
#else
#define CWM_LANE_GEOMETRY_INL_H
#endif

#include "collision/spheres/lane_program.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace cwm::collision {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <class V>
HWY_INLINE V All(float value) {
  return hn::Set(hn::DFromV<V>(), value);
}

template <class V>
struct LanePoint {
  V x, y, z;
};

template <class V>
HWY_INLINE V Dot(const LanePoint<V>& a, const LanePoint<V>& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}

template <class V>
HWY_INLINE LanePoint<V> Minus(const LanePoint<V>& a, const LanePoint<V>& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}

// start + a x b.
template <class V>
HWY_INLINE LanePoint<V> PlusCross(const LanePoint<V>& start, const LanePoint<V>& a,
                                  const LanePoint<V>& b) {
  return {hn::NegMulAdd(a.z, b.y, hn::MulAdd(a.y, b.z, start.x)),
          hn::NegMulAdd(a.x, b.z, hn::MulAdd(a.z, b.x, start.y)),
          hn::NegMulAdd(a.y, b.x, hn::MulAdd(a.x, b.y, start.z))};
}

// Row-major 3 x 4; the fourth column is the origin.
template <class V>
struct LaneFrame {
  V of[12];

  HWY_INLINE LanePoint<V> Place(const float* p) const {
    const V x = All<V>(p[0]), y = All<V>(p[1]), z = All<V>(p[2]);
    const auto row = [&](int k) HWY_ATTR {
      return hn::MulAdd(of[k], x, hn::MulAdd(of[k + 1], y, hn::MulAdd(of[k + 2], z, of[k + 3])));
    };
    return {row(0), row(4), row(8)};
  }
  HWY_INLINE LanePoint<V> AxisZ() const { return {of[2], of[6], of[10]}; }
  HWY_INLINE LanePoint<V> Origin() const { return {of[3], of[7], of[11]}; }
};

template <class V>
struct LaneTurn {
  V sine, cosine;
};

// Sine and cosine: Cody and Waite's reduction to [-pi/4, pi/4] with the constants of Cephes
// (Moshier), sinf and cosf.
template <class V>
HWY_INLINE LaneTurn<V> TurnBy(V angle) {
  const hn::DFromV<V> tag;
  const auto quadrant = hn::NearestInt(hn::Mul(angle, All<V>(0.636619772F)));
  const V turns = hn::ConvertTo(tag, quadrant);
  V x = hn::NegMulAdd(turns, All<V>(1.5703125F), angle);
  x = hn::NegMulAdd(turns, All<V>(4.837512969970703125e-4F), x);
  x = hn::NegMulAdd(turns, All<V>(7.54978995489188216e-8F), x);
  const V z = hn::Mul(x, x);
  V s = hn::MulAdd(z, All<V>(-1.9515295891e-4F), All<V>(8.3321608736e-3F));
  s = hn::MulAdd(s, z, All<V>(-1.6666654611e-1F));
  s = hn::MulAdd(hn::Mul(s, z), x, x);
  V c = hn::MulAdd(z, All<V>(2.443315711809948e-5F), All<V>(-1.388731625493765e-3F));
  c = hn::MulAdd(c, z, All<V>(4.166664568298827e-2F));
  c = hn::MulAdd(hn::Mul(c, z), z, hn::NegMulAdd(z, All<V>(0.5F), All<V>(1.0F)));
  const hn::RebindToSigned<hn::DFromV<V>> whole;
  const auto one = hn::Set(whole, 1), two = hn::Set(whole, 2);
  const auto odd = hn::RebindMask(tag, hn::TestBit(quadrant, one));
  const auto sign_of = [&](auto in) HWY_ATTR {
    return hn::BitCast(hn::DFromV<V>(), hn::ShiftLeft<30>(hn::And(in, two)));
  };
  return {hn::Xor(hn::IfThenElse(odd, c, s), sign_of(quadrant)),
          hn::Xor(hn::IfThenElse(odd, s, c), sign_of(hn::Add(quadrant, one)))};
}

// The same in double precision, to some 1e-15 for a few turns, by Cephes' sin and cos (Moshier).
template <class V>
HWY_INLINE LaneTurn<V> TurnExactlyBy(V angle) {
  const hn::DFromV<V> tag;
  const auto same = [&](double number) HWY_ATTR { return hn::Set(tag, number); };
  const V turns = hn::Round(hn::Mul(angle, same(0.63661977236758134)));
  V x = hn::NegMulAdd(turns, same(1.5707963267948966), angle);
  x = hn::NegMulAdd(turns, same(6.123233995736766e-17), x);
  const V z = hn::Mul(x, x);
  V s = hn::MulAdd(z, same(1.58962301576546568060e-10), same(-2.50507477628578072866e-8));
  s = hn::MulAdd(s, z, same(2.75573136213857245213e-6));
  s = hn::MulAdd(s, z, same(-1.98412698295895385996e-4));
  s = hn::MulAdd(s, z, same(8.33333333332211858878e-3));
  s = hn::MulAdd(s, z, same(-1.66666666666666307295e-1));
  s = hn::MulAdd(hn::Mul(s, z), x, x);
  V c = hn::MulAdd(z, same(-1.13585365213876817300e-11), same(2.08757008419747316778e-9));
  c = hn::MulAdd(c, z, same(-2.75573141792967388112e-7));
  c = hn::MulAdd(c, z, same(2.48015872888517045348e-5));
  c = hn::MulAdd(c, z, same(-1.38888888888730564116e-3));
  c = hn::MulAdd(c, z, same(4.16666666666665929218e-2));
  c = hn::MulAdd(hn::Mul(c, z), z, hn::NegMulAdd(z, same(0.5), same(1.0)));
  // The remainder of the number of quarter turns by 4, from -2 to 2.
  const V four = same(4.0);
  const V quadrant = hn::NegMulAdd(hn::Round(hn::Div(turns, four)), four, turns);
  const auto odd = hn::Eq(hn::Abs(quadrant), same(1.0));
  const V sine = hn::IfThenElse(odd, c, s), cosine = hn::IfThenElse(odd, s, c);
  const auto half = hn::Eq(hn::Abs(quadrant), same(2.0));
  const auto turns_back = hn::Eq(quadrant, same(-1.0)), turns_on = hn::Eq(quadrant, same(1.0));
  return {hn::IfThenElse(hn::Or(half, turns_back), hn::Neg(sine), sine),
          hn::IfThenElse(hn::Or(half, turns_on), hn::Neg(cosine), cosine)};
}

template <class V>
HWY_INLINE LaneFrame<V> ChildFrame(const LaneFrame<V>& parent, const LaneJoint& joint, V value) {
  LaneFrame<V> now;
  const float* r = joint.rotation;
  const LaneTurn<V> turn = joint.turns ? TurnBy(value) : LaneTurn<V>{value, value};
  for (int row = 0; row < 12; row += 4) {
    const V a = parent.of[row], b = parent.of[row + 1], c = parent.of[row + 2];
    const auto times = [&](float u, float v, float w, V start) HWY_ATTR {
      return hn::MulAdd(a, All<V>(u), hn::MulAdd(b, All<V>(v), hn::MulAdd(c, All<V>(w), start)));
    };
    const V x = times(r[0], r[3], r[6], hn::Zero(hn::DFromV<V>()));
    const V y = times(r[1], r[4], r[7], hn::Zero(hn::DFromV<V>()));
    const V z = times(r[2], r[5], r[8], hn::Zero(hn::DFromV<V>()));
    V at = times(joint.shift_m[0], joint.shift_m[1], joint.shift_m[2], parent.of[row + 3]);
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

// The frame below a joint, in double precision.
template <class V>
HWY_INLINE LaneFrame<V> ExactChildFrame(const LaneFrame<V>& parent, const LaneJoint& joint,
                                        V value) {
  const hn::DFromV<V> tag;
  const auto same = [&](double number) HWY_ATTR { return hn::Set(tag, number); };
  const double *const r = joint.exact_rotation, *const p = joint.exact_shift_m;
  LaneTurn<V> turn{value, value};
  if (joint.turns) turn = TurnExactlyBy(value);
  LaneFrame<V> now;
  for (int row = 0; row < 12; row += 4) {
    const V a = parent.of[row], b = parent.of[row + 1], c = parent.of[row + 2];
    const auto times = [&](double u, double v, double w, V start) HWY_ATTR {
      return hn::MulAdd(a, same(u), hn::MulAdd(b, same(v), hn::MulAdd(c, same(w), start)));
    };
    const V x = times(r[0], r[3], r[6], hn::Zero(tag));
    const V y = times(r[1], r[4], r[7], hn::Zero(tag));
    const V z = times(r[2], r[5], r[8], hn::Zero(tag));
    const V at = times(p[0], p[1], p[2], parent.of[row + 3]);
    now.of[row + 2] = z;
    if (joint.turns) {
      now.of[row] = hn::MulAdd(x, turn.cosine, hn::Mul(y, turn.sine));
      now.of[row + 1] = hn::NegMulAdd(x, turn.sine, hn::Mul(y, turn.cosine));
      now.of[row + 3] = at;
    } else {
      now.of[row] = x;
      now.of[row + 1] = y;
      now.of[row + 3] = hn::MulAdd(z, value, at);
    }
  }
  return now;
}

// A point's offset from the nearest point of a solid's core: from a box, a cylinder or a half-space
// itself, from the centre line of a round solid, whose radius is `grown_m`. Zero inside the core.
template <class V>
struct LaneOffset {
  V squared_m2;
  LanePoint<V> local;  // in the axes of the solid
  float grown_m = 0;
};

// Places points relative to a solid.
class LaneSolid {
 public:
  explicit LaneSolid(const LaneObstacle& from) : from_(from) {}

  // The squared distance of a point from the solid, 0 inside, minus a squared reach.
  template <LaneObstacle::Form kForm, bool kIsAligned, class V>
  HWY_INLINE V Beyond(const LanePoint<V>& p, V reach) const {
    using Form = LaneObstacle::Form;
    const V zero = hn::Zero(hn::DFromV<V>());
    const V w = At<kIsAligned>(2, p);
    if constexpr (kForm == Form::kHalfSpace) {
      const V out = hn::Max(w, zero);
      return hn::MulSub(out, out, hn::Mul(reach, reach));
    }
    const V u = At<kIsAligned>(0, p), v = At<kIsAligned>(1, p);
    if constexpr (kForm == Form::kBox) {
      const V out_u = Out(u, 0), out_v = Out(v, 1), out_w = Out(w, 2);
      return hn::MulAdd(out_u, out_u,
                        hn::MulAdd(out_v, out_v, hn::MulSub(out_w, out_w, hn::Mul(reach, reach))));
    }
    const V across = hn::MulAdd(u, u, hn::Mul(v, v));
    const V out_w = Out(w, 1);
    if constexpr (kForm == Form::kRound) {
      const V all = hn::Add(reach, All<V>(from_.size_m[0]));
      return hn::MulAdd(out_w, out_w, hn::NegMulAdd(all, all, across));
    }
    const V out = hn::Max(hn::Sub(hn::Sqrt(across), All<V>(from_.size_m[0])), zero);
    return hn::MulAdd(out, out, hn::MulSub(out_w, out_w, hn::Mul(reach, reach)));
  }

  template <LaneObstacle::Form kForm, bool kIsAligned, class V>
  HWY_INLINE LaneOffset<V> OffsetOf(const LanePoint<V>& p) const {
    using Form = LaneObstacle::Form;
    const V zero = hn::Zero(hn::DFromV<V>());
    const V w = At<kIsAligned>(2, p);
    if constexpr (kForm == Form::kHalfSpace) {
      const V out = hn::Max(w, zero);
      return {hn::Mul(out, out), {zero, zero, out}, 0};
    }
    const V u = At<kIsAligned>(0, p), v = At<kIsAligned>(1, p);
    LanePoint<V> local{u, v, zero};
    if constexpr (kForm == Form::kBox) {
      local = {hn::CopySign(Out(u, 0), u), hn::CopySign(Out(v, 1), v), hn::CopySign(Out(w, 2), w)};
      return {Dot(local, local), local, 0};
    }
    local.z = hn::CopySign(Out(w, 1), w);
    if constexpr (kForm == Form::kRound) return {Dot(local, local), local, from_.size_m[0]};
    const V across = hn::Sqrt(hn::MulAdd(u, u, hn::Mul(v, v)));
    const V out = hn::Max(hn::Sub(across, All<V>(from_.size_m[0])), zero);
    // Where `out` is 0 so is the share, whatever the distance from the axis.
    const V share = hn::Div(out, hn::Max(across, All<V>(1e-12F)));
    local.x = hn::Mul(u, share);
    local.y = hn::Mul(v, share);
    return {hn::MulAdd(out, out, hn::Mul(local.z, local.z)), local, 0};
  }

  // The scalar product of an offset and a vector in the frame of the points.
  template <bool kIsAligned, class V>
  HWY_INLINE V Along(const LanePoint<V>& local, const LanePoint<V>& vector) const {
    if constexpr (kIsAligned) return Dot(local, vector);
    const auto turned = [&](std::size_t k) HWY_ATTR {
      const float* a = &from_.axis[3 * k];
      return hn::MulAdd(vector.x, All<V>(a[0]),
                        hn::MulAdd(vector.y, All<V>(a[1]), hn::Mul(vector.z, All<V>(a[2]))));
    };
    return Dot(local, {turned(0), turned(1), turned(2)});
  }

 private:
  template <bool kIsAligned, class V>
  HWY_INLINE V At(std::size_t k, const LanePoint<V>& p) const {
    const V offset = All<V>(from_.offset_m[k]);
    if constexpr (kIsAligned) return hn::Sub(k == 0 ? p.x : k == 1 ? p.y : p.z, offset);
    const float* a = &from_.axis[3 * k];
    return hn::MulAdd(p.x, All<V>(a[0]),
                      hn::MulAdd(p.y, All<V>(a[1]), hn::MulSub(p.z, All<V>(a[2]), offset)));
  }
  // How far a coordinate lies outside the solid.
  template <class V>
  HWY_INLINE V Out(V coordinate, std::size_t size) const {
    return hn::Max(hn::Sub(hn::Abs(coordinate), All<V>(from_.size_m[size])),
                   hn::Zero(hn::DFromV<V>()));
  }

  const LaneObstacle& from_;
};

// Calls `find`, instantiated for a form of obstacle and its alignment.
template <bool kIsAligned, typename Find>
HWY_INLINE auto ForForm(LaneObstacle::Form form, const Find& find) {
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
template <typename Find>
HWY_INLINE auto ForForm(const LaneObstacle& obstacle, const Find& find) {
  return obstacle.is_aligned ? ForForm<true>(obstacle.form, find)
                             : ForForm<false>(obstacle.form, find);
}

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace HWY_NAMESPACE
}  // namespace cwm::collision
HWY_AFTER_NAMESPACE();

#endif  // CWM_LANE_GEOMETRY_INL_H
