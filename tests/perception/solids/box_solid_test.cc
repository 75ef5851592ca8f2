#include "perception/solids/box_solid.h"

#include <gtest/gtest.h>

#include "tests/perception/solids/seen_fits.h"

namespace cwm::perception {
namespace {

// A box of 12 by 8 by 6 cm, turned about z. Its front (-x), its side (-y) and its top are seen, the
// walls only from `shown_m` above its foot.
struct BoxInView {
  BoxInView(double foot_m, double shown_m) {
    X.linear() = Eigen::AngleAxisd(0.3, Vector3::UnitZ()).toRotationMatrix();
    X.translation() = Vector3(0.02, 0.01, foot_m);
    const Vector3 up(0, 0, 0.06 - shown_m);
    fits = {Add({-0.06, 0.04, shown_m}, {0, -0.08, 0}, up),
            Add({-0.06, -0.04, shown_m}, {0.12, 0, 0}, up),
            Add({-0.06, -0.04, 0.06}, {0.12, 0, 0}, {0, 0.08, 0})};
  }
  ShapeFit Add(const Vector3& corner, const Vector3& along, const Vector3& across) {
    return seen.AddFace(X * corner, X.linear() * along, X.linear() * across);
  }
  Solid Made(const Ground& ground) {
    return MakeBox({2, 1, 0}, fits, seen.Context(ground), ground);
  }

  SeenFits seen{Vector3(-0.6, -0.5, 0.7)};
  Pose X = Pose::Identity();  // of the middle of its foot
  std::vector<ShapeFit> fits;
};

// The corner with the least x, y and z, which the walls and the foot determine.
Vector3 LowCornerOf(const Solid& box) {
  return box.X_MS * Vector3(-0.5 * std::get<Box>(box.shape).size_m);
}

TEST(FindBoxFaces, AreThoseOfAnOuterCornerTheLargestFirst) {
  BoxInView box(0, 0.02);
  const FitContext context = box.seen.Context();
  EXPECT_EQ(FindBoxFaces(box.fits, {0, 0, 0}, context), (BoxFaces{2, 1, 0}));
  EXPECT_EQ(FindBoxFaces(box.fits, {0, 1, 0}, context), (BoxFaces{2, 0}));
  EXPECT_FALSE(FindBoxFaces(box.fits, {0, 1, 1}, context));
  EXPECT_FALSE(FindBoxFaces({}, {}, context));
  // Faces of an inner corner and faces that do not touch make no box.
  SeenFits corner(Vector3(0.6, 0, 0.6));
  const ShapeFit floor = corner.AddFace({0, -0.05, 0}, {0.1, 0, 0}, {0, 0.1, 0});
  const ShapeFit wall = corner.AddFace({0, -0.05, 0}, {0, 0.1, 0}, {0, 0, 0.1});
  EXPECT_FALSE(FindBoxFaces({floor, wall}, {0, 0}, corner.Context()));
  for (const double apart_m : {0.01, 0.06}) {
    SeenFits edge(Vector3(-0.6, 0, 0.6));
    const ShapeFit top = edge.AddFace({apart_m, -0.05, 0.1}, {0.1, 0, 0}, {0, 0.1, 0});
    const ShapeFit front = edge.AddFace({0, 0.05, 0}, {0, -0.1, 0}, {0, 0, 0.1});
    EXPECT_EQ(FindBoxFaces({top, front}, {0, 0}, edge.Context()).has_value(), apart_m < 0.03);
  }
}

TEST(MakeBox, EndsWhereItsFacesAreAndOnTheGroundJustBelow) {
  BoxInView box(0, 0.02);
  const Solid solid = box.Made(kFloorAtZero);
  const Vector3 size_m = std::get<Box>(solid.shape).size_m;
  EXPECT_LT((solid.X_MS.linear() - box.X.linear()).norm(), kSeenExact_m);
  EXPECT_LT((LowCornerOf(solid) - box.X * Vector3(-0.06, -0.04, 0)).norm(), kSeenExact_m);
  EXPECT_NEAR(size_m.x(), 0.12, kSeenEnd_m);  // the far ends are those of other faces
  EXPECT_NEAR(size_m.y(), 0.08, kSeenEnd_m);
  EXPECT_NEAR(size_m.z(), 0.06, kSeenExact_m);
  EXPECT_EQ(solid.inliers.size(), box.seen.size());
}

TEST(MakeBox, HangsHighAndNeverSinks) {
  BoxInView high(0.1, 0), sunk(-0.01, 0), nowhere(0, 0.02);
  EXPECT_NEAR(LowCornerOf(high.Made(kFloorAtZero)).z(), 0.1, kSeenEnd_m);
  const Solid cut = sunk.Made(kFloorAtZero);
  EXPECT_NEAR(LowCornerOf(cut).z(), 0, kSeenExact_m);
  EXPECT_NEAR(std::get<Box>(cut.shape).size_m.z(), 0.05, kSeenExact_m);
  EXPECT_NEAR(LowCornerOf(nowhere.Made(Ground())).z(), 0.02, kSeenEnd_m);
}

TEST(CanonicalBoxAxes, AreTheSameHoweverTheAxesAreNamed) {
  const Matrix3 upright = Eigen::AngleAxisd(0.3, Vector3::UnitZ()).toRotationMatrix();
  for (int z = 0; z < 3; ++z) {
    for (const int x : {(z + 1) % 3, (z + 2) % 3}) {
      for (const Vector2& sign : {Vector2(1, 1), Vector2(1, -1), Vector2(-1, 1), Vector2(-1, -1)}) {
        Matrix3 named;
        named.col(2) = sign.x() * upright.col(z);
        named.col(0) = sign.y() * upright.col(x);
        named.col(1) = named.col(2).cross(named.col(0));
        EXPECT_LT((CanonicalBoxAxes(named) - upright).norm(), kSeenExact_m) << z << x;
      }
    }
  }
}

}  // namespace
}  // namespace cwm::perception
