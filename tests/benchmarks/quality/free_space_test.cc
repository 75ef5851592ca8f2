#include "tests/benchmarks/quality/free_space.h"

#include <gtest/gtest.h>

#include <cmath>

#include "perception/simulation/virtual_scanner.h"
#include "tests/benchmarks/quality/coverage.h"

namespace cwm::benchmarks {
namespace {

using perception::DetectedObject;
using perception::SceneInterpretation;

constexpr double kWall_m = 1.2;

// A camera that looks along z at a wall that fills its view, and the claims of an interpretation.
class BeforeAWall : public ::testing::Test {
 protected:
  BeforeAWall() {
    const Shape wall = Box{.size_m = {4, 4, 0.1}};
    scene_.objects = {{.name = "wall",
                       .parts = {{.shape = wall}},
                       .X_WO = MakeTranslation(0, 0, kWall_m + 0.05)}};
    Scan();
    ClaimSolid(wall, 0, 0, kWall_m + 0.05);
  }

  void Scan() {
    scan_ = perception::Scan(scene_, camera_, {.noiseless = true});
    labels_.assign(scan_.cloud.size(), 20);
  }

  void ClaimSolid(const Shape& shape, double x_m, double y_m, double z_m,
                  PartRole role = PartRole::kFitted) {
    auto model = std::make_shared<HybridModel>();
    model->shapes.push_back({.shape = shape, .role = role});
    DetectedObject& object = interpretation_.objects.emplace_back();
    object.X_WO = MakeTranslation(x_m, y_m, z_m);
    object.model = model;
  }

  void ClaimSheet(double z_m) {
    auto model = std::make_shared<HybridModel>();
    model->surfaces.push_back({MakeMesh({.vertices = {{-0.1, -0.1, 0}, {0.1, -0.1, 0}, {0, 0.1, 0}},
                                         .triangles = {{0, 1, 2}}}),
                               0});
    DetectedObject& object = interpretation_.objects.emplace_back();
    object.X_WO = MakeTranslation(0, 0, z_m);
    object.model = model;
  }

  FreeSpace Judge() const {
    return MeasureFreeSpace(ClaimsOf(interpretation_), scan_.cloud, camera_, 4);
  }
  Coverage Covered() const {
    return MeasureCoverage(ClaimsOf(interpretation_), scan_.cloud, labels_, 7);
  }

  perception::SimulatedScene scene_;
  perception::PinholeCamera camera_;
  perception::SimulatedCloud scan_;
  std::vector<std::uint32_t> labels_;
  SceneInterpretation interpretation_;
};

std::int64_t Deep(const FreeSpace& free_space, Claim claim) {
  return free_space.deep[static_cast<std::size_t>(claim)];
}
std::int64_t Crossed(const FreeSpace& free_space, Claim claim) {
  return free_space.crossed[static_cast<std::size_t>(claim)];
}

TEST_F(BeforeAWall, TheTruthViolatesNothingAndCoversAll) {
  EXPECT_GT(Judge().rays, 19'000);  // every 16th of 640 x 480 pixels
  EXPECT_EQ(Judge().violating, 0);
  EXPECT_EQ(Covered().share(), 1);
}

TEST_F(BeforeAWall, ABallInTheAirStopsTheRaysThatRunTenMillimetresDeep) {
  constexpr double kRadius_m = 0.05, kAt_m = 0.8;
  ClaimSolid(Sphere{.radius_m = kRadius_m}, 0, 0, kAt_m, PartRole::kCompleted);
  const FreeSpace result = Judge();
  // The whole ball counts: a ray that grazes it less deep still crosses its surface far from all
  // points.
  const double seen_px2 = std::pow(camera_.focal_px * kRadius_m / kAt_m, 2) * 3.14159;
  EXPECT_NEAR(static_cast<double>(result.violating), seen_px2 / 16, 0.08 * seen_px2 / 16);
  EXPECT_GT(Deep(result, Claim::kCompleted) + Crossed(result, Claim::kCompleted), 0);
  EXPECT_EQ(Deep(result, Claim::kFitted), 0);
}

TEST_F(BeforeAWall, WhatTheWallHidesIsNobodysBusiness) {
  ClaimSolid(Sphere{.radius_m = 0.05}, 0, 0, kWall_m + 0.3);
  EXPECT_EQ(Judge().violating, 0);
}

TEST_F(BeforeAWall, AWallThatIsTooThickIsFreeForThirtyMillimetresBeforeTheHit) {
  interpretation_.objects.clear();
  ClaimSolid(Box{.size_m = {4, 4, 0.1}}, 0, 0, kWall_m + 0.05 - 0.028);
  EXPECT_EQ(Judge().violating, 0) << "its face is 28 mm before the points";
  interpretation_.objects.clear();
  ClaimSolid(Box{.size_m = {4, 4, 0.1}}, 0, 0, kWall_m + 0.05 - 0.032);
  EXPECT_EQ(Judge().violating, Judge().rays);
}

TEST_F(BeforeAWall, ASheetInTheAirIsCrossed) {
  ClaimSheet(0.6);
  const FreeSpace result = Judge();
  EXPECT_GT(Crossed(result, Claim::kSurface), 0);
  EXPECT_EQ(result.violating, Crossed(result, Claim::kSurface));
  // A triangle of 0.2 by 0.2 m, half of its square.
  const double seen_px2 = 0.5 * std::pow(camera_.focal_px * 0.2 / 0.6, 2);
  EXPECT_NEAR(static_cast<double>(result.violating), seen_px2 / 16, 0.05 * seen_px2 / 16);
}

TEST_F(BeforeAWall, ASheetThatPointsLieOnIsNot) {
  scene_.objects.push_back({.name = "sheet",
                            .parts = {{.shape = Box{.size_m = {0.3, 0.3, 0.001}}}},
                            .X_WO = MakeTranslation(0, 0, 0.6)});
  Scan();
  ClaimSheet(0.6);
  EXPECT_EQ(Judge().violating, 0);
  EXPECT_LT(Covered().share(), 1) << "the sheet is larger than its triangle";
}

TEST_F(BeforeAWall, PointsDeepInsideASolidAreNotCovered) {
  ClaimSolid(Box{.size_m = {4, 4, 0.4}}, 0, 0, kWall_m);
  EXPECT_EQ(Covered().share(), 0) << "the true wall is there too, inside a block around everything";
}

TEST_F(BeforeAWall, OnlySoManyPointsMayBeRejected) {
  interpretation_.objects.clear();
  labels_.assign(labels_.size(), 0);
  EXPECT_NEAR(Covered().share(), kRejectable, 1e-3);
}

}  // namespace
}  // namespace cwm::benchmarks
