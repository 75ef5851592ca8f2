#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <vector>

#include "collision/geometry/signed_distance.h"
#include "collision/geometry/tessellate.h"
#include "collision/kernels/kink.h"
#include "collision/query/query.h"
#include "tests/collision/query/random_world.h"

namespace cwm::collision {
namespace {

using testing::Each;
using testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Both sides round coordinates of a few metres some dozen times.
constexpr double kRounding_m = 1e-13;

VesselShell Cup() {
  return {.outer = {{0.03, -0.05}, {0.035, 0}, {0.04, 0.05}},
          .inner = {{0.037, 0.05}, {0.032, 0}, {0.027, -0.045}, {0, -0.046}},
          .wall_thickness_m = 0.003};
}

Change PutCup(const std::string& name, const Pose& X_WO) {
  auto model = std::make_shared<HybridModel>();
  auto shell = std::make_shared<const VesselShell>(Cup());
  model->shapes.push_back({.X_OS = MakeTranslation(0.01, 0, 0),
                           .shape = MakeMesh(Tessellate(*shell, 1e-4)),
                           .vessel = shell});
  PutObject put;
  put.name = name;
  put.X_WO = X_WO;
  put.geometry = Prepare(std::move(model));
  return {.what = std::move(put), .expected_object_revision = {}};
}

// Two of each kind of the catalogue, two vessels and a tilted floor.
std::vector<Change> RoomOfAllKinds(std::mt19937& random) {
  std::vector<Change> changes;
  for (std::size_t i = 0; i < 2 * Catalogue().size(); ++i) {
    const CatalogueShape& entry = Catalogue()[i % Catalogue().size()];
    if (KindOf(entry.shape) == ShapeKind::kHalfSpace) continue;
    std::vector<Placed<>> parts = {{.X_FS = RandomPose(random, 0.05), .shape = entry.shape}};
    if (i % 3 == 0) parts.push_back({.X_FS = RandomPose(random, 0.1), .shape = Sphere{0.03}});
    changes.push_back(PutOf("object" + std::to_string(i), parts, RandomPose(random, 0.5)));
  }
  changes.push_back(PutCup("cup0", RandomPose(random, 0.5)));
  changes.push_back(PutCup("cup1", RandomPose(random, 0.5)));
  const Quaternion tilt(Eigen::AngleAxisd(0.1, Vector3::UnitX()));
  changes.push_back(PutOf("floor", {{.X_FS = Pose::Identity(), .shape = HalfSpace{}}},
                          MakePose({0, 0, -0.6}, tilt)));
  return changes;
}

std::vector<Vector3> RandomPoints(int count, std::mt19937& random, double spread_m = 0.7) {
  std::uniform_real_distribution<double> place(-spread_m, spread_m);
  std::vector<Vector3> points;
  for (int i = 0; i < count; ++i) {
    const double x = place(random), y = place(random), z = place(random);
    points.emplace_back(x, y, z);
  }
  return points;
}

struct Plain {
  double distance_m = kInfinity;
  int object = -1, part = -1;
};

double PartDistance_m(const WorldObject& object, std::size_t k, const Vector3& p_W) {
  const PreparedPart& part = object.geometry->parts[k];
  const Vector3 p = (object.X_WO * part.X_OP).inverse() * p_W;
  if (part.source == PartSource::kShape) {
    return SignedDistance_m(object.model().shapes[static_cast<std::size_t>(part.index)], p);
  }
  return SignedDistance_m(part.shape, p);
}

// The oracle: all parts, one after the other.
Plain PlainLoop(const WorldSnapshot& world, const Vector3& p_W) {
  Plain nearest;
  for (std::size_t i = 0; i < world.objects().size(); ++i) {
    const WorldObject& object = *world.objects()[i];
    for (std::size_t k = 0; k < object.geometry->parts.size(); ++k) {
      const double distance_m = PartDistance_m(object, k, p_W);
      if (distance_m >= nearest.distance_m) continue;
      nearest = {distance_m, static_cast<int>(i), static_cast<int>(k)};
    }
  }
  return nearest;
}

PointColumns SampleOne(const WorldSnapshot& world, const Vector3& p,
                       const QueryOptions& options = {}) {
  return *SamplePoints(world, std::vector<Vector3>{p}, options);
}

Vector3 GradientOf(const PointColumns& columns, std::size_t row) {
  return Vector3(&columns.gradient[3 * row]);
}

// The same bytes in all columns.
void ExpectSame(const PointColumns& a, const PointColumns& b) {
  EXPECT_EQ(a.completed, b.completed);
  EXPECT_EQ(a.state, b.state);
  EXPECT_EQ(a.distance_m, b.distance_m);
  EXPECT_EQ(a.gradient, b.gradient);
  EXPECT_EQ(a.object, b.object);
  EXPECT_EQ(a.object_part, b.object_part);
  EXPECT_EQ(a.trust, b.trust);
  EXPECT_EQ(a.bounds, b.bounds);
}

class SamplePointsTest : public testing::Test {
 protected:
  std::mt19937 random_{42};
  std::vector<Change> changes_ = RoomOfAllKinds(random_);
  std::shared_ptr<const WorldSnapshot> world_ = WorldOf(changes_);
  std::vector<Vector3> points_ = RandomPoints(5000, random_);
};

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
  EXPECT_THAT(nearest, Each(testing::Gt(10)));
}

TEST_F(SamplePointsTest, GradientsAreThoseOfCentralDifferencesAwayFromKinks) {
  // A tenth of the reach of kinks: differences stay on one side of them. Rounding of distances of a
  // metre leaves 1e-9, curvature of features of a millimetre 1e-8.
  constexpr double kStep_m = 0.1 * kKinkReach_m;
  const PointColumns columns = *SamplePoints(*world_, points_, {});
  int kinks = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Vector3 gradient = GradientOf(columns, i);
    EXPECT_NEAR(gradient.norm(), 1, 1e-12);
    if (columns.state[i] == SampleState::kKink) {
      ++kinks;
      continue;
    }
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3 step = kStep_m * Vector3::Unit(axis);
      const double slope = (PlainLoop(*world_, points_[i] + step).distance_m -
                            PlainLoop(*world_, points_[i] - step).distance_m) /
                           (2 * kStep_m);
      EXPECT_NEAR(gradient[axis], slope, 1e-6) << i << " axis " << axis;
    }
  }
  EXPECT_LT(kinks, 10);  // random points meet few
}

TEST_F(SamplePointsTest, EachKindHasItsGradientNearItsEdgesToo) {
  constexpr double kStep_m = 0.1 * kKinkReach_m;
  std::vector<Change> kinds;
  for (const CatalogueShape& entry : Catalogue()) {
    kinds = {PutOf("it", {{.X_FS = Pose::Identity(), .shape = entry.shape}}, Pose::Identity())};
    const auto world = WorldOf(kinds);
    const std::vector<Vector3> points = RandomPoints(1000, random_, 1.3 * entry.size_m);
    const PointColumns columns = *SamplePoints(*world, points, {});
    int kinks = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_NEAR(columns.distance_m[i], SignedDistance_m(entry.shape, points[i]), kRounding_m);
      if (columns.state[i] == SampleState::kKink) {
        ++kinks;
        continue;
      }
      for (int axis = 0; axis < 3; ++axis) {
        const Vector3 step = kStep_m * Vector3::Unit(axis);
        const double slope = (SignedDistance_m(entry.shape, points[i] + step) -
                              SignedDistance_m(entry.shape, points[i] - step)) /
                             (2 * kStep_m);
        EXPECT_NEAR(columns.gradient[3 * i + axis], slope, 1e-6) << entry.name << " " << i;
      }
    }
    EXPECT_LT(kinks, 5) << entry.name;
  }
}

struct Place {
  std::string name;
  Shape shape;
  Vector3 p;
};

TEST(SamplePoints, KinksAreFlaggedWhereTwoPlacesAreEquallyNear) {
  const Plate ring{.outline = {{-0.3, -0.2}, {0.3, -0.2}, {0.3, 0.2}, {-0.3, 0.2}},
                   .holes = {{{-0.1, -0.1}, {0.1, -0.1}, {0.1, 0.1}, {-0.1, 0.1}}},
                   .thickness_m = 0.04};
  const Box box{{0.4, 0.2, 0.1}};
  const std::vector<Place> places = {
      {"centre of a sphere", Sphere{0.1}, {0, 0, 0}},
      {"middle plane of a box", box, {0.02, 0.01, 0}},
      {"bisector of two faces of a box", box, {0, 0.09, 0.04}},
      {"edge of a box", box, {0, 0.1, 0.05}},
      {"axis of a cylinder", Cylinder{0.05, 0.4}, {0, 0, 0.05}},
      {"middle plane of a flat cylinder", Cylinder{0.3, 0.1}, {0.05, 0, 0}},
      {"axis of a cone", Cone{0.05, 0.04, 0.4}, {0, 0, 0.02}},
      {"apex of a cone", Cone{0.1, 0, 0.2}, {0, 0, 0.1}},
      {"core of a capsule", Capsule{0.05, 0.3}, {0, 0, 0.1}},
      {"middle plane of a plate", ring, {0.2, 0.15, -0.02}},
      {"middle of a hole", ring, {0, 0, -0.02}},
      {"diagonal of a hole", ring, {0.05, 0.05, 0.01}},
      {"middle plane of a hull",
       Convex{std::make_shared<const TriangleMesh>(BoxMesh(box.size_m))},
       {0.02, 0.01, 0}},
      {"edge of a hull",
       Convex{std::make_shared<const TriangleMesh>(BoxMesh(box.size_m))},
       {0.02, 0.1, 0.05}},
      {"middle plane of a mesh", MakeMesh(BoxMesh(box.size_m)), {0.02, 0.01, 0}},
      {"edge of a mesh", MakeMesh(BoxMesh(box.size_m)), {0.02, 0.1, 0.05}},
      {"notch of a mesh", MakeMesh(ElbowMesh()), {0.03, 0.03, 0}},
      {"face of an open mesh", Catalogue().back().shape, {0.02, 0.01, -0.06}},
  };
  std::mt19937 random(42);
  for (const Place& place : places) {
    const Pose X_WO = RandomPose(random, 1.0);
    const auto world = WorldOf({PutOf("it", {{.shape = place.shape}}, X_WO)});
    const PointColumns columns = SampleOne(*world, X_WO * place.p);
    EXPECT_EQ(columns.state[0], SampleState::kKink) << place.name;
    EXPECT_NEAR(GradientOf(columns, 0).norm(), 1, 1e-12) << place.name;
    EXPECT_NEAR(columns.distance_m[0], SignedDistance_m(place.shape, place.p), kRounding_m)
        << place.name;
  }
}

TEST(SamplePoints, OrdinaryPlacesAreNoKinksHoweverManyTrianglesMeetThere) {
  const Box box{{0.4, 0.2, 0.1}};
  const Convex hull{std::make_shared<const TriangleMesh>(BoxMesh(box.size_m))};
  const Mesh ball = MakeMesh(Tessellate(Sphere{0.1}));
  const std::vector<Place> places = {
      {"outside of a sphere", Sphere{0.1}, {0.2, 0, 0}},
      {"nearest to a corner of a box", box, {0.3, 0.2, 0.1}},
      {"above the edge of a face", box, {0.2, 0.1, 0.2}},
      {"on a face", box, {0.02, 0.01, 0.05}},
      {"above the end of a cylinder, on its axis", Cylinder{0.05, 0.4}, {0, 0, 0.3}},
      {"above an apex", Cone{0.1, 0, 0.2}, {0, 0, 0.3}},
      {"beside the axis above an apex", Cone{0.1, 0, 0.2}, {1e-5, 0, 0.2}},
      {"above the diagonal of a hull's face", hull, {0, 0, 0.2}},
      {"below it", hull, {0.0, 0.0, 0.04}},
      {"on it", hull, {0, 0, 0.05}},
      {"nearest to a hull's corner", hull, {0.3, 0.2, 0.1}},
      {"above the diagonal of a mesh's face", MakeMesh(BoxMesh(box.size_m)), {0, 0, 0.2}},
      {"below it", MakeMesh(BoxMesh(box.size_m)), {0, 0, 0.04}},
      {"on it", MakeMesh(BoxMesh(box.size_m)), {0, 0, 0.05}},
      {"nearest to a mesh's corner", MakeMesh(BoxMesh(box.size_m)), {0.3, 0.2, 0.1}},
      // Where a neighbour's rim is almost as near as the place itself, 1e-4 m aside.
      {"beside a mesh's edge", MakeMesh(BoxMesh(box.size_m)), {0.02, 0.1 - 1e-4, 0.15}},
      {"nearest to a corner of many triangles", ball, 2 * ball.mesh->vertices[5]},
  };
  std::mt19937 random(42);
  for (const Place& place : places) {
    const Pose X_WO = RandomPose(random, 1.0);
    const auto world = WorldOf({PutOf("it", {{.shape = place.shape}}, X_WO)});
    const PointColumns columns = SampleOne(*world, X_WO * place.p);
    EXPECT_EQ(columns.state[0], SampleState::kSmooth) << place.name;
  }
}

TEST(SamplePoints, VesselsHaveTheDistanceOfTheirProfileAndKinksInTheMiddle) {
  const auto world = WorldOf({PutCup("cup", MakeTranslation(-0.01, 0, 0))});
  std::mt19937 random(42);
  for (const Vector3& p : RandomPoints(500, random, 0.08)) {
    EXPECT_NEAR(SampleOne(*world, p).distance_m[0], SignedDistance_m(Cup(), p), kRounding_m);
  }
  // Half way up the wall is nearest all around; far above, the rim is; below the foot, the foot.
  EXPECT_EQ(SampleOne(*world, {0, 0, 0.02}).state[0], SampleState::kKink);
  EXPECT_EQ(SampleOne(*world, {0, 0, 0.2}).state[0], SampleState::kKink);
  EXPECT_EQ(SampleOne(*world, {0.01, 0.02, 0.02}).state[0], SampleState::kSmooth);
  EXPECT_EQ(SampleOne(*world, {0, 0, -0.2}).state[0], SampleState::kSmooth);
}

TEST(SamplePoints, MidwayBetweenTwoObjectsIsAKinkOfTheFirstByName) {
  const std::vector<Placed<>> ball = {{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}};
  const auto world = WorldOf({PutOf("b", ball, MakeTranslation(-0.5, 0, 0)),
                              PutOf("a", ball, MakeTranslation(0.5, 0, 0))});
  const PointColumns at = SampleOne(*world, {0, 0, 0});
  EXPECT_EQ(at.state[0], SampleState::kKink);
  EXPECT_EQ(world->objects()[at.object[0]]->name, "a");
  EXPECT_LT((GradientOf(at, 0) + Vector3::UnitX()).norm(), 1e-12);
  // Distances differ by twice the way to the middle.
  EXPECT_EQ(SampleOne(*world, {0.49 * kKinkReach_m, 0, 0}).state[0], SampleState::kKink);
  EXPECT_EQ(SampleOne(*world, {0.51 * kKinkReach_m, 0, 0}).state[0], SampleState::kSmooth);
}

TEST(SamplePoints, EquallyNearPartsThatPullOneWayAreNoKink) {
  const std::vector<Placed<>> box = {{.X_FS = Pose::Identity(), .shape = Box{{0.2, 0.2, 0.2}}}};
  const auto world =
      WorldOf({PutOf("a", box, Pose::Identity()), PutOf("b", box, Pose::Identity())});
  EXPECT_EQ(SampleOne(*world, {0.02, 0.03, 0.3}).state[0], SampleState::kSmooth);
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
    EXPECT_EQ(near.trust[i], all.trust[i]);
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
  EXPECT_EQ(at(Representation::kHybrid).trust[0], Trust::kSurfaceOnly);
  EXPECT_EQ(at(Representation::kHybrid).object_part[0], 1);
  EXPECT_NEAR(at(Representation::kShapes).distance_m[0], 0.3, 1e-12);
  EXPECT_EQ(at(Representation::kShapes).trust[0], Trust::kExact);
  EXPECT_NEAR(at(Representation::kSurfaces).distance_m[0], 0.1, 1e-12);
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
  // One upon the other, 0.2 m and 0.2 m: together 0.4 m.
  const auto world = WorldOf({PutOf("lower", box, MakeTranslation(0, 0, 0.1)),
                              PutOf("upper", box, MakeTranslation(0, 0, 0.3))});
  const PointColumns covered = SampleOne(*world, {0, 0, 0.17});
  EXPECT_NEAR(covered.distance_m[0], -0.03, 1e-12);
  EXPECT_EQ(covered.trust[0], Trust::kBounded);
  ASSERT_EQ(covered.bounds.size(), 1u);
  EXPECT_EQ(covered.bounds[0].row, 0u);
  // The union's depth, below, is 0.17.
  EXPECT_GE(covered.bounds[0].bound_m, 0.14);
  const PointColumns free = SampleOne(*world, {0, 0, 0.03});
  EXPECT_EQ(free.trust[0], Trust::kExact);
  EXPECT_TRUE(free.bounds.empty());
}

TEST_F(SamplePointsTest, NoPointIsDeeperThanItsBoundSays) {
  // Boxes that overlap: the union's depth by the nearest of many points outside.
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
    EXPECT_EQ(columns.trust[bound.row], Trust::kBounded);
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (columns.distance_m[i] >= 0 || columns.trust[i] == Trust::kDegraded) continue;
    double way_out_m = kInfinity;
    for (const Vector3& q : outside) way_out_m = std::min(way_out_m, (q - points[i]).norm());
    EXPECT_GE(way_out_m, -columns.distance_m[i]);
    // Points outside lie 1 cm apart in the mean, nowhere 3 cm.
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
    EXPECT_EQ(alone.trust[0], together.trust[i]) << i;
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
    options.give_up_at = std::chrono::steady_clock::now() + std::chrono::milliseconds(100);
    const PointColumns some = *SamplePoints(*world_, points, options);
    ASSERT_LT(some.completed, points.size());
    ASSERT_GT(some.completed, 0u);
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
