// Edges of robots of spheres in SIMD lanes, against dense samples and the search pair by pair.
#include "collision/motion/sphere_motion.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "collision/motion/check_paths.h"
#include "collision/robot/kinematics.h"
#include "tests/collision/motion/dense_samples.h"
#include "tests/collision/query/room_of_all_kinds.h"
#include "tests/collision/query/sphere_arm.h"

namespace cwm::collision {
namespace {

constexpr int kSphereSamples = 500;  // of an edge

class SphereMotionTest : public ::testing::Test {
 protected:
  // Edges within the limits of the rail and the joints; the waist may turn the short way round.
  void Draw(std::size_t edges, double length) {
    std::uniform_real_distribution<double> rail(-0.3, 0.4), waist(-3.1, 3.1), turn(-2.5, 2.9),
        step(-length, length);
    for (std::size_t k = 0; k < edges; ++k) {
      std::vector<double> from = {rail(random_), waist(random_), turn(random_), turn(random_)};
      ASSERT_EQ(from.size(), width_);
      rows_.insert(rows_.end(), from.begin(), from.end());
      const auto next = [&](double value, double lower, double upper) {
        rows_.push_back(std::clamp(value + step(random_), lower, upper));
      };
      next(from[0], -0.3, 0.4);
      rows_.push_back(std::remainder(from[1] + step(random_), 2 * M_PI));
      next(from[2], -2.5, 2.9);
      next(from[3], -2.5, 2.9);
      paths_.push_back({.first_row = 2 * (paths_.size())});
    }
  }

  JointRows Rows() const {
    return {
        *model_, model_->all, {.X_WB = X_WB_, .base = DefaultVariables(*model_), .rows = rows_}};
  }

  // Compares the answers with samples and with those of the search pair by pair.
  Tally ExpectTrueAnswers(const WorldSnapshot& world, const QueryOptions& options = {}) const {
    const JointRows rows = Rows();
    const JointWaypoints waypoints(*model_, body_, rows);
    const MotionColumns by_spheres = *CheckPaths(world, body_, waypoints, paths_, options);
    std::vector<std::unique_ptr<BodyMotion>> edges;
    for (const Path& path : paths_) edges.push_back(waypoints.MotionFrom(path.first_row));
    const MotionColumns by_pairs = *CheckMotions(world, body_, edges, options);
    Tally tally;
    for (std::size_t k = 0; k < paths_.size(); ++k) {
      EXPECT_EQ(by_spheres.verdict[k], by_pairs.verdict[k]) << k;
      EXPECT_LE(by_spheres.lo[k], by_pairs.hi[k]) << k;
      EXPECT_LE(by_pairs.lo[k], by_spheres.hi[k]) << k;
      if (options.margin_m == 0) {
        ExpectTrue(world, body_, *edges[k], by_spheres, k, kSphereSamples, tally);
      }
      if (by_spheres.verdict[k] == MotionVerdict::kFree) {
        EXPECT_LE(by_spheres.clearance_m[k], ClearanceOf(world, *edges[k], options) + 1e-6) << k;
        EXPECT_GE(by_spheres.clearance_m[k], 0.2 * by_pairs.clearance_m[k]) << k;
      }
    }
    return tally;
  }

  // The least distance of samples, less the margin.
  double ClearanceOf(const WorldSnapshot& world, const BodyMotion& edge,
                     const QueryOptions& options) const {
    std::vector<double> fractions;
    for (int k = 0; k <= kSphereSamples; ++k)
      fractions.push_back(static_cast<double>(k) / kSphereSamples);
    const auto distances = *GetDistances(world, body_, FractionRows(edge, fractions),
                                         {.max_distance_m = 0.05 + options.margin_m});
    double least_m = kMaxClearance_m;
    for (const double distance_m : distances.distance_m) {
      least_m = std::min(least_m, distance_m - options.margin_m);
    }
    return least_m;
  }

  std::shared_ptr<const RobotModel> model_ = SphereArm();
  QueryBody body_ = BodyOfSphereArm(*model_);
  const std::size_t width_ = model_->all.variables.size();
  Pose X_WB_ =
      MakePose({0.2, -0.3, 0.1}, Quaternion(Eigen::AngleAxisd(0.8, Vector3(1, 2, 3).normalized())));
  std::mt19937 random_{11};
  std::vector<double> rows_;
  std::vector<Path> paths_;
};

TEST_F(SphereMotionTest, IsNeverWrongAmongAllKindsOfShapes) {
  Draw(60, 0.8);
  Tally all;
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    for (int k = 0; k < 2; ++k) {
      const auto world = WorldOf(RoomOfAllKinds(random_));
      const Tally tally = ExpectTrueAnswers(*world);
      all.free += tally.free;
      all.contact += tally.contact;
    }
  }
  hwy::SetSupportedTargetsForTest(0);
  EXPECT_GT(all.free, 60);
  EXPECT_GT(all.contact, 60);
}

TEST_F(SphereMotionTest, KeepsMargins) {
  Draw(150, 0.4);
  const auto world = WorldOf(RoomOfAllKinds(random_));
  ExpectTrueAnswers(*world, {.margin_m = 0.03});
}

TEST_F(SphereMotionTest, FindsCollisionsOfTheRobotWithItself) {
  Draw(200, 1.5);
  const Tally tally = ExpectTrueAnswers(WorldSnapshot());
  EXPECT_GT(tally.free, 50);
  EXPECT_GT(tally.contact, 20);
}

TEST_F(SphereMotionTest, DecidesMostEdgesAlone) {
  Draw(500, 0.5);
  std::vector<Change> boxes;
  std::uniform_real_distribution<double> at(-1, 1);
  for (int k = 0; k < 6; ++k) {
    boxes.push_back(PutOf("box" + std::to_string(k), {{.shape = Box{{0.1, 0.1, 0.1}}}},
                          MakeTranslation(at(random_), at(random_), at(random_))));
  }
  const auto world = WorldOf(boxes);
  const JointRows rows = Rows();
  auto spheres = SphereMotion::Make(*world, body_, rows, {});
  ASSERT_TRUE(spheres.has_value());
  int decided = 0;
  for (const Path& path : paths_) decided += spheres->Check(path.first_row).open.empty();
  EXPECT_GT(decided, 350);
}

}  // namespace
}  // namespace cwm::collision
