#include "perception/track/object_association.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <vector>

#include "tests/perception/track/head_on.h"

namespace cwm::perception {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;
using Outcome = Association::Outcome;

const Vector3 kPacket_m(0.2, 0.2, 0.1);

HeadOnBox PacketAt(double x_m, double y_m) { return {{x_m, y_m, 1.35}, kPacket_m}; }

// The only entry for a known object or for an object of the scene; an invalid entry if there is
// none or there are several.
Association OfKnown(const std::vector<Association>& all, int known) {
  EXPECT_EQ(std::ranges::count(all, known, &Association::known), 1);
  const auto found = std::ranges::find(all, known, &Association::known);
  return found == all.end() ? Association{.known = -2} : *found;
}
Association OfObject(const std::vector<Association>& all, int object) {
  EXPECT_EQ(std::ranges::count(all, object, &Association::object), 1);
  const auto found = std::ranges::find(all, object, &Association::object);
  return found == all.end() ? Association{.object = -2} : *found;
}

TEST(AssociateObjects, KeepsMovesAndAddsByPlaceAndNotByOrder) {
  const std::vector<KnownObject> known = {KnownBox("left", PacketAt(-0.35, -0.2)),
                                          KnownBox("right", PacketAt(0.35, -0.2))};
  // The right one is in its place, the left one elsewhere, and a smaller one is new.
  const HeadOnScan scan(
      {PacketAt(0.35, -0.2), {{0, 0.25, 1.3}, {0.06, 0.06, 0.1}}, PacketAt(-0.3, 0.25)});
  const auto result = AssociateObjects(known, scan.Scene(), scan.evidence());
  EXPECT_THAT(result, SizeIs(3));
  const Association right = OfKnown(result, 1);
  EXPECT_EQ(right.outcome, Outcome::kKeep);
  EXPECT_EQ(right.object, 0);
  EXPECT_TRUE(right.X_WO.matrix() == known[1].X_WO.matrix());  // not touched at all
  const Association left = OfKnown(result, 0);
  EXPECT_EQ(left.outcome, Outcome::kMove);
  EXPECT_EQ(left.object, 2);
  EXPECT_LT((left.X_WO.translation() - (kHeadOnSensor_W + Vector3(-0.3, 0.25, 1.35))).norm(),
            0.001);
  EXPECT_LT(RotationAngle_rad(left.X_WO.linear(), Matrix3::Identity()), 0.01);
  EXPECT_EQ(OfObject(result, 1).outcome, Outcome::kAdd);
  EXPECT_EQ(OfObject(result, 1).known, -1);
}

// Both are gone, and the other one fits a little better, by the errors of the models.
TEST(AssociateObjects, GivesWhatComesBackTheNameOfTheAlikeOneThatWasThere) {
  HeadOnBox measured = PacketAt(-0.3, 0);
  measured.size_m.x() = 0.203;
  std::vector<KnownObject> known = {KnownBox("a twin", PacketAt(0.3, 0)), KnownBox("b", measured)};
  for (KnownObject& object : known) object.is_gone = true;
  const HeadOnScan scan({PacketAt(-0.27, 0.02)});
  const auto back = OfObject(AssociateObjects(known, scan.Scene(), scan.evidence()), 0);
  EXPECT_EQ(back.outcome, Outcome::kMove);
  EXPECT_EQ(back.known, 1);
  // Elsewhere nothing tells them apart but the fit.
  const HeadOnScan elsewhere({PacketAt(0, 0.25)});
  const auto moved = OfObject(AssociateObjects(known, elsewhere.Scene(), elsewhere.evidence()), 0);
  EXPECT_EQ(moved.outcome, Outcome::kMove);
  EXPECT_EQ(moved.known, 0);
}

TEST(AssociateObjects, LetsRaysJudgeWhatIsNotDetected) {
  const HeadOnBox board{{0.3, 0, 0.9}, {0.3, 0.4, 0.02}};
  const std::vector<KnownObject> known = {
      KnownBox("gone", PacketAt(-0.3, 0)), KnownBox("hidden", PacketAt(0.42, 0)),
      KnownBox("out of view", PacketAt(2, 0)), KnownBox("the board", board)};
  const HeadOnScan scan({board});
  SceneInterpretation scene = scan.Scene();
  scene.objects.clear();
  const auto result = AssociateObjects(known, scene, scan.evidence());
  EXPECT_THAT(result, SizeIs(4));
  EXPECT_EQ(OfKnown(result, 0).outcome, Outcome::kRemove);
  EXPECT_EQ(OfKnown(result, 1).outcome, Outcome::kOcclude);
  EXPECT_EQ(OfKnown(result, 2).outcome, Outcome::kKeep);
  EXPECT_EQ(OfKnown(result, 3).outcome, Outcome::kKeep);  // rays end on it
  for (const Association& one : result) EXPECT_EQ(one.object, -1);
  EXPECT_THAT(AssociateObjects({}, scene, scan.evidence()), IsEmpty());
}

TEST(AssociateObjects, ReplacesAModelThatExplainsSomeOfWhatStandsInItsPlace) {
  const HeadOnScan scan({{{0, 0.15, 1.35}, {0.2, 0.5, 0.1}}});  // the known one is 40 % of it
  const std::vector<KnownObject> known = {KnownBox("packet", PacketAt(0, 0))};
  const auto result = AssociateObjects(known, scan.Scene(), scan.evidence());
  ASSERT_THAT(result, SizeIs(1));
  EXPECT_EQ(result[0].outcome, Outcome::kReplace);
  EXPECT_EQ(result[0].known, 0);
  EXPECT_EQ(result[0].object, 0);
  EXPECT_TRUE(result[0].X_WO.matrix() == known[0].X_WO.matrix());
}

TEST(AssociateObjects, GivesADetectionToOneAloneAndMakesNothingOfWhatIsExplained) {
  const HeadOnScan scan({PacketAt(0, 0)});
  SceneInterpretation scene = scan.Scene();
  // Ties are broken by name; the other one is there as well, because rays end on it.
  std::vector<KnownObject> known = {KnownBox("b", PacketAt(0, 0)), KnownBox("a", PacketAt(0, 0))};
  auto result = AssociateObjects(known, scene, scan.evidence());
  EXPECT_THAT(result, SizeIs(2));
  EXPECT_EQ(OfKnown(result, 1).object, 0);
  EXPECT_EQ(OfKnown(result, 0).object, -1);
  EXPECT_EQ(OfKnown(result, 0).outcome, Outcome::kKeep);
  // The larger of two pieces stands for the object, although it comes last.
  known.pop_back();
  scene.objects.push_back(scene.objects[0]);
  const auto is_left = [](const Eigen::Vector3f& p) { return p.x() < -0.05f; };  // a quarter
  std::erase_if(scene.objects[0].points_L, std::not_fn(is_left));
  std::erase_if(scene.objects[1].points_L, is_left);
  result = AssociateObjects(known, scene, scan.evidence());
  EXPECT_THAT(result, SizeIs(2));
  EXPECT_EQ(OfKnown(result, 0).object, 1);
  EXPECT_EQ(OfObject(result, 0).outcome, Outcome::kExplained);
  EXPECT_EQ(OfObject(result, 0).known, -1);
  // A user's object explains both, and does not appear in the result.
  known[0].owned_by_user = true;
  result = AssociateObjects(known, scene, scan.evidence());
  EXPECT_THAT(result, SizeIs(2));
  EXPECT_EQ(OfObject(result, 0).outcome, Outcome::kExplained);
  EXPECT_EQ(OfObject(result, 1).outcome, Outcome::kExplained);
  for (const Association& one : result) EXPECT_EQ(one.known, -1);
}

}  // namespace
}  // namespace cwm::perception
