#include "perception/track/association.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <numbers>
#include <numeric>
#include <random>

#include "tests/perception/track/known_truth.h"

namespace cwm::perception {
namespace {

using Outcome = Association::Outcome;

const SensorNoise kNoise{.model = SensorModel::kKinect};

std::string Word(Outcome outcome) {
  switch (outcome) {
    case Outcome::kKeep:
      return "keep";
    case Outcome::kMove:
      return "move";
    case Outcome::kReplace:
      return "replace";
    case Outcome::kAdd:
      return "add";
    case Outcome::kRemove:
      return "remove";
    case Outcome::kOcclude:
      return "occlude";
    case Outcome::kExplained:
      return "explained";
  }
  return "";
}

// Checks the contract that holds always: each known object that the user does not own, each support
// and each detected object appears exactly once.
void ExpectEachOnce(const std::vector<Association>& result, const std::vector<KnownObject>& known,
                    const SceneInterpretation& scene) {
  std::vector<int> of_known(known.size(), 0);
  std::vector<int> of_support(scene.supports.size(), 0);
  std::vector<int> of_object(scene.objects.size(), 0);
  for (const Association& a : result) {
    if (a.known >= 0) ++of_known[a.known];
    if (a.support >= 0) ++of_support[a.support];
    if (a.object >= 0) ++of_object[a.object];
    const bool nothing_detected = a.outcome == Outcome::kRemove || a.outcome == Outcome::kOcclude;
    EXPECT_EQ(nothing_detected, nothing_detected && a.support < 0 && a.object < 0);
    const bool nothing_known = a.outcome == Outcome::kAdd || a.outcome == Outcome::kExplained;
    EXPECT_EQ(nothing_known, a.known < 0);
  }
  for (std::size_t i = 0; i < known.size(); ++i) {
    EXPECT_EQ(of_known[i], known[i].owned_by_user ? 0 : 1) << known[i].name;
  }
  for (const int count : of_support) EXPECT_EQ(count, 1);
  for (const int count : of_object) EXPECT_EQ(count, 1);
}

// The outcome for each known object by name, and for each new detection as "new <name>".
std::map<std::string, std::string> Verdicts(const std::vector<KnownObject>& known,
                                            const TrueScan& seen, const PointCloud& cloud) {
  const auto result = Associate(known, seen.scene, cloud, kNoise);
  ExpectEachOnce(result, known, seen.scene);
  std::map<std::string, std::string> verdicts;
  for (const Association& a : result) {
    const std::string name = a.known >= 0     ? known[a.known].name
                             : a.object >= 0  ? "new " + seen.object_names[a.object]
                             : a.support >= 0 ? "new " + seen.support_names[a.support]
                                              : "nobody";
    verdicts[name] = Word(a.outcome);
  }
  return verdicts;
}

std::map<std::string, std::string> Verdicts(const std::vector<KnownObject>& known,
                                            const TrueScan& seen) {
  return Verdicts(known, seen, seen.scan.cloud);
}

std::map<std::string, std::string> AllKept(const std::vector<KnownObject>& known) {
  std::map<std::string, std::string> verdicts;
  for (const KnownObject& object : known) {
    if (!object.owned_by_user) verdicts[object.name] = "keep";
  }
  return verdicts;
}

class TrackingTheKitchen : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_EQ(known_.size(), before_.objects.size()); }

  const SimulatedScene before_ = KitchenCounter();
  const PinholeCamera camera_ = KitchenCamera();
  const TrueScan first_ = ScanAndInterpret(before_, camera_, 1);
  const std::vector<KnownObject> known_ = Remember(first_);
};

TEST_F(TrackingTheKitchen, KeepsEverythingWhenTheSameScanComesTwice) {
  EXPECT_EQ(Verdicts(known_, first_), AllKept(known_));
}

TEST_F(TrackingTheKitchen, KeepsEverythingUnderFreshNoise) {
  for (std::uint64_t seed = 2; seed < 12; ++seed) {
    EXPECT_EQ(Verdicts(known_, ScanAndInterpret(before_, camera_, seed)), AllKept(known_))
        << "seed " << seed;
  }
}

TEST_F(TrackingTheKitchen, KeepsEverythingWhenThePointsAreShuffled) {
  const TrueScan again = ScanAndInterpret(before_, camera_, 2);
  PointCloud shuffled = again.scan.cloud;
  std::shuffle(shuffled.points.begin(), shuffled.points.end(), std::mt19937_64(3));
  shuffled.width = static_cast<int>(shuffled.points.size());
  shuffled.height = 1;
  EXPECT_EQ(Verdicts(known_, again, shuffled), AllKept(known_));
}

TEST_F(TrackingTheKitchen, MovesWhatMovedAndTouchesNothingElse) {
  for (const char* name : {"soda", "tea", "ball", "cup", "mug"}) {
    SimulatedScene after = before_;
    Pose& X_WO = after.objects[IndexOf(after, name)].X_WO;
    X_WO.translation() += Vector3(0.02, X_WO.translation().y() > 0 ? -0.16 : 0.16, 0);
    X_WO.translation().x() = 0.44;  // the front of the counter is free
    X_WO.linear() = Eigen::AngleAxisd(0.4, Vector3::UnitZ()) * X_WO.linear();
    if (std::string(name) == "ball") X_WO.translation().y() = -0.14;
    const TrueScan seen = ScanAndInterpret(after, camera_, 2);
    auto expected = AllKept(known_);
    expected[name] = "move";
    EXPECT_EQ(Verdicts(known_, seen), expected) << name;
  }
}

TEST_F(TrackingTheKitchen, PutsAMovedModelOntoItsNewPlace) {
  SimulatedScene after = before_;
  Pose& X_WO = after.objects[IndexOf(after, "tea")].X_WO;
  X_WO.translation() += Vector3(-0.08, 0.10, 0);
  X_WO.linear() = Eigen::AngleAxisd(0.5, Vector3::UnitZ()) * X_WO.linear();
  const TrueScan seen = ScanAndInterpret(after, camera_, 2);
  const int tea = IndexOf(known_, "tea");
  int mentioned = 0;
  for (const Association& a : Associate(known_, seen.scene, seen.scan.cloud, kNoise)) {
    if (a.known != tea) continue;
    ++mentioned;
    ASSERT_EQ(a.outcome, Outcome::kMove);
    // Errors of the known fit (1 mm) and of the new points (warp 1.3 mm), 3 sigma of both.
    EXPECT_LT((a.X_WO.translation() - X_WO.translation()).norm(),
              3 * std::hypot(0.001, 0.0013) * 1.7);
    // The same over the lever arm of half the box's length, 65 mm.
    EXPECT_LT(RotationAngle_rad(a.X_WO.linear(), X_WO.linear()), 3 * 0.0016 / 0.065);
  }
  EXPECT_EQ(mentioned, 1);
}

TEST_F(TrackingTheKitchen, NoticesAMoveOfTwoCentimetres) {
  SimulatedScene after = before_;
  after.objects[IndexOf(after, "soup")].X_WO.translation() += Vector3(-0.02, 0, 0);
  auto expected = AllKept(known_);
  expected["soup"] = "move";
  EXPECT_EQ(Verdicts(known_, ScanAndInterpret(after, camera_, 2)), expected);
}

TEST_F(TrackingTheKitchen, RemovesWhatRaysPassThrough) {
  for (const char* name : {"cereal", "tea", "sugar", "soup", "soda", "ball", "cup", "mug"}) {
    SimulatedScene after = before_;
    after.objects.erase(after.objects.begin() + IndexOf(after, name));
    auto expected = AllKept(known_);
    expected[name] = "remove";
    EXPECT_EQ(Verdicts(known_, ScanAndInterpret(after, camera_, 2)), expected) << name;
  }
}

TEST_F(TrackingTheKitchen, AddsWhatIsNew) {
  for (const char* name : {"cereal", "tea", "sugar", "soup", "soda", "ball", "cup", "mug"}) {
    SimulatedScene less = before_;
    less.objects.erase(less.objects.begin() + IndexOf(less, name));
    const auto known = Remember(ScanAndInterpret(less, camera_, 2));
    auto expected = AllKept(known);
    expected["new " + std::string(name)] = "add";
    EXPECT_EQ(Verdicts(known, first_), expected) << name;
  }
}

TEST_F(TrackingTheKitchen, RemovesAndAddsWhenAnotherObjectComesElsewhere) {
  SimulatedScene after = before_;
  const int tea = IndexOf(after, "tea");
  after.objects[tea].name = "bowl";
  after.objects[tea].parts = {
      {.X_FS = MakeTranslation(0, 0, 0.06), .shape = Sphere{.radius_m = 0.06}}};
  after.objects[tea].X_WO = MakeTranslation(0.44, -0.14, 0.9);
  auto expected = AllKept(known_);
  expected["tea"] = "remove";
  expected["new bowl"] = "add";
  EXPECT_EQ(Verdicts(known_, ScanAndInterpret(after, camera_, 2)), expected);
}

TEST_F(TrackingTheKitchen, ReplacesAnObjectThatAnotherOneStandsFor) {
  SimulatedScene after = before_;
  const int cereal = IndexOf(after, "cereal");
  const Vector3 size_m(0.09, 0.19, 0.17);  // deeper, and 10 cm lower than before
  after.objects[cereal].parts = {
      {.X_FS = MakeTranslation(0, 0, 0.085), .shape = Box{.size_m = size_m}}};
  auto expected = AllKept(known_);
  expected["cereal"] = "replace";
  EXPECT_EQ(Verdicts(known_, ScanAndInterpret(after, camera_, 2)), expected);
}

TEST_F(TrackingTheKitchen, KeepsTheNameOfWhatIsHidden) {
  SimulatedScene after = before_;
  SimulatedObject screen{.name = "screen", .parts = {{.shape = Box{.size_m = {0.02, 0.26, 0.36}}}}};
  // In front of the soda can, seen from the camera.
  screen.X_WO = MakePose({0.70, 0.34, 0.9 + 0.18}, Quaternion::Identity());
  after.objects.push_back(screen);
  auto verdicts = Verdicts(known_, ScanAndInterpret(after, camera_, 2));
  EXPECT_EQ(verdicts["soda"], "occlude");
  EXPECT_EQ(verdicts["new screen"], "add");
  for (const char* name : {"counter", "cereal", "tea", "sugar", "soup", "ball", "wall"}) {
    EXPECT_EQ(verdicts[name], "keep") << name;
  }
}

TEST_F(TrackingTheKitchen, KeepsWhatIsOutOfView) {
  PinholeCamera turned = camera_;
  turned.X_WC.linear() =
      Eigen::AngleAxisd(std::numbers::pi, Vector3::UnitZ()) * turned.X_WC.linear();
  SimulatedScene after = before_;
  after.objects.push_back({.name = "floor", .parts = {{.shape = HalfSpace{}}}});
  auto expected = AllKept(known_);
  expected["new floor"] = "add";
  EXPECT_EQ(Verdicts(known_, ScanAndInterpret(after, turned, 2)), expected);
}

TEST_F(TrackingTheKitchen, KeepsEverythingWhenNothingReturns) {
  TrueScan blind = first_;
  blind.scene.objects.clear();
  blind.scene.supports.clear();
  for (auto& p : blind.scan.cloud.points) p.setConstant(std::nanf(""));
  EXPECT_EQ(Verdicts(known_, blind), AllKept(known_));
}

TEST_F(TrackingTheKitchen, MakesNothingOfWhatAUsersObjectExplains) {
  std::vector<KnownObject> known = known_;
  for (const char* name : {"sugar", "counter"}) {
    KnownObject& object = known[IndexOf(known, name)];
    object.owned_by_user = true;
    object.name = "my " + object.name;
  }
  auto expected = AllKept(known);
  expected["new sugar"] = "explained";
  expected["new counter"] = "explained";
  EXPECT_EQ(Verdicts(known, ScanAndInterpret(before_, camera_, 2)), expected);
}

TEST_F(TrackingTheKitchen, NeverNamesWhatUsersOwnEvenWhenItIsGone) {
  std::vector<KnownObject> known = known_;
  known[IndexOf(known, "sugar")].owned_by_user = true;
  SimulatedScene after = before_;
  after.objects.erase(after.objects.begin() + IndexOf(after, "sugar"));
  const auto verdicts = Verdicts(known, ScanAndInterpret(after, camera_, 2));
  EXPECT_EQ(verdicts.count("sugar"), 0U);
  EXPECT_EQ(verdicts, AllKept(known));
}

TEST_F(TrackingTheKitchen, MakesNothingNewOfAnObjectThatWasCutInTwo) {
  TrueScan cut = ScanAndInterpret(before_, camera_, 2);
  const int cereal = IndexOf(cut, "cereal");
  DetectedObject upper = cut.scene.objects[cereal];
  DetectedObject& lower = cut.scene.objects[cereal];
  const double middle_m =
      1.0 - camera_.X_WC.translation().z();  // of the packet, in the level frame
  const auto is_upper = [&](const Eigen::Vector3f& p) { return p.z() > middle_m; };
  ASSERT_GT(std::count_if(lower.points_L.begin(), lower.points_L.end(), is_upper), 100);
  std::erase_if(lower.points_L, is_upper);
  ASSERT_GT(lower.points_L.size(), 100U);
  std::erase_if(upper.points_L, [&](const auto& p) { return !is_upper(p); });
  cut.scene.objects.push_back(upper);
  cut.object_names.push_back("piece");
  auto expected = AllKept(known_);
  expected["new piece"] = "explained";
  auto verdicts = Verdicts(known_, cut);
  if (verdicts.count("new cereal") != 0) {  // either piece may stand for the object
    verdicts["new piece"] = verdicts["new cereal"];
    verdicts.erase("new cereal");
  }
  EXPECT_EQ(verdicts, expected);
}

TEST_F(TrackingTheKitchen, KeepsTwoObjectsThatWereSeenAsOne) {
  TrueScan joined = ScanAndInterpret(before_, camera_, 2);
  auto& objects = joined.scene.objects;
  const int soup = IndexOf(joined, "soup");
  const int cup = IndexOf(joined, "cup");
  auto& points = objects[soup].points_L;
  points.insert(points.end(), objects[cup].points_L.begin(), objects[cup].points_L.end());
  objects.erase(objects.begin() + cup);
  joined.object_names.erase(joined.object_names.begin() + cup);
  auto verdicts = Verdicts(known_, joined);
  verdicts.erase("new soup");
  EXPECT_EQ(verdicts, AllKept(known_));
}

// A small thing on a large one leaves most of the surface of both where it was.
TEST_F(TrackingTheKitchen, ReplacesWhatLostAThingThatWasSeenAsOneWithIt) {
  std::vector<KnownObject> known = known_;
  const int large = IndexOf(known, "cereal"), small = IndexOf(known, "cup");
  HybridModel both = *known[large].model;
  const Pose X_LargeSmall = known[large].X_WO.inverse() * known[small].X_WO;
  for (ShapePart part : known[small].model->shapes) {
    part.X_OS = X_LargeSmall * part.X_OS;
    both.shapes.push_back(std::move(part));
  }
  known[large].model = std::make_shared<const HybridModel>(std::move(both));
  known.erase(known.begin() + small);
  SimulatedScene without = before_;
  without.objects.erase(without.objects.begin() + IndexOf(without, "cup"));
  auto expected = AllKept(known);
  expected["cereal"] = "replace";
  EXPECT_EQ(Verdicts(known, ScanAndInterpret(without, camera_, 2)), expected);
}

// Moves the known objects and the scan, with its sensor, together.
void Shift(const Vector3& by, std::vector<KnownObject>& known, SceneInterpretation& scene) {
  for (KnownObject& object : known) object.X_WO.translation() += by;
  scene.X_WC.translation() += by;
  for (DetectedSupport& support : scene.supports) support.X_WO.translation() += by;
  for (DetectedObject& object : scene.objects) object.X_WO.translation() += by;
}

TEST_F(TrackingTheKitchen, JudgesTheSameFarFromTheWorldsOrigin) {
  const Vector3 far(1e5, -1e5, 1e5);  // as UTM coordinates: floats are 8 mm apart there
  // Poses are rounded to 1.5e-11 m there; refinement divides by directions known to a thousandth.
  constexpr double kRounding_m = 1e-7;
  SimulatedScene after = before_;
  Pose& X_WO = after.objects[IndexOf(after, "tea")].X_WO;
  X_WO.translation() += Vector3(-0.08, 0.10, 0);
  after.objects.erase(after.objects.begin() + IndexOf(after, "sugar"));
  TrueScan seen = ScanAndInterpret(after, camera_, 2);
  const auto near = Associate(known_, seen.scene, seen.scan.cloud, kNoise);
  std::vector<KnownObject> known = known_;
  Shift(far, known, seen.scene);
  const auto shifted = Associate(known, seen.scene, seen.scan.cloud, kNoise);
  ASSERT_EQ(shifted.size(), near.size());
  int moved = 0;
  for (std::size_t i = 0; i < near.size(); ++i) {
    EXPECT_EQ(Word(shifted[i].outcome), Word(near[i].outcome)) << i;
    EXPECT_EQ(shifted[i].known, near[i].known);
    EXPECT_EQ(shifted[i].support, near[i].support);
    EXPECT_EQ(shifted[i].object, near[i].object);
    if (near[i].outcome != Outcome::kMove) continue;
    ++moved;
    EXPECT_LT((shifted[i].X_WO.translation() - near[i].X_WO.translation() - far).norm(),
              kRounding_m);
  }
  EXPECT_EQ(moved, 1);
}

TEST_F(TrackingTheKitchen, GivesTheSameAnswerTwice) {
  const TrueScan seen = ScanAndInterpret(before_, camera_, 2);
  const auto once = Associate(known_, seen.scene, seen.scan.cloud, kNoise);
  const auto again = Associate(known_, seen.scene, seen.scan.cloud, kNoise);
  ASSERT_EQ(once.size(), again.size());
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(once[i].outcome, again[i].outcome);
    EXPECT_EQ(once[i].known, again[i].known);
    EXPECT_EQ(once[i].object, again[i].object);
    EXPECT_TRUE(once[i].X_WO.matrix() == again[i].X_WO.matrix());
  }
}

TEST_F(TrackingTheKitchen, BreaksTiesByName) {
  std::vector<KnownObject> known = known_;
  KnownObject twin = known[IndexOf(known, "soup")];
  twin.name = "another soup";
  known.push_back(twin);
  const TrueScan seen = ScanAndInterpret(before_, camera_, 2);
  const int soup = IndexOf(seen, "soup");
  int of_soup = 0;
  for (const Association& a : Associate(known, seen.scene, seen.scan.cloud, kNoise)) {
    if (a.object != soup) continue;
    ++of_soup;
    ASSERT_GE(a.known, 0);
    EXPECT_EQ(known[a.known].name, "another soup");
  }
  EXPECT_EQ(of_soup, 1);
}

TEST(TrackingTables, KeepsNearlyEverythingOnRandomTables) {
  int kept = 0;
  int all = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const SimulatedScene scene = RandomTable(seed, 8);
    const auto known = Remember(ScanAndInterpret(scene, KitchenCamera(), 2 * seed));
    const TrueScan again = ScanAndInterpret(scene, KitchenCamera(), 2 * seed + 1);
    const auto verdicts = Verdicts(known, again);
    all += static_cast<int>(verdicts.size());
    kept += static_cast<int>(std::count_if(verdicts.begin(), verdicts.end(),
                                           [](const auto& v) { return v.second == "keep"; }));
  }
  ASSERT_GE(all, 10 * 4);  // a table and three objects each
  EXPECT_GE(kept, all * 98 / 100) << kept << " of " << all;
}

TEST(TrackingAnEmptyWorld, AddsAll) {
  const TrueScan first = ScanAndInterpret(KitchenCounter(), KitchenCamera(), 1);
  const auto verdicts = Verdicts({}, first);
  ASSERT_EQ(verdicts.size(), first.scene.objects.size() + first.scene.supports.size());
  for (const auto& [name, word] : verdicts) EXPECT_EQ(word, "add") << name;
}

TEST(TrackingAnEmptyWorld, SurvivesModelsWithoutParts) {
  TrueScan first = ScanAndInterpret(KitchenCounter(), KitchenCamera(), 1);
  std::vector<KnownObject> known(2);
  known[0].name = "no model";
  known[1].name = "no parts";
  known[1].model = std::make_shared<const HybridModel>();
  first.scene.objects[0].model = nullptr;
  first.scene.objects[1].points_L.clear();
  first.scene.supports[0].model = nullptr;
  const auto verdicts = Verdicts(known, first);
  EXPECT_EQ(verdicts.at("no model"), "keep");
  EXPECT_EQ(verdicts.at("no parts"), "keep");
}

}  // namespace
}  // namespace cwm::perception
