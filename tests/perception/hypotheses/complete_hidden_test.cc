#include "perception/hypotheses/complete_hidden.h"

#include <gtest/gtest.h>

#include <numbers>
#include <optional>
#include <vector>

#include "tests/perception/refinement/hand_built.h"

namespace cwm::perception {
namespace {

constexpr double kYaw_rad = 0.3588;  // towards the sensor of HandBuilt

// A box of 10 x 10 x 20 cm on a table, 20 cm behind a board that hides its lower 13 cm.
class BoxBehindABoard : public ::testing::Test {
 protected:
  BoxBehindABoard() {
    HandBuilt scene;
    scene.AddOccluder(Standing(Box{{0.02, 0.4, 0.245}}, -0.187, -0.07, 0, kYaw_rad));
    See(scene, scene.Add({Whole()}));
  }

  static Placed<> Whole() { return Standing(Box{{0.1, 0.1, 0.2}}, 0, 0, 0, kYaw_rad); }
  static Placed<> Upper() { return Standing(Box{{0.1, 0.1, 0.1}}, 0, 0, 0.1, kYaw_rad); }

  static ShapePart Fitted(const Placed<>& solid) {
    return {.X_OS = solid.X_FS,
            .shape = solid.shape,
            .fit = FitQuality{.observed_fraction = 0.5, .parameter_sigma = {0.001, 0.002, 0.003}}};
  }

  // Makes `scene` the current one.
  void See(const HandBuilt& scene, HypothesisId object) {
    const SceneState state = scene.State();
    points_ = Subset(state.points(), state.Get(object).points);
    sight_ = state.sight();
  }

  ShapePart Completed(const ShapePart& part) const { return Completed(part, points_); }
  ShapePart Completed(const ShapePart& part, const OrientedPoints& points) const {
    std::vector<ShapePart> shapes = {part};
    CompleteHidden({points, Pose::Identity()}, *sight_, shapes);
    return shapes.front();
  }

  OrientedPoints points_;
  std::optional<SightMap> sight_;
};

void ExpectLeftAlone(const ShapePart& part, const ShapePart& before) {
  EXPECT_EQ(part.role, PartRole::kFitted);
  EXPECT_TRUE(part.shape == before.shape);
  EXPECT_TRUE(part.X_OS.isApprox(before.X_OS));
}

TEST_F(BoxBehindABoard, ReachesTheTableWhicheverWayItsAxisPoints) {
  for (const double turn_rad : {0.0, std::numbers::pi}) {
    ShapePart part = Fitted(Upper());
    part.X_OS.rotate(Eigen::AngleAxisd(turn_rad, Vector3::UnitX()));
    const ShapePart longer = Completed(part);
    EXPECT_EQ(longer.role, PartRole::kCompleted);
    ASSERT_TRUE(std::holds_alternative<Box>(longer.shape));
    EXPECT_TRUE(std::get<Box>(longer.shape).size_m.isApprox(Vector3(0.1, 0.1, 0.2), 1e-6));
    EXPECT_LT((longer.X_OS.translation() - Vector3(0, 0, 0.1)).norm(), 1e-6);
    ASSERT_TRUE(longer.fit.has_value());
    // Half of 0.06 m^2 was seen; the longer box has 0.1 m^2.
    EXPECT_NEAR(longer.fit->observed_fraction, 0.3, 1e-6);
    EXPECT_EQ(longer.fit->parameter_sigma, (std::vector<double>{0.001, 0.002, 0}));
  }
}

TEST_F(BoxBehindABoard, StaysShortWhereRaysPassBelow) {
  HandBuilt hanging;
  See(hanging, hanging.Add({Upper()}));
  ExpectLeftAlone(Completed(Fitted(Upper())), Fitted(Upper()));
}

TEST_F(BoxBehindABoard, StaysShortWhereItCannotStandOnTheTable) {
  // Points of a stem below the box show that the stem carries it.
  OrientedPoints with_stem = points_;
  ASSERT_GT(with_stem.size(), 40u);
  for (std::size_t k = 0; k < 20; ++k) {
    with_stem.points[k] = {0, 0, 0.02f + 0.002f * static_cast<float>(k)};
  }
  ExpectLeftAlone(Completed(Fitted(Upper()), with_stem), Fitted(Upper()));
  // The cone would end in an apex 25 mm below.
  const ShapePart cone = Fitted(Standing(Cone{0.01, 0.05, 0.1}, 0, 0, 0.1));
  ExpectLeftAlone(Completed(cone), cone);
  // The cylinder lies.
  ShapePart lying = Fitted(Standing(Cylinder{0.05, 0.1}, 0, 0, 0.1));
  lying.X_OS.rotate(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitX()));
  ExpectLeftAlone(Completed(lying), lying);
  // No point of the box was measured.
  ExpectLeftAlone(Completed(Fitted(Upper()), {}), Fitted(Upper()));
}

TEST_F(BoxBehindABoard, IsCompletedAsItIsWhereAFitHadToGuessItsFoot) {
  const ShapePart guessed = Completed(Fitted(Whole()));
  EXPECT_EQ(guessed.role, PartRole::kCompleted);
  EXPECT_TRUE(guessed.shape == Whole().shape);
  HandBuilt alone;
  See(alone, alone.Add({Whole()}));
  ExpectLeftAlone(Completed(Fitted(Whole())), Fitted(Whole()));
}

}  // namespace
}  // namespace cwm::perception
