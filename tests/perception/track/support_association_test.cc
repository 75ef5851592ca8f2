#include <gtest/gtest.h>

#include <memory>

#include "perception/track/association.h"
#include "tests/perception/track/known_truth.h"

namespace cwm::perception {
namespace {

using Outcome = Association::Outcome;

const SensorNoise kNoise{.model = SensorModel::kKinect};

Polygon Rectangle(const Vector2& low, const Vector2& high) {
  return {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
}

Plate PlateOf(const Polygon& outline) {
  return {.outline = outline, .holes = {}, .thickness_m = 0.02};
}

std::shared_ptr<const HybridModel> PlateModel(const Polygon& outline) {
  HybridModel model;
  model.shapes.push_back({.shape = PlateOf(outline), .fit = {}});
  return std::make_shared<const HybridModel>(std::move(model));
}

// A table of 0.6 m by 0.5 m, 0.9 m high, in front of the kitchen's camera.
class TrackingATable : public ::testing::Test {
 protected:
  static constexpr double kHeight_m = 0.9;

  static SimulatedScene TableOf(const Polygon& outline, double height_m) {
    SimulatedObject table{.name = "table",
                          .parts = {{.shape = PlateOf(outline)}},
                          .X_WO = MakeTranslation(0, 0, height_m),
                          .is_support = true};
    SimulatedObject floor{.name = "wall", .parts = {{.shape = HalfSpace{}}}};
    return {.objects = {table, floor}};
  }

  Outcome WhatBecomesOfIt(const SimulatedScene& now) const {
    const TrueScan seen = ScanAndInterpret(now, KitchenCamera(), 2);
    for (const Association& a : Associate(known_, seen.scene, seen.scan.cloud, kNoise)) {
      if (a.known == 0) return a.outcome;
    }
    ADD_FAILURE() << "the table is not mentioned";
    return Outcome::kAdd;
  }

  const Polygon outline_ = Rectangle({0.35, -0.3}, {0.85, 0.3});
  const std::vector<KnownObject> known_ = {{.name = "table",
                                            .kind = KnownObject::Kind::kSupport,
                                            .X_WO = MakeTranslation(0, 0, kHeight_m),
                                            .model = PlateModel(outline_)}};
};

TEST_F(TrackingATable, KeepsItUnderFreshNoise) {
  EXPECT_EQ(WhatBecomesOfIt(TableOf(outline_, kHeight_m)), Outcome::kKeep);
}

TEST_F(TrackingATable, KeepsItWhenItsBorderGrowsOrShrinksALittle) {
  EXPECT_EQ(WhatBecomesOfIt(TableOf(Rectangle({0.34, -0.31}, {0.86, 0.31}), kHeight_m)),
            Outcome::kKeep);
  EXPECT_EQ(WhatBecomesOfIt(TableOf(Rectangle({0.36, -0.29}, {0.84, 0.29}), kHeight_m)),
            Outcome::kKeep);
}

TEST_F(TrackingATable, ReplacesItWhenMuchMoreOfItIsSeen) {
  EXPECT_EQ(WhatBecomesOfIt(TableOf(Rectangle({0.35, -0.5}, {0.95, 0.5}), kHeight_m)),
            Outcome::kReplace);
}

TEST_F(TrackingATable, ReplacesItWhenRaysPassThroughHalfOfIt) {
  EXPECT_EQ(WhatBecomesOfIt(TableOf(Rectangle({0.35, -0.3}, {0.85, 0.0}), kHeight_m)),
            Outcome::kReplace);
}

TEST_F(TrackingATable, RemovesItWhenRaysPassThroughAllOfIt) {
  EXPECT_EQ(WhatBecomesOfIt(TableOf(outline_, 0.6)), Outcome::kRemove);
}

TEST_F(TrackingATable, HidesItUnderAnotherTable) {
  SimulatedScene now = TableOf(outline_, kHeight_m);
  SimulatedObject upper = now.objects[0];
  upper.name = "upper";
  upper.parts = {{.shape = PlateOf(Rectangle({0.1, -0.5}, {0.75, 0.5}))}};
  upper.X_WO = MakeTranslation(0, 0, 1.1);
  now.objects = {upper, now.objects[1]};
  EXPECT_EQ(WhatBecomesOfIt(now), Outcome::kOcclude);
}

}  // namespace
}  // namespace cwm::perception
