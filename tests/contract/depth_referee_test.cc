// The depth of overlapping convex pairs against libccd's own EPA, called directly: no engine of ours
// measures overlaps but by the exact kernels, so that only a library that shares no code can referee.
#include <ccd/ccd.h>
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "collision/geometry/support.h"
#include "tests/contract/catalogue.h"
#include "tests/contract/oracle.h"

namespace cwm::collision {
namespace {

constexpr int kPlacements = 100;

// Where libccd's polytope stops growing.
constexpr double kEpaTolerance_m = 1e-6;

constexpr double kExact_m = 1e-7;  // what kExact means

// A bracket of libccd's that is narrower than a hundredth of the shapes tells something. On round
// shapes its polytope now and then stops growing early; so rarely that nine in ten are narrow.
constexpr double kNarrow_m = 1e-3;
constexpr double kNarrowShare = 0.9;

// A placed shape as libccd sees it: a support function in the world.
struct Body {
  const Shape& shape;
  Pose X_WS;
};

struct SupportOf {
  Vector3 d;
  Vector3 operator()(const Sphere& s) const { return s.radius_m * d.normalized(); }
  Vector3 operator()(const Box& s) const { return SupportPoint(s, d); }
  Vector3 operator()(const Cylinder& s) const { return SupportPoint(s, d); }
  Vector3 operator()(const Cone& s) const { return SupportPoint(s, d); }
  Vector3 operator()(const Capsule& s) const {
    return Vector3(0, 0, std::copysign(s.length_m / 2, d.z())) + s.radius_m * d.normalized();
  }
  Vector3 operator()(const Convex& s) const { return SupportPoint(s.hull->vertices, d); }
  Vector3 operator()(const HalfSpace&) const { return Vector3::Zero(); }
  Vector3 operator()(const Plate&) const { return Vector3::Zero(); }
  Vector3 operator()(const Mesh&) const { return Vector3::Zero(); }
};

void Support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* point) {
  const Body& body = *static_cast<const Body*>(object);
  const Vector3 d_W(direction->v[0], direction->v[1], direction->v[2]);
  const Vector3 p =
      body.X_WS * std::visit(SupportOf{body.X_WS.linear().transpose() * d_W}, body.shape);
  ccdVec3Set(point, p.x(), p.y(), p.z());
}

struct Depth {
  double depth_m;
  Vector3 normal_W;  // unit, from A to B
};
std::optional<Depth> AskLibccd(const Body& a, const Body& b) {
  ccd_t ccd;
  CCD_INIT(&ccd);
  ccd.support1 = ccd.support2 = Support;
  ccd.max_iterations = 500;
  ccd.epa_tolerance = kEpaTolerance_m;
  ccd_real_t depth = 0;
  ccd_vec3_t direction, point;
  if (ccdGJKPenetration(&a, &b, &ccd, &depth, &direction, &point) != 0) return std::nullopt;
  const Vector3 d(direction.v[0], direction.v[1], direction.v[2]);
  if (!(std::abs(d.norm() - 1) < 1e-6)) return std::nullopt;
  return Depth{depth, d};
}

using Case = std::tuple<int, int>;  // places in the catalogue
class DepthReferee : public testing::TestWithParam<Case> {};

TEST_P(DepthReferee, LibccdBracketsTheLeastTranslation) {
  const Shape& a = Catalogue()[std::get<0>(GetParam())].shape;
  const Shape& b = Catalogue()[std::get<1>(GetParam())].shape;
  if (!HasExtent(a) || !HasExtent(b)) GTEST_SKIP() << "not convex, or unbounded";
  const double reach_m = 0.7 * (Catalogue()[std::get<0>(GetParam())].size_m +
                                Catalogue()[std::get<1>(GetParam())].size_m);
  const Engine& exact = GetEngine(EngineKind::kExact);
  std::mt19937 random(50);
  int overlapping = 0, answered = 0, narrow = 0;
  for (int i = 0; i < kPlacements; ++i) {
    const PlacedShape ours_a = Place(exact, a, RandomPose(random, 0.3));
    Pose X_WB = RandomPose(random, reach_m);
    X_WB.translation() += ours_a.X_WS.translation();
    const PlacedShape ours_b = Place(exact, b, X_WB);
    const PairDistance ours = exact.Distance(ours_a.get(), ours_b.get(), 1e3);
    if (ours.distance_m > -1e-4) continue;  // libccd's GJK is not to be trusted near touching
    ++overlapping;
    const std::optional<Depth> theirs = AskLibccd({a, ours_a.X_WS}, {b, ours_b.X_WS});
    if (!theirs.has_value()) continue;
    ++answered;
    // Along its own direction the pair truly parts by this much: no least translation is more. The
    // polytope that it grows lies inside of the difference of the shapes: none is less than its depth.
    const double parting_m = std::min(-Gap_m(a, ours_a.X_WS, b, X_WB, theirs->normal_W),
                                      -Gap_m(a, ours_a.X_WS, b, X_WB, -theirs->normal_W));
    EXPECT_LE(-ours.distance_m, parting_m + kExact_m) << i;
    EXPECT_GE(-ours.distance_m + ours.bound_m, theirs->depth_m - kEpaTolerance_m) << i;
    if (parting_m - theirs->depth_m <= kNarrow_m) ++narrow;
  }
  ASSERT_GE(overlapping, 10);
  EXPECT_GE(answered, 0.9 * overlapping);
  EXPECT_GE(narrow, kNarrowShare * answered);
}

INSTANTIATE_TEST_SUITE_P(AllPairs, DepthReferee,
                         testing::Combine(testing::Range(0, 12), testing::Range(0, 12)),
                         [](const testing::TestParamInfo<Case>& info) {
                           return Catalogue()[std::get<0>(info.param)].name +
                                  Catalogue()[std::get<1>(info.param)].name;
                         });

}  // namespace
}  // namespace cwm::collision
