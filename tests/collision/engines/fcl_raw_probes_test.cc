// Answers of FCL 0.7.0 that the engine does not use, with the reasons why. If a newer FCL fails a
// test here, its defect is fixed, and the workaround may be removed.
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/continuous_collision.h>
#include <gtest/gtest.h>

#include <memory>
#include <numbers>

#include "tests/contract/catalogue.h"

namespace cwm::collision {
namespace {

Pose TurnedBy(double angle_rad) {
  return Pose(Eigen::AngleAxisd(angle_rad, Vector3::UnitZ()).toRotationMatrix());
}

// With its defaults FCL's continuous collision only moves the translation, in ten steps, and
// reports that a rod turning on the spot through a post is free. Motions are therefore not checked
// with FCL.
TEST(FclRawProbe, ContinuousCollisionMissesTheRodThatTurnsThroughAPost) {
  const fcl::Boxd rod(1, 0.05, 0.05), post(0.05, 0.05, 1);
  const Pose X_WP = MakeTranslation(0.28, 0.28, 0);
  const Pose start = TurnedBy(0), end = TurnedBy(std::numbers::pi / 2);
  fcl::ContinuousCollisionResultd swept;
  fcl::continuousCollide(&rod, start, end, &post, X_WP, X_WP, fcl::ContinuousCollisionRequestd(),
                         swept);
  EXPECT_FALSE(swept.is_collide);

  const Pose halfway = TurnedBy(std::numbers::pi / 4);
  fcl::CollisionResultd there;
  EXPECT_GT(fcl::collide(&rod, halfway, &post, X_WP, fcl::CollisionRequestd(), there), 0u);
  // The exact engine finds the collision at the middle state.
  const Engine& exact = GetEngine(EngineKind::kExact);
  const PlacedShape our_rod = Place(exact, Box{{1, 0.05, 0.05}}, halfway);
  const PlacedShape our_post = Place(exact, Box{{0.05, 0.05, 1}}, X_WP);
  EXPECT_TRUE(exact.Collides(our_rod.get(), our_post.get()));
}

// For concentric round shapes FCL's contact has a normal of length 0.
TEST(FclRawProbe, AContactOfConcentricSpheresHasNoNormal) {
  const fcl::Sphered sphere(0.5);
  const fcl::CollisionRequestd request(/*num_max_contacts=*/1, /*enable_contact=*/true);
  fcl::CollisionResultd result;
  const Pose I = Pose::Identity();
  ASSERT_EQ(fcl::collide(&sphere, I, &sphere, I, request, result), 1u);
  EXPECT_EQ(result.getContact(0).normal.norm(), 0);
}

// Every engine returns a unit normal for shapes that touch up to rounding, or are concentric.
TEST(FclRawProbe, NoEngineOfOursGivesATouchingContactWithoutANormal) {
  const Shape shapes[] = {Sphere{0.5}, Box{{1, 1, 1}}, Cylinder{0.5, 1}, Cone{0.5, 0.5, 1},
                          Capsule{0.5, 1}};
  for (const EngineKind kind : {EngineKind::kExact, EngineKind::kFcl, EngineKind::kBullet}) {
    const Engine& engine = GetEngine(kind);
    for (const Shape& a : shapes) {
      for (const Shape& b : shapes) {
        for (const double x_m : {0.0, 1 - 1e-12, 1.0, 1 + 1e-12}) {
          const PlacedShape placed_a = Place(engine, a, Pose::Identity());
          const PlacedShape placed_b = Place(engine, b, MakeTranslation(x_m, 0, 0));
          std::vector<PairDistance> contacts;
          engine.Contacts(placed_a.get(), placed_b.get(), 0.01, 4, contacts);
          ASSERT_FALSE(contacts.empty()) << NameOf(kind);
          for (const PairDistance& contact : contacts) {
            EXPECT_NEAR(contact.normal.norm(), 1, 1e-9) << NameOf(kind) << ' ' << x_m;
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace cwm::collision
