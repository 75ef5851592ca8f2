#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <thread>
#include <vector>

#include "collision/geometry/tessellate.h"
#include "collision/geometry/validation.h"
#include "tests/collision/query/room_of_all_kinds.h"

namespace cwm::collision {
namespace {

using ::testing::Each;
using ::testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Expects the same bytes in all columns.
void ExpectSame(const PointColumns& a, const PointColumns& b) {
  EXPECT_EQ(a.completed, b.completed);
  EXPECT_EQ(a.state, b.state);
  EXPECT_EQ(a.distance_m, b.distance_m);
  EXPECT_EQ(a.gradient, b.gradient);
  EXPECT_EQ(a.object, b.object);
  EXPECT_EQ(a.object_part, b.object_part);
  EXPECT_EQ(a.accuracy, b.accuracy);
  EXPECT_EQ(a.bounds, b.bounds);
}

TEST_F(SamplePointsTest, DistancesAreThoseOfThePlainLoopOverAllParts) {
  const PointColumns columns = *SamplePoints(*world_, points_, {});
  ASSERT_EQ(columns.completed, points_.size());
  int inside = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Plain plain = PlainLoop(*world_, points_[i]);
    EXPECT_NEAR(columns.distance_m[i], plain.distance_m, kRounding_m) << i;
    inside += plain.distance_m < 0 ? 1 : 0;
    const WorldObject& named = *world_->objects()[columns.object[i]];
    EXPECT_NEAR(PartDistance_m(named, columns.object_part[i], points_[i]), plain.distance_m,
                kRounding_m)
        << i;
  }
  EXPECT_GT(inside, 300);
}

TEST_F(SamplePointsTest, EveryKindOfShapeIsTheNearestOfSomePoints) {
  const PointColumns columns = *SamplePoints(*world_, points_, {});
  std::array<int, kShapeKindCount> nearest{};
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const WorldObject& object = *world_->objects()[columns.object[i]];
    const Shape& shape = object.geometry->parts[columns.object_part[i]].shape;
    ++nearest[shape.index()];
  }
  EXPECT_THAT(nearest, Each(::testing::Gt(10)));
}

TEST(SamplePoints, BesideNothingEveryPointIsBeyond) {
  const std::vector<Vector3> points(100, Vector3(1, 2, 3));
  const PointColumns columns = *SamplePoints(WorldSnapshot(), points, {});
  EXPECT_EQ(columns.completed, points.size());
  EXPECT_THAT(columns.state, Each(SampleState::kBeyond));
  EXPECT_THAT(columns.distance_m, Each(0.0));
  EXPECT_EQ(SamplePoints(WorldSnapshot(), {}, {})->completed, 0u);
}

TEST_F(SamplePointsTest, PointsBeyondTheMaximumAreToldApartAndTheOthersStayAsTheyAre) {
  const PointColumns all = *SamplePoints(*world_, points_, {});
  QueryOptions options;
  options.max_distance_m = 0.05;
  const PointColumns near = *SamplePoints(*world_, points_, options);
  int beyond = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (all.distance_m[i] > options.max_distance_m) {
      ++beyond;
      EXPECT_EQ(near.state[i], SampleState::kBeyond) << i;
      EXPECT_EQ(near.distance_m[i], 0);
      continue;
    }
    EXPECT_EQ(near.state[i], all.state[i]);
    EXPECT_EQ(near.distance_m[i], all.distance_m[i]);
    EXPECT_EQ(near.accuracy[i], all.accuracy[i]);
    EXPECT_EQ(GradientOf(near, i), GradientOf(all, i));
  }
  EXPECT_EQ(near.bounds, all.bounds);
  EXPECT_GT(beyond, 500);
  EXPECT_LT(beyond, 4500);
}

TEST_F(SamplePointsTest, IgnoredObjectsAreLeftOut) {
  QueryOptions options;
  for (std::size_t i = 0; i < world_->objects().size(); ++i) {
    if (i % 2 == 0) options.ignore.push_back(world_->objects()[i]->name);
  }
  const PointColumns columns = *SamplePoints(*world_, points_, options);
  std::vector<Change> rest;
  for (const Change& change : changes_) {
    const std::string& name = std::get<PutObject>(change.what).name;
    if (std::count(options.ignore.begin(), options.ignore.end(), name) == 0) rest.push_back(change);
  }
  EXPECT_EQ(columns.distance_m, SamplePoints(*WorldOf(rest), points_, {})->distance_m);
}

TEST(SamplePoints, TheRepresentationSaysWhichPartsCount) {
  auto model = std::make_shared<HybridModel>();
  model->shapes.push_back({.shape = Sphere{0.1}});
  const Mesh surface =
      MakeMesh({.vertices = {{-1, -1, 0.5}, {1, -1, 0.5}, {0, 1, 0.5}}, .triangles = {{0, 1, 2}}});
  model->surfaces.push_back({.surface = surface});
  PutObject put;
  put.name = "both";
  put.geometry = Prepare(std::move(model));
  const auto world = WorldOf({Change{.what = put, .expected_object_revision = {}}});
  QueryOptions options;
  const auto at = [&](Representation representation) {
    options.representation = representation;
    return SampleOne(*world, {0, 0, 0.4}, options);
  };
  EXPECT_NEAR(at(Representation::kHybrid).distance_m[0], 0.1, 1e-12);
  EXPECT_EQ(at(Representation::kHybrid).accuracy[0], Accuracy::kSurfaceOnly);
  EXPECT_EQ(at(Representation::kHybrid).object_part[0], 1);
  EXPECT_NEAR(at(Representation::kShapes).distance_m[0], 0.3, 1e-12);
  EXPECT_EQ(at(Representation::kShapes).accuracy[0], Accuracy::kExact);
  EXPECT_NEAR(at(Representation::kSurfaces).distance_m[0], 0.1, 1e-12);
}

// A vertex 50 nm below two adjacent faces: convex to the tolerance of validation, but not by the
// planes of the slivers there.
TEST(SamplePoints, AHullIsThatOfItsCorners) {
  TriangleMesh hull = Tessellate(Box{{1, 1, 1}});
  const auto dent = static_cast<std::uint32_t>(hull.vertices.size());
  hull.vertices.emplace_back(0, -0.5 + 1e-6, 0.5 - 5e-8);
  for (TriangleMesh::Triangle& t : hull.triangles) {
    const Vector3 a = hull.vertices[t[0]], b = hull.vertices[t[1]], c = hull.vertices[t[2]];
    if (a.z() + b.z() + c.z() < 1.4) continue;  // top faces only
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t from = t[i], to = t[(i + 1) % 3], apex = t[(i + 2) % 3];
      if (hull.vertices[from].y() > -0.4 || hull.vertices[to].y() > -0.4) continue;
      t = {from, dent, apex};
      hull.triangles.push_back({dent, to, apex});
      hull.triangles.push_back({from, to, dent});
      break;
    }
    break;
  }
  ASSERT_EQ(hull.triangles.size(), 14U);
  const Convex dented{std::make_shared<const TriangleMesh>(hull)};
  ASSERT_FALSE(FindViolation(Shape(dented)).has_value());
  const auto world =
      WorldOf({PutOf("box", {{.X_FS = Pose::Identity(), .shape = dented}}, Pose::Identity())});
  EXPECT_NEAR(SampleOne(*world, {0, 0.4, 0.48}, {}).distance_m[0], -0.02, 1e-6);
  EXPECT_NEAR(SampleOne(*world, {0, 0.4, 0.6}, {}).distance_m[0], 0.1, 1e-6);
}

TEST(SamplePoints, MarginsDoNotEnter) {
  const auto world = WorldOf(
      {PutOf("ball", {{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}}, Pose::Identity())});
  QueryOptions options;
  options.margin_m = 0.5;
  EXPECT_NEAR(SampleOne(*world, {1, 0, 0}, options).distance_m[0], 0.9, 1e-12);
}

TEST(SamplePoints, WhereAnotherSolidCoversTheWayOutTheDepthIsABound) {
  const std::vector<Placed<>> box = {{.X_FS = Pose::Identity(), .shape = Box{{1, 1, 0.2}}}};
  // Two boxes on top of each other, 0.2 m each: together 0.4 m.
  const auto world = WorldOf({PutOf("lower", box, MakeTranslation(0, 0, 0.1)),
                              PutOf("upper", box, MakeTranslation(0, 0, 0.3))});
  const PointColumns covered = SampleOne(*world, {0, 0, 0.17});
  EXPECT_NEAR(covered.distance_m[0], -0.03, 1e-12);
  EXPECT_EQ(covered.accuracy[0], Accuracy::kBounded);
  ASSERT_EQ(covered.bounds.size(), 1u);
  EXPECT_EQ(covered.bounds[0].row, 0u);
  // The depth in the union, downwards, is 0.17.
  EXPECT_GE(covered.bounds[0].bound_m, 0.14);
  const PointColumns free = SampleOne(*world, {0, 0, 0.03});
  EXPECT_EQ(free.accuracy[0], Accuracy::kExact);
  EXPECT_TRUE(free.bounds.empty());
}

TEST(SamplePoints, ACoverCountsHoweverMuchNearerOtherSolidsAre) {
  const auto put = [](const std::string& name, const Shape& shape, double z_m) {
    return PutOf(name, {{.X_FS = Pose::Identity(), .shape = shape}}, MakeTranslation(0, 0, z_m));
  };
  // 0.3 m below the top of a block, 5 mm above a marble in it; a lid begins 0.25 m above.
  const auto world =
      WorldOf({put("block", Box{{4, 4, 4}}, -1.7), put("lid", Box{{1, 1, 0.2}}, 0.35),
               put("marble", Sphere{0.01}, -0.015)});
  const PointColumns covered = SampleOne(*world, {0, 0, 0});
  EXPECT_NEAR(covered.distance_m[0], -0.3, 1e-12);
  EXPECT_EQ(covered.accuracy[0], Accuracy::kBounded);
}

TEST_F(SamplePointsTest, NoPointIsDeeperThanItsBoundSays) {
  // The depth in the union of overlapping boxes, from the nearest of many points outside.
  std::vector<Change> changes;
  for (int i = 0; i < 12; ++i) {
    changes.push_back(PutOf("box" + std::to_string(i),
                            {{.X_FS = Pose::Identity(), .shape = Box{{0.2, 0.16, 0.12}}}},
                            RandomPose(random_, 0.12)));
  }
  const auto world = WorldOf(changes);
  const std::vector<Vector3> points = RandomPoints(4000, random_, 0.2);
  const PointColumns columns = *SamplePoints(*world, points, {});
  std::vector<Vector3> outside;
  for (const Vector3& p : RandomPoints(60000, random_, 0.25)) {
    if (PlainLoop(*world, p).distance_m > 0) outside.push_back(p);
  }
  ASSERT_GT(columns.bounds.size(), 100u);
  std::vector<double> bound_m(points.size(), 0);
  for (const PointColumns::Bound& bound : columns.bounds) {
    bound_m[bound.row] = bound.bound_m;
    EXPECT_EQ(columns.accuracy[bound.row], Accuracy::kBounded);
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (columns.distance_m[i] >= 0 || columns.accuracy[i] == Accuracy::kDegraded) continue;
    double way_out_m = kInfinity;
    for (const Vector3& q : outside) way_out_m = std::min(way_out_m, (q - points[i]).norm());
    EXPECT_GE(way_out_m, -columns.distance_m[i]);
    // Points outside are 1 cm apart on average, and nowhere 3 cm.
    EXPECT_LE(way_out_m, -columns.distance_m[i] + bound_m[i] + 0.03) << i;
  }
}

TEST_F(SamplePointsTest, TheSameBytesForAnyOrderOfInsertionAndAnyThreads) {
  std::vector<Vector3> points;
  for (int i = 0; i < 10; ++i) points.insert(points.end(), points_.begin(), points_.end());
  const PointColumns once = *SamplePoints(*world_, points, {});
  std::vector<Change> reversed(changes_.rbegin(), changes_.rend());
  ExpectSame(once, *SamplePoints(*WorldOf(reversed), points, {}));
  QueryOptions options;
  for (const int threads : {2, 3, 7}) {
    options.threads = threads;
    ExpectSame(once, *SamplePoints(*world_, points, options));
  }
}

TEST_F(SamplePointsTest, TheAnswerOfAPointDoesNotDependOnTheOthers) {
  const PointColumns together = *SamplePoints(*world_, points_, {});
  for (std::size_t i = 0; i < points_.size(); i += 7) {
    const PointColumns alone = SampleOne(*world_, points_[i]);
    EXPECT_EQ(alone.distance_m[0], together.distance_m[i]) << i;
    EXPECT_EQ(GradientOf(alone, 0), GradientOf(together, i)) << i;
    EXPECT_EQ(alone.object[0], together.object[i]) << i;
    EXPECT_EQ(alone.state[0], together.state[i]) << i;
    EXPECT_EQ(alone.accuracy[0], together.accuracy[i]) << i;
  }
}

TEST(SamplePoints, InAWorldOfManyObjectsTheNearestIsFoundToo) {
  std::mt19937 random(42);
  const auto world = RandomWorld(400, random, /*with_meshes=*/false);
  const std::vector<Vector3> points = RandomPoints(500, random, 1.2);
  const PointColumns columns = *SamplePoints(*world, points, {});
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(columns.distance_m[i], PlainLoop(*world, points[i]).distance_m, kRounding_m) << i;
  }
}

TEST_F(SamplePointsTest, ATimeBudgetCompletesAPrefix) {
  std::vector<Vector3> points;
  for (int i = 0; i < 200; ++i) points.insert(points.end(), points_.begin(), points_.end());
  QueryOptions options;
  for (const int threads : {1, 2}) {
    options.threads = threads;
    // The budget grows until the first points are answered, however slow the machine is.
    std::chrono::duration<double> budget = std::chrono::milliseconds(10);
    PointColumns some;
    for (; some.completed == 0; budget *= 1.25) {
      options.deadline = std::chrono::steady_clock::now() +
                         std::chrono::duration_cast<std::chrono::nanoseconds>(budget);
      some = *SamplePoints(*world_, points, options);
    }
    ASSERT_LT(some.completed, points.size());
    ASSERT_EQ(some.distance_m.size(), some.completed);
    const PointColumns all = *SamplePoints(*world_, std::span(points).first(some.completed), {});
    ExpectSame(all, some);
  }
}

TEST_F(SamplePointsTest, AStoppedQuestionIsCancelledSoon) {
  std::vector<Vector3> points;
  for (int i = 0; i < 200; ++i) points.insert(points.end(), points_.begin(), points_.end());
  std::stop_source stop;
  std::jthread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    stop.request_stop();
  });
  QueryOptions options;
  options.threads = 2;
  const auto columns = SamplePoints(*world_, points, options, stop.get_token());
  EXPECT_EQ(columns.status().code(), absl::StatusCode::kCancelled);
}

TEST(SamplePoints, AnEngineThatSamplesNoPointsIsRefusedByName) {
  const std::vector<Vector3> points = {Vector3::Zero()};
  QueryOptions options;
  options.engine = EngineChoice::kExact;
  EXPECT_TRUE(SamplePoints(WorldSnapshot(), points, options).ok());
  for (const auto& [engine, name] :
       {std::pair(EngineChoice::kFcl, "FCL"), std::pair(EngineChoice::kBullet, "BULLET")}) {
    options.engine = engine;
    const absl::Status status = SamplePoints(WorldSnapshot(), points, options).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kUnimplemented);
    EXPECT_THAT(std::string(status.message()), HasSubstr(name));
  }
}

}  // namespace
}  // namespace cwm::collision
