// Tracking behind the real interpreter, with its own segmentation and fits, on two scans.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "perception/interpret_scene.h"
#include "perception/simulation/virtual_scanner.h"
#include "perception/track/association.h"

namespace cwm::perception {
namespace {

using Outcome = Association::Outcome;

struct InterpretedScan {
  PointCloud cloud;
  SceneInterpretation scene;
};

// Scans the kitchen and interprets the scan; the reported sensor pose is `offset` away from the
// true one.
InterpretedScan ScanAndInterpret(const SimulatedScene& scene, std::uint64_t seed,
                                 const Vector3& offset = Vector3::Zero()) {
  InterpretOptions options;
  options.X_WC = Eigen::Translation3d(offset) * KitchenCamera().X_WC;
  InterpretedScan result{.cloud = Scan(scene, KitchenCamera(), {.seed = seed}).cloud, .scene = {}};
  auto interpreted = InterpretScene(result.cloud, options);
  EXPECT_TRUE(interpreted.ok()) << interpreted.status();
  if (interpreted.ok()) result.scene = *std::move(interpreted);
  return result;
}

std::vector<KnownObject> Remember(const SceneInterpretation& scene) {
  std::vector<KnownObject> known;
  for (const DetectedSupport& support : scene.supports) {
    known.push_back({.name = "support " + std::to_string(known.size()),
                     .kind = KnownObject::Kind::kSupport,
                     .X_WO = support.X_WO,
                     .model = support.model});
  }
  for (const DetectedObject& object : scene.objects) {
    known.push_back({.name = "object " + std::to_string(known.size()),
                     .kind = object.kind == DetectedKind::kObject ? KnownObject::Kind::kObject
                                                                  : KnownObject::Kind::kResidual,
                     .X_WO = object.X_WO,
                     .model = object.model});
  }
  return known;
}

struct Tally {
  std::map<Outcome, int> count;
  std::string words;  // everything that was not kept
};

Tally Count(const std::vector<KnownObject>& known, const InterpretedScan& seen) {
  Tally tally;
  for (const Association& a : Associate(known, seen.scene, seen.cloud, {})) {
    ++tally.count[a.outcome];
    if (a.outcome == Outcome::kKeep) continue;
    const int points =
        a.object >= 0 ? static_cast<int>(seen.scene.objects[a.object].points_L.size()) : 0;
    tally.words += " [" + std::to_string(static_cast<int>(a.outcome)) + ": known " +
                   std::to_string(a.known) + " object " + std::to_string(a.object) + " support " +
                   std::to_string(a.support) + ", " + std::to_string(points) + " points]";
  }
  return tally;
}

TEST(InterpretedScans, AreKeptWhenTheSameScanComesTwice) {
  const InterpretedScan scan = ScanAndInterpret(KitchenCounter(), 1);
  const auto known = Remember(scan.scene);
  ASSERT_GE(known.size(), 8U);  // of the counter
  const Tally tally = Count(known, scan);
  EXPECT_EQ(tally.count.at(Outcome::kKeep), static_cast<int>(known.size())) << tally.words;
  EXPECT_EQ(tally.words, "");
}

TEST(InterpretedScans, AreJudgedTheSameFarFromTheWorldsOrigin) {
  SimulatedScene after = KitchenCounter();
  const auto tea = std::find_if(after.objects.begin(), after.objects.end(),
                                [](const auto& object) { return object.name == "tea"; });
  ASSERT_NE(tea, after.objects.end());
  tea->X_WO.translation() += Vector3(-0.08, 0.10, 0);
  std::vector<Association> judged[2];
  const Vector3 offsets[2] = {Vector3::Zero(), Vector3(1e5, -1e5, 1e5)};
  for (int i = 0; i < 2; ++i) {
    const auto known = Remember(ScanAndInterpret(KitchenCounter(), 1, offsets[i]).scene);
    const InterpretedScan seen = ScanAndInterpret(after, 2, offsets[i]);
    judged[i] = Associate(known, seen.scene, seen.cloud, {});
  }
  ASSERT_EQ(judged[0].size(), judged[1].size());
  int kept = 0;
  for (std::size_t i = 0; i < judged[0].size(); ++i) {
    EXPECT_EQ(judged[0][i].outcome, judged[1][i].outcome) << i;
    EXPECT_EQ(judged[0][i].known, judged[1][i].known) << i;
    EXPECT_EQ(judged[0][i].support, judged[1][i].support) << i;
    EXPECT_EQ(judged[0][i].object, judged[1][i].object) << i;
    kept += judged[0][i].outcome == Outcome::kKeep ? 1 : 0;
  }
  EXPECT_GE(kept, 5);  // a comparison of empty worlds would test nothing
}

TEST(InterpretedScans, AreKeptUnderFreshNoise) {
  const auto known = Remember(ScanAndInterpret(KitchenCounter(), 1).scene);
  ASSERT_GE(known.size(), 8U);  // of the counter
  int kept = 0;
  int all = 0;
  std::string words;
  for (std::uint64_t seed = 2; seed < 5; ++seed) {
    const Tally tally = Count(known, ScanAndInterpret(KitchenCounter(), seed));
    kept += tally.count.at(Outcome::kKeep);
    all += static_cast<int>(known.size());
    words += tally.words + "\n";
  }
  EXPECT_GE(kept, all * 9 / 10) << kept << " of " << all << words;
}

TEST(InterpretedScans, TellARemovedCan) {
  SimulatedScene scene = KitchenCounter();
  const auto known = Remember(ScanAndInterpret(scene, 1).scene);
  const auto can = std::find_if(scene.objects.begin(), scene.objects.end(),
                                [](const auto& object) { return object.name == "soup"; });
  ASSERT_NE(can, scene.objects.end());
  const Vector3 p_W = can->X_WO.translation() + Vector3(0, 0, 0.05);
  scene.objects.erase(can);
  const InterpretedScan after = ScanAndInterpret(scene, 2);
  int removed = 0;
  for (const Association& a : Associate(known, after.scene, after.cloud, {})) {
    if (a.outcome != Outcome::kRemove) continue;
    const KnownObject& gone = known[a.known];
    if (TightBounds(*gone.model, gone.X_WO).contains(p_W)) ++removed;
  }
  EXPECT_EQ(removed, 1);
}

}  // namespace
}  // namespace cwm::perception
