#include "collision/kernels/work_counter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "collision/kernels/contact_patch.h"
#include "collision/kernels/convex_pair.h"
#include "collision/kernels/exact_geometry.h"

namespace cwm::collision {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Ends the work after a number of steps, and counts the checks after that.
class EndsAfter : public WorkCounter {
 public:
  explicit EndsAfter(std::size_t steps) : left_(steps) {}

  bool MustEndAfter(std::size_t steps) override {
    counted_ += steps;
    max_at_once_ = std::max(max_at_once_, steps);
    if (counted_ >= left_) ++calls_after_end_;
    return counted_ >= left_;
  }
  bool MustEndNow() override { return MustEndAfter(0); }
  std::size_t counted() const { return counted_; }
  std::size_t max_at_once() const { return max_at_once_; }
  int calls_after_end() const { return calls_after_end_; }

 private:
  std::size_t left_;
  std::size_t counted_ = 0;
  std::size_t max_at_once_ = 0;
  int calls_after_end_ = 0;
};

constexpr std::size_t kNever = std::numeric_limits<std::size_t>::max();

// A closed ball of triangles, dented so that it is not convex, or round if `dent` is 0.
TriangleMesh DentedBall(int rings, double radius_m, double dent = 0.05) {
  TriangleMesh mesh;
  const int around = 2 * rings;
  for (int i = 0; i <= rings; ++i) {
    for (int k = 0; k < around; ++k) {
      const double polar = std::numbers::pi * i / rings;
      const double angle = 2 * std::numbers::pi * k / around;
      const double r = radius_m * (1 + dent * std::sin(6 * angle) * std::sin(4 * polar));
      mesh.vertices.push_back({r * std::sin(polar) * std::cos(angle),
                               r * std::sin(polar) * std::sin(angle), r * std::cos(polar)});
    }
  }
  for (int i = 0; i < rings; ++i) {
    for (int k = 0; k < around; ++k) {
      const auto at = [&](int ring, int place) {
        return static_cast<std::uint32_t>(ring * around + place % around);
      };
      mesh.triangles.push_back({at(i, k), at(i + 1, k), at(i + 1, k + 1)});
      mesh.triangles.push_back({at(i, k), at(i + 1, k + 1), at(i, k + 1)});
    }
  }
  return mesh;
}

Shape OpenBall(double radius_m) {
  return Mesh{std::make_shared<const TriangleMesh>(DentedBall(40, radius_m)), false};
}

// All its points are about equally far from the centre.
Shape OpenRoundBall() {
  return Mesh{std::make_shared<const TriangleMesh>(DentedBall(100, 0.5, 0)), false};
}

// A plate with several pieces per tooth.
Shape Comb(int teeth) {
  Plate comb{{{0, -0.1}, {1, -0.1}}, {}, 0.05};
  for (int i = teeth - 1; i >= 0; --i) {
    const double x = static_cast<double>(i) / teeth, step = 1.0 / teeth;
    comb.outline.insert(
        comb.outline.end(),
        {{x + step, 0}, {x + 0.8 * step, 0.5}, {x + 0.4 * step, 0.5}, {x + 0.2 * step, 0}});
  }
  return comb;
}

Shape ManyCorners(int count) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::vector<Vector3> points;
  for (int i = 0; i < count; ++i) {
    const Vector3 v{normal(random), normal(random), normal(random)};
    points.push_back(0.2 * v.normalized());
  }
  return Convex{std::make_shared<const TriangleMesh>(ConvexHull3(points))};
}

struct LongPair {
  std::string name;
  Shape a, b;
  Pose X_FB;
};

// Pairs that take thousands of steps each.
std::vector<LongPair> LongPairs() {
  const Pose turned = MakePose({0.05, 0.1, 0.02},
                               Quaternion(Eigen::AngleAxisd(0.3, Vector3(1, 2, 3).normalized())));
  return {{"surfaces", OpenBall(0.5), OpenBall(0.45), Pose::Identity()},
          {"surface and hull", OpenBall(0.5), ManyCorners(500), Pose::Identity()},
          // For a box, only triangles near its corners would be examined.
          {"surface and capsule", OpenRoundBall(), Capsule{0.1, 1e-3}, Pose::Identity()},
          {"surface and ball", OpenRoundBall(), Sphere{0.1}, Pose::Identity()},
          {"surface and plate", OpenBall(0.3), Comb(50), turned},
          {"plates", Comb(200), Comb(200), turned}};
}

using Kernel = std::function<void(const PlacedExact&, const PlacedExact&, WorkCounter*)>;
std::vector<Kernel> Kernels() {
  return {[](const PlacedExact& a, const PlacedExact& b, WorkCounter* work) {
            ExactDistance(a, b, kInfinity, work);
          },
          [](const PlacedExact& a, const PlacedExact& b, WorkCounter* work) {
            ExactOverlap(a, b, work);
          },
          [](const PlacedExact& a, const PlacedExact& b, WorkCounter* work) {
            std::vector<PairDistance> contacts;
            ExactContacts(a, b, {0.1, 16, work}, contacts);
          }};
}

// chosen: checks allowed after the end, to leave a loop within another and the next one.
constexpr int kMaxCallsAfterEnd = 8;
// derived: the clock is checked every 64 us, so no single step may count for many times that.
constexpr std::size_t kMaxAtOnce = 4096;

TEST(WorkCounter, EndsEverySearchAtOnceWhereverItIs) {
  for (const LongPair& pair : LongPairs()) {
    const auto a = PrepareExact(pair.a), b = PrepareExact(pair.b);
    const Pose X_FA = Pose::Identity();
    for (const Kernel& kernel : Kernels()) {
      EndsAfter never(kNever);
      kernel({*a, X_FA}, {*b, pair.X_FB}, &never);
      EXPECT_LE(never.max_at_once(), kMaxAtOnce) << pair.name;
      for (const double share : {0.0, 0.01, 0.5, 0.9}) {
        EndsAfter counter(1 +
                          static_cast<std::size_t>(share * static_cast<double>(never.counted())));
        kernel({*a, X_FA}, {*b, pair.X_FB}, &counter);
        EXPECT_LE(counter.calls_after_end(), kMaxCallsAfterEnd) << pair.name << " " << share;
      }
    }
  }
}

TEST(WorkCounter, SeesTheWorkOfLongSearches) {
  for (const LongPair& pair : LongPairs()) {
    const auto a = PrepareExact(pair.a), b = PrepareExact(pair.b);
    EndsAfter counter(kNever);
    ExactDistance({*a, Pose::Identity()}, {*b, pair.X_FB}, kInfinity, &counter);
    EXPECT_GT(counter.counted(), 10'000u) << pair.name;
  }
}

TEST(WorkCounter, ChangesNoAnswerWhileItLetsGoOn) {
  for (const LongPair& pair : LongPairs()) {
    const auto a = PrepareExact(pair.a), b = PrepareExact(pair.b);
    const PlacedExact placed_a{*a, pair.X_FB}, placed_b{*b, pair.X_FB};
    EndsAfter never(kNever);
    const PairDistance with = ExactDistance(placed_a, placed_b, kInfinity, &never);
    const PairDistance without = ExactDistance(placed_a, placed_b);
    EXPECT_EQ(with.distance_m, without.distance_m);
    EXPECT_EQ(with.point_a, without.point_a);
    EXPECT_EQ(ExactOverlap(placed_a, placed_b, &never), ExactOverlap(placed_a, placed_b));
  }
}

// The lowest corner, from all of them.
double LowestCorner_m(const TriangleMesh& mesh, const Pose& X_HM) {
  double lowest_m = kInfinity;
  for (const Vector3& v : mesh.vertices) lowest_m = std::min(lowest_m, (X_HM * v).z());
  return lowest_m;
}

TEST(HalfSpaceAndMesh, IsTheLowestCornerFoundByLookingAtFew) {
  const TriangleMesh mesh = DentedBall(100, 0.5);
  const Mesh solid{std::make_shared<const TriangleMesh>(mesh), true};
  const auto ground = PrepareExact(HalfSpace{}), ball = PrepareExact(solid);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> share(-1, 1);
  for (int i = 0; i < 200; ++i) {
    const Quaternion turn(share(random), share(random), share(random), share(random));
    const Pose X_FH = MakePose({share(random), share(random), 0}, turn.normalized());
    const Pose X_HM =
        MakePose({share(random), share(random), 0.5 + 0.1 * share(random)},
                 Quaternion(share(random), share(random), share(random), 1).normalized());
    const double expected_m = LowestCorner_m(mesh, X_HM);
    const PlacedExact placed_ground{*ground, X_FH};
    const Pose X_FM = X_FH * X_HM;
    const PlacedExact placed_ball{*ball, X_FM};
    EndsAfter distance(kNever), overlap(kNever);
    const PairDistance answer = ExactDistance(placed_ground, placed_ball, kInfinity, &distance);
    EXPECT_NEAR(answer.distance_m, expected_m, 1e-12);
    EXPECT_NEAR((X_FH.inverse() * answer.point_b).z(), expected_m, 1e-12);
    EXPECT_EQ(ExactOverlap(placed_ground, placed_ball, &overlap), expected_m < 0);
    EXPECT_GT(ExactDistance(placed_ground, placed_ball, expected_m - 1e-6).distance_m,
              expected_m - 1e-6);
    EXPECT_NEAR(ExactDistance(placed_ground, placed_ball, expected_m + 1e-6).distance_m, expected_m,
                1e-12);
    EXPECT_LT(distance.counted(), mesh.triangles.size() / 10);
    EXPECT_LE(overlap.counted(), distance.counted());
  }
}

TEST(ExactGeometry, FindsTheFarthestOfManyCornersByLanesAndAnswersTheSame) {
  const Shape hull = ManyCorners(1000), box = Box{{0.3, 0.2, 0.1}};
  const auto prepared = PrepareExact(hull), other = PrepareExact(box);
  const ConvexCore& with_lanes = prepared->pieces().front();
  EXPECT_NE(std::get<VertexCore>(with_lanes.core).lanes, nullptr);
  const ConvexCore plain = CoreOf(std::get<VertexCore>(with_lanes.core).vertices);
  EXPECT_EQ(std::get<VertexCore>(plain.core).lanes, nullptr);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> share(-1, 1);
  for (int i = 0; i < 200; ++i) {
    const Pose X_AB =
        MakePose(0.3 * Vector3(share(random), share(random), share(random)),
                 Quaternion(share(random), share(random), share(random), 1).normalized());
    const PairDistance a = ConvexDistance(with_lanes, other->pieces().front(), X_AB);
    const PairDistance b = ConvexDistance(plain, other->pieces().front(), X_AB);
    EXPECT_EQ(a.distance_m, b.distance_m);
    EXPECT_EQ(a.point_a, b.point_a);
    EXPECT_EQ(a.normal, b.normal);
  }
}

}  // namespace
}  // namespace cwm::collision
