#include "collision/kernels/contact_patch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <tuple>

#include "collision/geometry/signed_distance.h"
#include "collision/geometry/tessellate.h"
#include "collision/kernels/contact_feature.h"
#include "tests/collision/kernels/random_pairs.h"

namespace cwm::collision {
namespace {

using ::testing::SizeIs;

constexpr double kRounding_m = 1e-12;
constexpr double kDepth_m = 1e-3;
// measured: the accuracy of iterative kernels for shapes of some decimetres, see
// collision/README.md.
constexpr double kIterative_m = 1e-8;
// measured: the accuracy of the deepest point of round shapes, 5e-6 of the size, see
// collision/kernels/README.md.
constexpr double kWitness_m = 1e-6;

struct Solid {
  Shape shape;
  Pose X_WS = Pose::Identity();
};

std::vector<PairDistance> ContactsOf(const Solid& a, const Solid& b, double max_distance_m = 0,
                                     int max_count = 16) {
  const auto prepared_a = PrepareExact(a.shape), prepared_b = PrepareExact(b.shape);
  std::vector<PairDistance> contacts;
  ExactContacts({*prepared_a, a.X_WS}, {*prepared_b, b.X_WS}, {max_distance_m, max_count},
                contacts);
  return contacts;
}

Pose TurnedAbout(const Vector3& axis, double angle_rad, const Vector3& at) {
  return MakePose(at, Quaternion(Eigen::AngleAxisd(angle_rad, axis.normalized())));
}

bool Holds(const std::vector<PairDistance>& contacts, const Vector3& point_a, double within_m) {
  return std::any_of(contacts.begin(), contacts.end(), [&](const PairDistance& contact) {
    return (contact.point_a - point_a).norm() <= within_m;
  });
}

Shape HullOf(const Box& box) {
  TriangleMesh mesh;
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      for (const double z : {-0.5, 0.5}) {
        mesh.vertices.push_back(box.size_m.cwiseProduct(Vector3(x, y, z)));
      }
    }
  }
  return Convex{std::make_shared<const TriangleMesh>(ConvexHull3(mesh.vertices))};
}

Plate SquarePlate(double half_m, double thickness_m) {
  return {{{-half_m, -half_m}, {half_m, -half_m}, {half_m, half_m}, {-half_m, half_m}},
          {},
          thickness_m};
}

const Box kBox{{0.2, 0.1, 0.3}};
const Pose kSunk = MakeTranslation(0.4, -0.2, 0.15 - kDepth_m);  // the box, sunk below z = 0

TEST(ContactPatch, OfABoxFlatOnAHalfSpaceIsItsFourCorners) {
  for (const Shape& box : {Shape(kBox), HullOf(kBox)}) {
    const auto contacts = ContactsOf({HalfSpace{}}, {box, kSunk});
    ASSERT_THAT(contacts, SizeIs(4));
    for (const PairDistance& contact : contacts) {
      EXPECT_NEAR(contact.distance_m, -kDepth_m, kRounding_m);
      EXPECT_EQ(contact.normal, Vector3::UnitZ());
      EXPECT_EQ(contact.accuracy, Accuracy::kExact);
      EXPECT_NEAR((contact.point_b - contact.point_a - Vector3(0, 0, -kDepth_m)).norm(), 0,
                  kRounding_m);
    }
    for (const double x : {0.3, 0.5}) {
      for (const double y : {-0.25, -0.15}) {
        EXPECT_TRUE(Holds(contacts, {x, y, 0}, kRounding_m));
      }
    }
  }
}

TEST(ContactPatch, OfABoxFlatOnAnythingFlatHasItsFourCorners) {
  const std::vector<Solid> tables = {{Box{{2, 2, 0.1}}, MakeTranslation(0, 0, -0.05)},
                                     {HullOf(Box{{2, 2, 0.1}}), MakeTranslation(0, 0, -0.05)},
                                     {SquarePlate(1, 0.1)},
                                     {Cylinder{1, 0.1}, MakeTranslation(0, 0, -0.05)},
                                     {Cone{1.5, 1, 0.1}, MakeTranslation(0, 0, -0.05)}};
  for (const Solid& table : tables) {
    for (const Shape& box : {Shape(kBox), HullOf(kBox)}) {
      const auto contacts = ContactsOf(table, {box, kSunk});
      const std::string_view name = NameOf(KindOf(table.shape));
      ASSERT_GE(contacts.size(), 4u) << name;
      ASSERT_LE(contacts.size(), 5u) << name;  // the deepest may be inside the patch
      for (const double x : {0.3, 0.5}) {
        for (const double y : {-0.25, -0.15}) {
          EXPECT_TRUE(Holds(contacts, {x, y, 0}, kIterative_m)) << name;
        }
      }
      for (const PairDistance& contact : contacts) {
        EXPECT_NEAR(contact.distance_m, -kDepth_m, kIterative_m) << name;
      }
    }
  }
}

TEST(ContactPatch, OverhangingEndsAtTheBorder) {
  const Solid table{Box{{2, 2, 0.1}}, MakeTranslation(0, 0, -0.05)};
  const auto contacts =
      ContactsOf(table, {Box{{0.4, 0.2, 0.2}}, MakeTranslation(1, 0, 0.1 - kDepth_m)});
  for (const double x : {0.8, 1.0}) {
    for (const double y : {-0.1, 0.1}) EXPECT_TRUE(Holds(contacts, {x, y, 0}, kIterative_m));
  }
  for (const PairDistance& contact : contacts) EXPECT_LE(contact.point_a.x(), 1 + kIterative_m);
}

TEST(ContactPatch, OfABoxOnItsEdgeIsTheTwoEndsOfTheEdge) {
  const Pose on_edge = TurnedAbout(Vector3::UnitX(), std::numbers::pi / 4,
                                   {0, 0, 0.1 * std::numbers::sqrt2 - kDepth_m});
  const Shape box = Box{{0.4, 0.2, 0.2}};
  for (const Solid& table : {Solid{HalfSpace{}}, Solid{SquarePlate(1, 0.5)},
                             Solid{Box{{2, 2, 1}}, MakeTranslation(0, 0, -0.5)}}) {
    const auto contacts = ContactsOf(table, {box, on_edge});
    EXPECT_TRUE(Holds(contacts, {-0.2, 0, 0}, kIterative_m));
    EXPECT_TRUE(Holds(contacts, {0.2, 0, 0}, kIterative_m));
    EXPECT_LE(contacts.size(), 3u);
    for (const PairDistance& contact : contacts) {
      EXPECT_NEAR(contact.point_a.y(), 0, kIterative_m);
      EXPECT_NEAR(contact.distance_m, -kDepth_m, kIterative_m);
    }
  }
}

TEST(ContactPatch, OfABoxOnACornerIsThatCorner) {
  const Matrix3 R =
      Quaternion::FromTwoVectors(Vector3(1, 1, 1), Vector3(0, 0, -1)).toRotationMatrix();
  Pose X_WB = Pose::Identity();
  X_WB.linear() = R;
  X_WB.translation().z() = 0.1 * std::sqrt(3.0) - kDepth_m;
  EXPECT_THAT(ContactsOf({HalfSpace{}}, {Box{{0.2, 0.2, 0.2}}, X_WB}), SizeIs(1));
}

TEST(ContactPatch, HasADepthForEachPointOfWhatLeans) {
  const double lean = 0.5 * kMaxTilt, half_m = 0.1;
  const Pose X_WB = TurnedAbout(Vector3::UnitY(), lean, {0, 0, 0.1});
  const auto contacts = ContactsOf({HalfSpace{}}, {Box{{0.2, 0.2, 0.2}}, X_WB}, 0.01);
  ASSERT_THAT(contacts, SizeIs(4));
  for (std::size_t i = 0; i < 4; ++i) {  // the two at +x are lower
    const double side = i < 2 ? 1 : -1;
    const double z_m = 0.1 - half_m * std::cos(lean) - side * half_m * std::sin(lean);
    EXPECT_NEAR(contacts[i].distance_m, z_m, kRounding_m);
    EXPECT_NEAR(contacts[i].point_b.z(), z_m, kRounding_m);
  }
  EXPECT_THAT(ContactsOf({HalfSpace{}}, {Box{{0.2, 0.2, 0.2}}, X_WB}), SizeIs(2));
}

TEST(ContactPatch, OfALyingCylinderIsTheEndsOfItsLine) {
  const Pose lying =
      TurnedAbout(Vector3::UnitY(), std::numbers::pi / 2, {0.1, 0.2, 0.05 - kDepth_m});
  for (const Shape& round : {Shape(Cylinder{0.05, 0.3}), Shape(Capsule{0.05, 0.3})}) {
    for (const Solid& table : {Solid{SquarePlate(1, 0.2)}, Solid{HalfSpace{}},
                               Solid{Box{{2, 2, 1}}, MakeTranslation(0, 0, -0.5)}}) {
      const auto contacts = ContactsOf(table, {round, lying});
      EXPECT_TRUE(Holds(contacts, {-0.05, 0.2, 0}, kIterative_m));
      EXPECT_TRUE(Holds(contacts, {0.25, 0.2, 0}, kIterative_m));
      EXPECT_LE(contacts.size(), 3u);
      for (const PairDistance& contact : contacts) {
        EXPECT_NEAR(contact.point_a.y(), 0.2, kWitness_m);
        EXPECT_NEAR(contact.distance_m, -kDepth_m, kIterative_m);
      }
    }
  }
}

TEST(ContactPatch, OfACylinderThatOverhangsIsTheLineOnTheTable) {
  const Pose lying = TurnedAbout(Vector3::UnitY(), std::numbers::pi / 2, {1, 0, 0.05 - kDepth_m});
  const auto contacts = ContactsOf({SquarePlate(1, 0.2)}, {Cylinder{0.05, 0.4}, lying});
  EXPECT_TRUE(Holds(contacts, {0.8, 0, 0}, kIterative_m));
  EXPECT_TRUE(Holds(contacts, {1, 0, 0}, kIterative_m));
}

TEST(ContactPatch, OfAStandingCylinderSpansItsDisc) {
  const Solid cylinder{Cylinder{0.05, 0.3}, MakeTranslation(0.1, 0.2, 0.15 - kDepth_m)};
  for (const Solid& table : {Solid{SquarePlate(1, 0.2)}, Solid{HalfSpace{}},
                             Solid{Box{{2, 2, 1}}, MakeTranslation(0, 0, -0.5)}}) {
    const auto contacts = ContactsOf(table, cylinder);
    ASSERT_GE(contacts.size(), 4u);
    int on_rim = 0;
    Vector3 sum = Vector3::Zero();
    for (const PairDistance& contact : contacts) {
      EXPECT_NEAR(contact.distance_m, -kDepth_m, kIterative_m);
      const Vector3 off = contact.point_a - Vector3(0.1, 0.2, 0);
      if (std::abs(off.norm() - 0.05) > kIterative_m) continue;
      ++on_rim;
      sum += off;
    }
    EXPECT_EQ(on_rim, 4);
    EXPECT_NEAR(sum.norm(), 0, kIterative_m);  // opposite each other
  }
}

TEST(ContactPatch, OfStackedCylindersLiesInBothDiscs) {
  const Solid lower{Cylinder{0.1, 0.2}, MakeTranslation(0, 0, -0.1)};
  const Solid upper{Cylinder{0.1, 0.2}, MakeTranslation(0.1, 0, 0.1 - kDepth_m)};
  const auto contacts = ContactsOf(lower, upper);
  ASSERT_GE(contacts.size(), 4u);
  for (const PairDistance& contact : contacts) {
    EXPECT_LE(contact.point_a.norm(), 0.1 + kIterative_m);
    EXPECT_LE((contact.point_b - Vector3(0.1, 0, -kDepth_m)).norm(), 0.1 + kIterative_m);
  }
}

TEST(ContactPatch, OfParallelRoundsIsALineAndOfCrossingOnesAPoint) {
  const Pose beside = MakeTranslation(0.1 - kDepth_m, 0, 0.1);
  for (const Shape& round : {Shape(Cylinder{0.05, 0.3}), Shape(Capsule{0.05, 0.3})}) {
    const auto contacts = ContactsOf({round}, {round, beside});
    EXPECT_TRUE(Holds(contacts, {0.05, 0, -0.05}, kIterative_m));
    EXPECT_TRUE(Holds(contacts, {0.05, 0, 0.15}, kIterative_m));
    const Pose crossing = TurnedAbout(Vector3::UnitX(), 0.3, {0.1 - kDepth_m, 0, 0});
    EXPECT_THAT(ContactsOf({round}, {round, crossing}), SizeIs(1));
  }
}

TEST(ContactPatch, OfASphereIsAPoint) {
  for (const Solid& table : {Solid{SquarePlate(1, 0.2)}, Solid{HalfSpace{}},
                             Solid{Box{{2, 2, 1}}, MakeTranslation(0, 0, -0.5)}}) {
    EXPECT_THAT(ContactsOf(table, {Sphere{0.1}, MakeTranslation(0, 0, 0.1 - kDepth_m)}), SizeIs(1));
  }
}

TEST(ContactPatch, SpansPiecesOfAPlateButNoHole) {
  Plate frame = SquarePlate(1, 0.1);
  frame.holes = {{{-0.5, -0.5}, {-0.5, 0.5}, {0.5, 0.5}, {0.5, -0.5}}};
  const auto contacts =
      ContactsOf({frame}, {Box{{1.6, 1.6, 0.2}}, MakeTranslation(0, 0, 0.1 - kDepth_m)});
  for (const double x : {-0.8, 0.8}) {
    for (const double y : {-0.8, 0.8}) EXPECT_TRUE(Holds(contacts, {x, y, 0}, kIterative_m));
  }
  // A box in the hole touches one side, and none of the cuts between the pieces.
  const auto inside =
      ContactsOf({frame}, {Box{{0.2, 0.2, 0.2}}, MakeTranslation(0.4 + kDepth_m, 0, 0)});
  EXPECT_GE(inside.size(), 4u);
  for (const PairDistance& contact : inside) {
    EXPECT_NEAR(contact.point_a.x(), 0.5, kIterative_m);
    EXPECT_NEAR(contact.distance_m, -kDepth_m, kIterative_m);
  }
}

TEST(ContactPatch, OfManySidesIsTold) {
  Plate disc{{}, {}, 0.1};
  for (int i = 0; i < 400; ++i) {
    const double angle = 2 * std::numbers::pi * i / 400;
    disc.outline.emplace_back(std::cos(angle), std::sin(angle));
  }
  const Pose upside_down = TurnedAbout(Vector3::UnitX(), std::numbers::pi, {0, 0, -kDepth_m});
  const auto contacts = ContactsOf({HalfSpace{}}, {disc, upside_down});
  ASSERT_GE(contacts.size(), 4u);
  for (const PairDistance& contact : contacts) {
    EXPECT_NEAR(contact.point_a.norm(), 1, kRounding_m);
    EXPECT_NEAR(contact.distance_m, -kDepth_m, kRounding_m);
  }
}

TEST(ContactPatch, KeepsToTheLimits) {
  for (const int most : {0, 1, 2, 3}) {
    const auto contacts = ContactsOf({HalfSpace{}}, {kBox, kSunk}, 0, most);
    EXPECT_THAT(contacts, SizeIs(static_cast<std::size_t>(most)));
  }
  EXPECT_THAT(ContactsOf({HalfSpace{}}, {kBox, kSunk}, -1.01 * kDepth_m), SizeIs(0));
  EXPECT_THAT(ContactsOf({HalfSpace{}}, {kBox, kSunk}, -0.99 * kDepth_m), SizeIs(4));
}

struct Scene {
  Solid a, b;
};

std::vector<Scene> Scenes() {
  const double tilt = 0.5 * kMaxTilt;
  return {
      {{HalfSpace{}}, {kBox, kSunk}},
      {{SquarePlate(1, 0.1)}, {kBox, kSunk}},
      {{Box{{2, 2, 1}}, MakeTranslation(0, 0, -0.5)},
       {kBox, TurnedAbout({1, 0.3, 0}, tilt, {0.1, 0.1, 0.15})}},
      {{HullOf(Box{{2, 2, 1}}), MakeTranslation(0, 0, -0.5)}, {HullOf(kBox), kSunk}},
      {{SquarePlate(1, 0.1)}, {Cylinder{0.05, 0.3}, MakeTranslation(0.1, 0.1, 0.15 - kDepth_m)}},
      {{SquarePlate(1, 0.1)},
       {Capsule{0.05, 0.3},
        TurnedAbout(Vector3::UnitY(), std::numbers::pi / 2 + tilt, {0.1, 0.2, 0.05})}},
      {{HalfSpace{}}, {Cone{0.1, 0.05, 0.2}, MakeTranslation(0, 0, 0.1 - kDepth_m)}}};
}

bool HoldsAllBut(std::size_t first, const std::vector<PairDistance>& contacts,
                 const std::vector<PairDistance>& others) {
  return std::all_of(others.begin() + static_cast<std::ptrdiff_t>(first), others.end(),
                     [&](const PairDistance& other) {
                       return std::any_of(
                           contacts.begin(), contacts.end(), [&](const PairDistance& contact) {
                             return (contact.point_a - other.point_a).norm() <= kIterative_m &&
                                    (contact.point_b - other.point_b).norm() <= kIterative_m &&
                                    (contact.normal - other.normal).norm() <= kIterative_m &&
                                    std::abs(contact.distance_m - other.distance_m) <= kIterative_m;
                           });
                     });
}

// Either of two equally deep points may be the first; all others must agree.
void ExpectSamePatch(const std::vector<PairDistance>& result,
                     const std::vector<PairDistance>& expected) {
  EXPECT_GE(result.size(), 2u);
  EXPECT_TRUE(HoldsAllBut(1, result, expected));
  EXPECT_TRUE(HoldsAllBut(1, expected, result));
}

TEST(ContactPatch, IsMirroredWhenTheTwoChangePlaces) {
  for (const Scene& scene : Scenes()) {
    auto swapped = ContactsOf(scene.b, scene.a, 0.005);
    for (PairDistance& contact : swapped) {
      std::swap(contact.point_a, contact.point_b);
      contact.normal = -contact.normal;
    }
    ExpectSamePatch(swapped, ContactsOf(scene.a, scene.b, 0.005));
  }
}

TEST(ContactPatch, MovesWithBoth) {
  RandomPairs random(5);
  for (const Scene& scene : Scenes()) {
    const auto still = ContactsOf(scene.a, scene.b, 0.005);
    for (int i = 0; i < 20; ++i) {
      const Pose X_GF = random.AnyPose(10);
      auto expected = still;
      for (PairDistance& contact : expected) {
        contact.point_a = X_GF * contact.point_a;
        contact.point_b = X_GF * contact.point_b;
        contact.normal = X_GF.linear() * contact.normal;
      }
      const auto moved = ContactsOf({scene.a.shape, X_GF * scene.a.X_WS},
                                    {scene.b.shape, X_GF * scene.b.X_WS}, 0.005);
      ExpectSamePatch(moved, expected);
    }
  }
}

Shape MeshOf(const Box& box) { return MakeMesh(Tessellate(box)); }

TEST(ContactPatch, OfAMeshThatStandsFlatIsItsCorners) {
  TriangleMesh inward = Tessellate(kBox);
  for (auto& triangle : inward.triangles) std::swap(triangle[1], triangle[2]);
  const std::vector<Solid> tables = {{HalfSpace{}},
                                     {Box{{2, 2, 0.1}}, MakeTranslation(0, 0, -0.05)},
                                     {SquarePlate(1, 0.1)},
                                     {HullOf(Box{{2, 2, 0.1}}), MakeTranslation(0, 0, -0.05)},
                                     {MeshOf(Box{{2, 2, 0.1}}), MakeTranslation(0, 0, -0.05)}};
  for (const Solid& table : tables) {
    for (const Shape& box : {Shape(kBox), MeshOf(kBox), Shape(MakeMesh(inward))}) {
      if (KindOf(table.shape) != ShapeKind::kMesh && KindOf(box) != ShapeKind::kMesh) continue;
      SCOPED_TRACE(std::string(NameOf(KindOf(table.shape))) + " " +
                   std::string(NameOf(KindOf(box))));
      for (const bool table_first : {true, false}) {
        const auto contacts = table_first ? ContactsOf(table, {box, kSunk}, 0.005)
                                          : ContactsOf({box, kSunk}, table, 0.005);
        ASSERT_GE(contacts.size(), 4u);
        ASSERT_LE(contacts.size(), 5u);
        for (const double x : {0.3, 0.5}) {
          for (const double y : {-0.25, -0.15}) {
            EXPECT_TRUE(Holds(contacts, {x, y, table_first ? 0 : -kDepth_m}, kIterative_m))
                << x << " " << y;
          }
        }
        for (const PairDistance& contact : contacts) {
          EXPECT_NEAR(contact.distance_m, -kDepth_m, kIterative_m);
          EXPECT_NEAR(contact.normal.z(), table_first ? 1 : -1, kIterative_m);
        }
      }
    }
  }
}

// Three legs that end in points.
TEST(ContactPatch, OfAMeshOnItsLegsIsTheirTips) {
  const std::vector<Vector3> tips = {{0.2, 0, 0}, {-0.1, 0.15, 0}, {-0.1, -0.15, 0}};
  TriangleMesh stool;
  for (const Vector3& tip : tips) {
    const auto first = static_cast<std::uint32_t>(stool.vertices.size());
    stool.vertices.insert(stool.vertices.end(),
                          {tip, tip + Vector3(0.02, 0, 0.3), tip + Vector3(-0.02, 0.02, 0.3),
                           tip + Vector3(-0.02, -0.02, 0.3)});
    stool.triangles.insert(stool.triangles.end(), {{first, first + 2, first + 1},
                                                   {first, first + 3, first + 2},
                                                   {first, first + 1, first + 3},
                                                   {first + 1, first + 2, first + 3}});
  }
  const Shape mesh = MakeMesh(std::move(stool));
  ASSERT_TRUE(std::get<Mesh>(mesh).watertight);
  for (const Solid& floor :
       {Solid{HalfSpace{}}, Solid{MeshOf(Box{{2, 2, 0.1}}), MakeTranslation(0, 0, -0.05)},
        Solid{Box{{2, 2, 0.1}}, MakeTranslation(0, 0, -0.05)}}) {
    for (const double height_m : {-1e-3, 1e-3}) {
      const auto contacts = ContactsOf(floor, {mesh, MakeTranslation(0, 0, height_m)}, 0.002);
      ASSERT_THAT(contacts, SizeIs(3)) << NameOf(KindOf(floor.shape)) << " " << height_m;
      for (const Vector3& tip : tips) EXPECT_TRUE(Holds(contacts, tip, 1e-6));
      for (const PairDistance& contact : contacts) {
        EXPECT_NEAR(contact.distance_m, height_m, 1e-6);
      }
    }
    EXPECT_THAT(ContactsOf(floor, {mesh, MakeTranslation(0, 0, -1e-3)}, 0, 2), SizeIs(2));
  }
}

// A field of more triangles than are examined one by one.
TEST(ContactPatch, OfAMeshOfManyTrianglesSpansThemAll) {
  constexpr int kSide = 100;
  TriangleMesh field;
  for (int i = 0; i <= kSide; ++i) {
    for (int k = 0; k <= kSide; ++k) field.vertices.emplace_back(0.01 * i, 0.01 * k, 0);
  }
  const auto at = [](int i, int k) { return static_cast<std::uint32_t>((kSide + 1) * i + k); };
  for (int i = 0; i < kSide; ++i) {
    for (int k = 0; k < kSide; ++k) {
      field.triangles.push_back({at(i, k), at(i + 1, k), at(i + 1, k + 1)});
      field.triangles.push_back({at(i, k), at(i + 1, k + 1), at(i, k + 1)});
    }
  }
  const Solid sheet{MakeMesh(std::move(field))};
  const auto contacts =
      ContactsOf(sheet, {Box{{0.73, 0.51, 0.1}}, MakeTranslation(0.5, 0.5, 0.05 + 1e-3)}, 0.002);
  ASSERT_GE(contacts.size(), 4u);
  for (const double x : {0.135, 0.865}) {
    for (const double y : {0.245, 0.755}) {
      EXPECT_TRUE(Holds(contacts, {x, y, 0}, 1e-6)) << x << " " << y;
    }
  }
  for (const PairDistance& contact : contacts) EXPECT_EQ(contact.accuracy, Accuracy::kSurfaceOnly);
}

// Random shapes in random poses, many of them aligned.
TEST(ContactPatch, LiesOnBothSurfacesAndBeginsWithTheDeepest) {
  constexpr std::array kKinds = {ShapeKind::kSphere, ShapeKind::kBox,      ShapeKind::kCylinder,
                                 ShapeKind::kCone,   ShapeKind::kCapsule,  ShapeKind::kConvex,
                                 ShapeKind::kPlate,  ShapeKind::kHalfSpace};
  constexpr double kShare = 1e-6;  // of the size: flatness of a hull's faces
  RandomPairs random(11);
  int patches = 0;
  for (int i = 0; i < 20'000; ++i) {
    const auto kind_a = static_cast<std::size_t>(random.Index(8));
    const auto kind_b = static_cast<std::size_t>(random.Index(7));
    const PosedPair pair = random.Pair(kKinds[kind_a], kKinds[kind_b]);
    const bool is_endless = KindOf(pair.a) == ShapeKind::kHalfSpace;
    const double size_m = is_endless ? 20 : SizeOf(pair);
    const auto a = PrepareExact(pair.a), b = PrepareExact(pair.b);
    const PairDistance deepest = ExactDistance({*a, pair.X_FA}, {*b, pair.X_FB});
    const double max_distance_m = deepest.distance_m + 0.1 * size_m;
    std::vector<PairDistance> contacts;
    ExactContacts({*a, pair.X_FA}, {*b, pair.X_FB}, {max_distance_m, 8}, contacts);
    ASSERT_GE(contacts.size(), 1u);
    ASSERT_LE(contacts.size(), 1u + kMaxPatchPoints);
    EXPECT_NEAR(contacts[0].distance_m, deepest.distance_m, kShare * size_m);
    if (contacts.size() > 1) ++patches;
    for (std::size_t k = 1; k < contacts.size(); ++k) {
      const PairDistance& contact = contacts[k];
      EXPECT_GE(contact.distance_m, contacts[k - 1].distance_m);
      EXPECT_LT(contact.distance_m, max_distance_m);
      EXPECT_EQ(contact.normal, contacts[0].normal);
      const Vector3 between = contact.point_b - contact.point_a;
      EXPECT_NEAR((between - contact.distance_m * contact.normal).norm(), 0, kShare * size_m);
      for (const auto& [shape, X_FS, point] : {std::tuple(&pair.a, &pair.X_FA, &contact.point_a),
                                               std::tuple(&pair.b, &pair.X_FB, &contact.point_b)}) {
        EXPECT_NEAR(SignedDistance_m(*shape, X_FS->inverse() * *point), 0, kShare * size_m)
            << NameOf(KindOf(pair.a)) << " " << NameOf(KindOf(pair.b));
      }
    }
  }
  EXPECT_GT(patches, 1'000);
}

}  // namespace
}  // namespace cwm::collision
