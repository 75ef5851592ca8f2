// Objects that something in front of them cuts in two, seen by the virtual scanner.
#include "perception/refinement/merge/merge_occluded_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numbers>

#include "perception/simulation/random_scenes.h"
#include "perception/simulation/virtual_scanner.h"
#include "tests/perception/table_scene.h"

namespace cwm::perception {
namespace {

constexpr double kRadius_m = 0.012, kLength_m = 0.24;

// A rod of this length that lies across the view, with its middle at `y_m`.
SimulatedObject Rod(double length_m, double y_m) {
  Pose X_WO = MakeTranslation(0, y_m, kRadius_m);
  X_WO.rotate(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitX()));
  return MakeObject("rod", Cylinder{kRadius_m, length_m}, X_WO);
}

SimulatedObject Post() {
  return MakeObject("post", Box{{0.03, 0.05, 0.16}}, MakeTranslation(-0.08, 0, 0.08));
}

// The lengths of the cylinders found, ascending.
std::vector<double> RodsOf(const SceneInterpretation& scene) {
  std::vector<double> lengths_m;
  for (const DetectedObject& object : scene.objects) {
    for (const ShapePart& part : object.model->shapes) {
      const auto* cylinder = std::get_if<Cylinder>(&part.shape);
      if (cylinder != nullptr) lengths_m.push_back(cylinder->length_m);
    }
  }
  std::sort(lengths_m.begin(), lengths_m.end());
  return lengths_m;
}

TEST(MergeOccludedParts, ARodBehindAPostIsOneRod) {
  const SceneInterpretation scene = Interpreted({{Table(), Post(), Rod(kLength_m, 0)}});
  const std::vector<double> lengths_m = RodsOf(scene);
  ASSERT_EQ(lengths_m.size(), 1u);
  EXPECT_NEAR(lengths_m[0], kLength_m, 0.006);  // 3 mixed pixels of 1.7 mm
  EXPECT_EQ(scene.objects.size(), 2u);
}

TEST(MergeOccludedParts, RodsInLineThatAreSeenApartBesideThePostAreTwo) {
  // The post hides 5 cm of the line; the gap is twice as wide.
  const SceneInterpretation scene =
      Interpreted({{Table(), Post(), Rod(0.10, 0.12), Rod(0.10, -0.08)}});
  EXPECT_EQ(scene.objects.size(), 3u);
}

TEST(MergeOccludedParts, RodsOfTwoSizesBehindThePostAreTwo) {
  SimulatedObject thick = Rod(0.10, 0.07);
  thick.parts[0].shape = Cylinder{1.6 * kRadius_m, 0.10};
  thick.X_WO.translation().z() = 1.6 * kRadius_m;
  const SceneInterpretation scene = Interpreted({{Table(), Post(), thick, Rod(0.10, -0.07)}});
  EXPECT_EQ(scene.objects.size(), 3u);
}

TEST(MergeOccludedParts, ObjectsAreLargestFirstAndRestOnWhatTheyRestedOn) {
  SimulatedScene scene{{Table(), Post(), Rod(kLength_m, 0)}};
  scene.objects.push_back(
      MakeObject("below", Box{{0.1, 0.12, 0.08}}, MakeTranslation(0, 0.28, 0.04)));
  scene.objects.push_back(
      MakeObject("above", Box{{0.05, 0.05, 0.1}}, MakeTranslation(0, 0.28, 0.13)));
  const SceneInterpretation found = Interpreted(scene);
  ASSERT_EQ(found.objects.size(), 4u);
  for (std::size_t k = 1; k < found.objects.size(); ++k) {
    EXPECT_GE(found.objects[k - 1].model->point_count, found.objects[k].model->point_count);
  }
  const auto above =
      std::ranges::find_if(found.objects, [](const DetectedObject& o) { return o.rests_on >= 0; });
  ASSERT_NE(above, found.objects.end());
  const DetectedObject& below = found.objects[static_cast<std::size_t>(above->rests_on)];
  EXPECT_NEAR(below.X_WO.translation().y(), 0.28, 0.03);
  EXPECT_LT(below.X_WO.translation().z(), above->X_WO.translation().z());
}

// The largest share of a true object's points that one found object has.
double LargestShare(const SimulatedCloud& scan, const SceneInterpretation& found,
                    std::int32_t object) {
  std::map<std::uint32_t, double> count;
  double all = 0;
  for (std::size_t i = 0; i < scan.object.size(); ++i) {
    if (scan.object[i] != object) continue;
    ++all;
    ++count[found.labels[i] / 10];
  }
  double max_points = 0;
  for (const auto& [label, points] : count) max_points = std::max(max_points, points);
  return max_points / all;
}

// A sphere stands before a short cylinder. The strip of the cylinder that shows on one side of the
// sphere lies next to another cylinder and looks like its handle.
TEST(MergeOccludedParts, WhatSeemsAHandleOfItsNeighbourIsGivenBack) {
  const SimulatedView view = RandomScene(SceneFamily::kClutter, 55);
  const SimulatedCloud scan = Scan(view.scene, view.camera, {.seed = 55});
  const auto found = InterpretScene(scan.cloud, {});
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_GT(LargestShare(scan, *found, 3), 0.95);
}

// The handle of a pan is level with the top of a box beside it. The top, if extended, would include
// the handle.
TEST(MergeOccludedParts, AHandleBesideABoxOfItsHeightStaysWithItsPan) {
  SimulatedObject pan = MakeObject("pan", Cylinder{0.06, 0.08}, MakeTranslation(0, -0.1, 0.04));
  Pose X_WHandle = MakeTranslation(0, 0.03, 0.06);
  X_WHandle.rotate(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitX()));
  pan.X_WO = Pose::Identity();
  pan.parts = {{MakeTranslation(0, -0.1, 0.04), Cylinder{0.06, 0.08}},
               {X_WHandle, Capsule{0.007, 0.13}}};
  const SimulatedScene scene{
      {Table(), pan, MakeObject("box", Box{{0.1, 0.1, 0.067}}, MakeTranslation(0, 0.22, 0.0335))}};
  InterpretOptions options;
  options.X_WC = TableCamera().X_WC;
  const SimulatedCloud scan = Scan(scene, TableCamera(), {.seed = 3});
  const auto found = InterpretScene(scan.cloud, options);
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_GT(LargestShare(scan, *found, 1), 0.95);
  EXPECT_GT(LargestShare(scan, *found, 2), 0.95);
  EXPECT_EQ(found->objects.size(), 2u);
}

SimulatedObject Screen(double y_m, double width_m, double height_m) {
  return MakeObject("screen", Box{{0.02, width_m, height_m}},
                    MakeTranslation(-0.12, y_m, 0.5 * height_m));
}

// A box hides an upright cup except for its lid and a strip of its wall. `object` is the cup's
// index in the scene.
TEST(MergeOccludedParts, TheLidOfACupAndAStripOfItsWallAreOneObject) {
  struct Cup {
    SceneFamily family;
    std::uint64_t seed;
    std::int32_t object;
  };
  for (const auto& [family, seed, object] :
       {Cup{SceneFamily::kClutter, 1056, 10}, Cup{SceneFamily::kTable, 1240, 1}}) {
    const SimulatedView view = RandomScene(family, seed);
    const SimulatedCloud scan = Scan(view.scene, view.camera, {.seed = seed});
    InterpretOptions options;
    options.X_WC = view.camera.X_WC;
    const auto found = InterpretScene(scan.cloud, options);
    ASSERT_TRUE(found.ok()) << found.status();
    EXPECT_GT(LargestShare(scan, *found, object), 0.95);
  }
}

// A slab on a narrower box is an object of its own, however little of the box is seen.
TEST(MergeOccludedParts, ASlabOnABoxIsNoLidOfIt) {
  const SimulatedScene scene{
      {Table(), Screen(-0.06, 0.14, 0.12),
       MakeObject("box", Box{{0.07, 0.07, 0.1}}, MakeTranslation(0, 0, 0.05)),
       MakeObject("slab", Box{{0.11, 0.11, 0.008}}, MakeTranslation(0, 0, 0.104))}};
  const SceneInterpretation found = Interpreted(scene);
  EXPECT_EQ(found.objects.size(), 3u);
  const auto on_another = [](const DetectedObject& object) { return object.rests_on >= 0; };
  EXPECT_EQ(std::ranges::count_if(found.objects, on_another), 1);
}

}  // namespace
}  // namespace cwm::perception
