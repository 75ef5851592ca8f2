#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "collision/kernels/kink.h"
#include "tests/collision/query/room_of_all_kinds.h"

namespace cwm::collision {
namespace {

TEST_F(SamplePointsTest, GradientsAreThoseOfCentralDifferencesAwayFromKinks) {
  // derived: a tenth of the reach of kinks, so that differences stay on one side of them. Rounding
  // of distances of a metre leaves 1e-9, curvature of features of a millimetre 1e-8.
  constexpr double kStep_m = 0.1 * kKinkTolerance_m;
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
  constexpr double kStep_m = 0.1 * kKinkTolerance_m;
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
      // The rim of a neighbouring face is almost as near, 1e-4 m beside the nearest place.
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
  // Half way up, the wall is equally near all around; far above, the rim is; below the foot, the
  // foot is nearest.
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
  // The distances differ by twice the distance from the middle.
  EXPECT_EQ(SampleOne(*world, {0.49 * kKinkTolerance_m, 0, 0}).state[0], SampleState::kKink);
  EXPECT_EQ(SampleOne(*world, {0.51 * kKinkTolerance_m, 0, 0}).state[0], SampleState::kSmooth);
}

TEST(SamplePoints, EquallyNearPartsThatPullOneWayAreNoKink) {
  const std::vector<Placed<>> box = {{.X_FS = Pose::Identity(), .shape = Box{{0.2, 0.2, 0.2}}}};
  const auto world =
      WorldOf({PutOf("a", box, Pose::Identity()), PutOf("b", box, Pose::Identity())});
  EXPECT_EQ(SampleOne(*world, {0.02, 0.03, 0.3}).state[0], SampleState::kSmooth);
}

}  // namespace
}  // namespace cwm::collision
