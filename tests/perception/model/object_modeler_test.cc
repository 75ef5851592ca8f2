// Whole objects: a Kinect's view of known solids on a table gives those solids back.
#include "perception/modeler/object_modeler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "collision/geometry/aabb.h"
#include "collision/geometry/signed_distance.h"
#include "perception/simulation/random_draws.h"
#include "tests/perception/model/surfaces.h"

namespace cwm::perception {
namespace {

constexpr double kDistance_m = 0.75;
constexpr double kElevation_rad = 35 * std::numbers::pi / 180;
// One standard deviation of a Kinect at 0.75 m is 1.4 mm. A surface of 3000 points has 250
// independent ones, of which a radius, a height or an edge uses a few dozen: 3 * 1.4 / sqrt(30),
// and as much again for the slow warp of the sensor.
constexpr double kSize_m = 0.0016 + 0.0014;
// Edges are ragged by the lateral noise (0.8 pixel, 1.1 mm) on either side.
constexpr double kEdge_m = 0.005;

const SensorNoise kNoise;

ObjectModel Model(const ScannedObject& scan, std::uint64_t seed = 1) {
  ModelerOptions options;
  options.seed = seed;
  return ModelObject(scan.points, scan.X_WSupport, kNoise, options);
}

double ExplainedShare(const ObjectModel& model) {
  const auto explained = std::count_if(model.part_of_point.begin(), model.part_of_point.end(),
                                       [](std::int32_t part) { return part != kUnexplained; });
  return static_cast<double>(explained) / static_cast<double>(model.part_of_point.size());
}

template <class S>
const S* OnlyShape(const ObjectModel& model) {
  return model.shapes.size() == 1 ? std::get_if<S>(&model.shapes[0].shape) : nullptr;
}

TEST(ModelObject, CylinderOnTheTableIsFoundWithItsCap) {
  const Cylinder can{.radius_m = 0.035, .length_m = 0.12};
  const ObjectModel model =
      Model(ScanOnTable(OfOnePart(can, 0.06), kDistance_m, kElevation_rad, 1));
  const auto* found = OnlyShape<Cylinder>(model);
  ASSERT_NE(found, nullptr);
  EXPECT_NEAR(found->radius_m, can.radius_m, kSize_m);
  EXPECT_NEAR(found->length_m, can.length_m, kEdge_m);
  EXPECT_GT(ExplainedShare(model), 0.95);
  const FitQuality& fit = *model.shapes[0].fit;
  EXPECT_EQ(fit.parameter_sigma.size(), 7u);
  EXPECT_LT(fit.rms_m, 2 * kNoise.AxialSigma_m(kDistance_m));
  EXPECT_LE(fit.rms_m, fit.max_residual_m);
  // Half of the wall and the cap are seen; the foot is not.
  EXPECT_GT(fit.observed_fraction, 0.3);
  EXPECT_LT(fit.observed_fraction, 0.8);
}

TEST(ModelObject, SphereIsFoundAndRestsOnTheTable) {
  const Sphere ball{.radius_m = 0.04};
  const ObjectModel model =
      Model(ScanOnTable(OfOnePart(ball, 0.04), kDistance_m, kElevation_rad, 2));
  const auto* found = OnlyShape<Sphere>(model);
  ASSERT_NE(found, nullptr);
  EXPECT_NEAR(found->radius_m, ball.radius_m, kSize_m);
  EXPECT_GE(model.shapes[0].X_OS.translation().z() - found->radius_m, -1e-6);
}

TEST(ModelObject, CupIsACone) {
  const Cone cup{.radius_bottom_m = 0.03, .radius_top_m = 0.045, .length_m = 0.11};
  const ObjectModel model =
      Model(ScanOnTable(OfOnePart(cup, 0.055), kDistance_m, 25 * std::numbers::pi / 180, 3));
  const auto* found = OnlyShape<Cone>(model);
  ASSERT_NE(found, nullptr);
  EXPECT_NEAR(found->radius_bottom_m, cup.radius_bottom_m, kSize_m);
  EXPECT_NEAR(found->radius_top_m, cup.radius_top_m, kSize_m);
  EXPECT_NEAR(found->length_m, cup.length_m, kEdge_m);
}

// From steeply above, a cup shows its lid and a sliver of wall at 68 degrees of incidence.
TEST(ModelObject, CupOfWhichLittleButTheLidShowsIsACone) {
  constexpr double kSteep_rad = 57 * std::numbers::pi / 180;
  const Cone cup{.radius_bottom_m = 0.03, .radius_top_m = 0.045, .length_m = 0.08};
  const ObjectModel model = Model(ScanOnTable(OfOnePart(cup, 0.04), kDistance_m, kSteep_rad, 1));
  const auto* found = OnlyShape<Cone>(model);
  ASSERT_NE(found, nullptr);
  EXPECT_NEAR(found->radius_top_m, cup.radius_top_m, kSize_m);
  EXPECT_NEAR(found->length_m, cup.length_m, kEdge_m);
}

// Normals are estimated in windows as wide as the can.
TEST(ModelObject, NarrowCanIsACylinderAndNoBox) {
  const Cylinder can{.radius_m = 0.018, .length_m = 0.09};
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const ObjectModel model = Model(ScanOnTable(OfOnePart(can, 0.045), 1.0, kElevation_rad, seed));
    const auto* found = OnlyShape<Cylinder>(model);
    ASSERT_NE(found, nullptr) << seed;
    EXPECT_NEAR(found->radius_m, can.radius_m, kSize_m);
    EXPECT_NEAR(found->length_m, can.length_m, kEdge_m);
  }
}

// From above, the lid hides most of the wall.
TEST(ModelObject, CanUnderItsLidIsACylinderAndNoPlate) {
  const Cylinder can{.radius_m = 0.04, .length_m = 0.06};
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const ObjectModel model =
        Model(ScanOnTable(OfOnePart(can, 0.03), 0.9, 68 * std::numbers::pi / 180, seed));
    const auto* found = OnlyShape<Cylinder>(model);
    ASSERT_NE(found, nullptr) << seed;
    EXPECT_NEAR(found->radius_m, can.radius_m, kSize_m);
  }
}

// The visible lid of a wide cup, behind which its wall is hidden, is modelled as a disc and not as
// a board with corners.
TEST(ModelObject, LidAloneIsADisc) {
  const Cone cup{.radius_bottom_m = 0.03, .radius_top_m = 0.05, .length_m = 0.12};
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const ObjectModel model =
        Model(ScanOnTable(OfOnePart(cup, 0.06), 0.9, 84 * std::numbers::pi / 180, seed));
    ASSERT_EQ(model.shapes.size(), 1u) << seed;
    const auto* disc = std::get_if<Cylinder>(&model.shapes[0].shape);
    if (disc == nullptr) {  // or the whole cup
      EXPECT_TRUE(std::holds_alternative<Cone>(model.shapes[0].shape)) << seed;
      continue;
    }
    const Pose& X_OS = model.shapes[0].X_OS;
    EXPECT_NEAR(disc->radius_m, cup.radius_top_m, kSize_m) << seed;
    EXPECT_NEAR(X_OS.translation().z() + 0.5 * disc->length_m, cup.length_m, kSize_m) << seed;
    EXPECT_LT(X_OS.translation().head<2>().norm(), kSize_m) << seed;
    EXPECT_EQ(model.shapes[0].fit->parameter_sigma.size(), 7u) << seed;
  }
}

// The visible end of a leaning can gives the direction of its axis.
TEST(ModelObject, LeaningCanSeenFromItsEndIsACylinder) {
  const Cylinder can{.radius_m = 0.0325, .length_m = 0.1};
  const double lean_rad = 35 * std::numbers::pi / 180;
  SimulatedObject object = OfOnePart(can, 0);
  object.X_WO.linear() = Eigen::AngleAxisd(-lean_rad, Vector3::UnitY()).toRotationMatrix();
  object.X_WO.translation().z() =
      0.5 * can.length_m * std::cos(lean_rad) + can.radius_m * std::sin(lean_rad);
  const Vector3 axis = object.X_WO.linear().col(2);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const ObjectModel model =
        Model(ScanOnTable(object, kDistance_m, 75 * std::numbers::pi / 180, seed));
    const auto* found = OnlyShape<Cylinder>(model);
    ASSERT_NE(found, nullptr) << seed;
    EXPECT_NEAR(found->radius_m, can.radius_m, kSize_m) << seed;
    EXPECT_GT(std::abs(model.shapes[0].X_OS.linear().col(2).dot(axis)), std::cos(0.1)) << seed;
  }
}

// The thin solid of a face that inclines towards the sensor reaches below the ground where the face
// meets it. The face is kept all the same.
TEST(ModelObject, LoneFaceIsKeptDownToTheGround) {
  const double tilt_rad = 37 * std::numbers::pi / 180;
  SimulatedObject object = OfOnePart(Box{.size_m = {0.18, 0.17, 0.04}}, 0);
  object.X_WO.linear() = Eigen::AngleAxisd(-tilt_rad, Vector3::UnitY()).toRotationMatrix();
  object.X_WO.translation().z() = 0.09 * std::sin(tilt_rad) + 0.02 * std::cos(tilt_rad);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    ScannedObject scan = ScanOnTable(object, kDistance_m, 0.5 * std::numbers::pi - tilt_rad, seed);
    scan.X_WSupport.translation().z() += 0.04 * std::cos(tilt_rad);
    const ObjectModel model = Model(scan);
    ASSERT_EQ(model.shapes.size(), 1u) << seed;
    const ShapeKind kind = KindOf(model.shapes[0].shape);
    EXPECT_TRUE(kind == ShapeKind::kBox || kind == ShapeKind::kPlate) << NameOf(kind);
    EXPECT_GT(ExplainedShare(model), 0.95) << seed;
  }
}

TEST(ModelObject, WallsBehindDiscsAreOfKindsThatAreSearchedForAlone) {
  const Cylinder can{.radius_m = 0.035, .length_m = 0.12};
  const ScannedObject scan = ScanOnTable(OfOnePart(can, 0.06), kDistance_m, kElevation_rad, 1);
  ModelerOptions planes_alone;
  planes_alone.search_cylinders = planes_alone.search_cones = planes_alone.search_spheres = false;
  for (const ShapePart& part :
       ModelObject(scan.points, scan.X_WSupport, kNoise, planes_alone).shapes) {
    EXPECT_FALSE(std::holds_alternative<Cylinder>(part.shape));
    EXPECT_FALSE(std::holds_alternative<Cone>(part.shape));
  }
}

TEST(ModelObject, VisibleFacesBecomeABoxWithItsHiddenFaces) {
  SimulatedObject object = OfOnePart(Box{.size_m = {0.12, 0.08, 0.10}}, 0.05);
  object.X_WO.linear() = Eigen::AngleAxisd(0.5, Vector3::UnitZ()).toRotationMatrix();
  const ObjectModel model = Model(ScanOnTable(object, kDistance_m, kElevation_rad, 4));
  const auto* found = OnlyShape<Box>(model);
  ASSERT_NE(found, nullptr);
  EXPECT_NEAR(found->size_m.x(), 0.12, kEdge_m);
  EXPECT_NEAR(found->size_m.y(), 0.08, kEdge_m);
  EXPECT_NEAR(found->size_m.z(), 0.10, kEdge_m);
  // x of the box's frame is the axis nearest to +x of the world; z is up.
  EXPECT_GT(model.shapes[0].X_OS.linear()(0, 0), std::cos(0.5 + 0.05));
  EXPECT_GT(model.shapes[0].X_OS.linear()(2, 2), 0.999);
}

TEST(ModelObject, SecondScanOfABoxFlipsNoFrame) {
  SimulatedObject object = OfOnePart(Box{.size_m = {0.10, 0.10, 0.10}}, 0.05);
  object.X_WO.linear() = Eigen::AngleAxisd(0.4, Vector3::UnitZ()).toRotationMatrix();
  constexpr double kTurn_rad = 0.1;  // noise; a flip is a quarter turn
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const ObjectModel model = Model(ScanOnTable(object, kDistance_m, kElevation_rad, seed));
    ASSERT_NE(OnlyShape<Box>(model), nullptr) << "seed " << seed;
    EXPECT_LT(RotationAngle_rad(model.shapes[0].X_OS.linear(), object.X_WO.linear()), kTurn_rad);
  }
}

TEST(ModelObject, BoxesNeverBecomeRound) {
  RandomDraws draws(5, 0);
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Vector3 size{draws.Uniform(0.05, 0.2), draws.Uniform(0.05, 0.2),
                       draws.Uniform(0.05, 0.2)};
    SimulatedObject object = OfOnePart(Box{.size_m = size}, 0.5 * size.z());
    object.X_WO.linear() =
        Eigen::AngleAxisd(draws.Uniform(0, 3), Vector3::UnitZ()).toRotationMatrix();
    const ObjectModel model = Model(ScanOnTable(object, 0.9, kElevation_rad, seed));
    ASSERT_FALSE(model.shapes.empty()) << "seed " << seed;
    for (const ShapePart& part : model.shapes) {
      const ShapeKind kind = KindOf(part.shape);
      EXPECT_TRUE(kind == ShapeKind::kBox || kind == ShapeKind::kPlate) << NameOf(kind);
    }
  }
}

// A bow of capsules in the xz plane of its own frame that reaches `reach_m` out.
void AddBow(const Pose& X_ObjectBow, double reach_m, double radius_m, SimulatedObject& object) {
  constexpr int kSegments = 8;
  const auto on_arc = [&](int i) {
    const double angle = std::numbers::pi * (static_cast<double>(i) / kSegments - 0.5);
    return Vector3(X_ObjectBow * Vector3(reach_m * std::cos(angle), 0, 0.03 * std::sin(angle)));
  };
  for (int i = 0; i < kSegments; ++i) {
    const Vector3 chord = on_arc(i + 1) - on_arc(i);
    Pose X = Pose::Identity();
    X.linear() = BasisFromZ(chord.normalized());
    X.translation() = 0.5 * (on_arc(i) + on_arc(i + 1));
    object.parts.push_back({X, Capsule{.radius_m = radius_m, .length_m = chord.norm()}});
  }
}

// True also if the modeler first fits the bow as a box or as a piece of a cylinder.
TEST(ModelObject, MugHasAHandle) {
  SimulatedObject mug = OfOnePart(Cylinder{.radius_m = 0.04, .length_m = 0.1}, 0.05);
  AddBow(Pose(Eigen::Translation3d(0.04, 0, 0.05)), 0.03, 0.006, mug);
  // The handle points to the side, where it is seen against the table.
  mug.X_WO.linear() = Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3::UnitZ()).matrix();
  for (const double distance_m : {0.65, 0.8, 1.0}) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      SCOPED_TRACE(testing::Message() << "at " << distance_m << " m, seed " << seed);
      const ObjectModel model = Model(ScanOnTable(mug, distance_m, kElevation_rad, seed));
      ASSERT_EQ(model.handles.size(), 1u);
      const Handle& handle = model.handles[0];
      ASSERT_LT(static_cast<std::size_t>(handle.shape_index), model.shapes.size());
      EXPECT_TRUE(std::holds_alternative<Cylinder>(
          model.shapes[static_cast<std::size_t>(handle.shape_index)].shape));
      EXPECT_GT(std::abs(handle.axis_O.z()), 0.8);  // it stands upright
      EXPECT_EQ(std::count(model.part_of_point.begin(), model.part_of_point.end(),
                           static_cast<std::int32_t>(model.shapes.size())),
                handle.point_count);
    }
  }
}

// Handles stand out from the wall on either side, where their points would widen it most.
TEST(ModelObject, PotIsAsWideAsItsWallBesideItsHandles) {
  const Cylinder wall{.radius_m = 0.09, .length_m = 0.08};
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    SimulatedObject pot = OfOnePart(wall, 0.04);
    for (const double side : {-1.0, 1.0}) {
      Pose X = Pose::Identity();
      X.linear() = (Eigen::AngleAxisd(side * 0.5 * std::numbers::pi, Vector3::UnitZ()) *
                    Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3::UnitX()))
                       .matrix();
      X.translation() = Vector3(0, side * wall.radius_m, 0.055);
      AddBow(X, 0.025, 0.008, pot);
    }
    const ScannedObject scan = ScanOnTable(pot, 0.75, kElevation_rad, seed);
    const ObjectModel model = Model(scan);
    EXPECT_EQ(model.handles.size(), 2u);
    const auto* found = OnlyShape<Cylinder>(model);
    ASSERT_NE(found, nullptr);
    EXPECT_NEAR(found->radius_m, wall.radius_m, 0.0015);
    for (const Handle& handle : model.handles) {
      const auto label = static_cast<std::int32_t>(&handle - model.handles.data()) + 1;
      EXPECT_EQ(std::ranges::count(model.part_of_point, label), handle.point_count);
    }
  }
}

TEST(ModelObject, ClutterNeedsNoClusters) {
  SimulatedObject clutter = OfOnePart(Cylinder{.radius_m = 0.035, .length_m = 0.12}, 0.06);
  clutter.parts.push_back({MakeTranslation(0.02, 0.12, 0.05), Box{.size_m = {0.1, 0.1, 0.1}}});
  clutter.parts.push_back({MakeTranslation(0, -0.1, 0.045), Sphere{.radius_m = 0.045}});
  const ObjectModel model = Model(ScanOnTable(clutter, 0.8, kElevation_rad, 7));
  int of_kind[kShapeKindCount] = {};
  for (const ShapePart& part : model.shapes) ++of_kind[part.shape.index()];
  EXPECT_EQ(of_kind[static_cast<int>(ShapeKind::kCylinder)], 1);
  EXPECT_EQ(of_kind[static_cast<int>(ShapeKind::kSphere)], 1);
  EXPECT_EQ(of_kind[static_cast<int>(ShapeKind::kBox)], 1);
  EXPECT_GT(ExplainedShare(model), 0.95);
}

TEST(ModelObject, NothingReachesBelowTheSupport) {
  for (double elevation_deg : {25.0, 45.0, 60.0}) {
    SimulatedObject object = OfOnePart(Box{.size_m = {0.15, 0.06, 0.04}}, 0.02);
    object.parts.push_back({MakeTranslation(0, 0.1, 0.03), Cylinder{0.03, 0.06}});
    const ScannedObject scan =
        ScanOnTable(object, kDistance_m, elevation_deg * std::numbers::pi / 180, 8);
    const ObjectModel model = Model(scan);
    ASSERT_FALSE(model.shapes.empty()) << elevation_deg;
    for (const ShapePart& part : model.shapes) {
      EXPECT_GE(TightBounds(part.shape, part.X_OS).min().z(), -0.003);  // sigma of the support
    }
  }
}

TEST(ModelObject, SameSeedGivesTheSameModel) {
  const ScannedObject scan = ScanOnTable(
      OfOnePart(Cylinder{.radius_m = 0.03, .length_m = 0.1}, 0.05), kDistance_m, kElevation_rad, 9);
  const ObjectModel a = Model(scan, 42), b = Model(scan, 42);
  ASSERT_FALSE(a.shapes.empty());
  ASSERT_EQ(a.shapes.size(), b.shapes.size());
  for (std::size_t k = 0; k < a.shapes.size(); ++k) {
    EXPECT_EQ(a.shapes[k].shape, b.shapes[k].shape);
    EXPECT_EQ(a.shapes[k].X_OS.matrix(), b.shapes[k].X_OS.matrix());
    EXPECT_EQ(a.shapes[k].fit, b.shapes[k].fit);
  }
  EXPECT_EQ(a.part_of_point, b.part_of_point);
}

// An object that is modelled as one shape of its kind, and the option that turns the kind off.
struct Switch {
  Shape shape;
  double height_of_center_m = 0;
  double elevation_rad = kElevation_rad;
  bool ModelerOptions::*on = nullptr;
};

bool AnyOfKind(const ObjectModel& model, ShapeKind kind) {
  return std::any_of(model.shapes.begin(), model.shapes.end(),
                     [kind](const ShapePart& part) { return KindOf(part.shape) == kind; });
}

class SwitchedKinds : public ::testing::TestWithParam<Switch> {};

TEST_P(SwitchedKinds, AreFoundWhenOnAndNotWhenOff) {
  const Switch& param = GetParam();
  const ScannedObject scan = ScanOnTable(OfOnePart(param.shape, param.height_of_center_m),
                                         kDistance_m, param.elevation_rad, 3);
  const ShapeKind kind = KindOf(param.shape);
  ModelerOptions options;
  EXPECT_TRUE(AnyOfKind(ModelObject(scan.points, scan.X_WSupport, kNoise, options), kind));
  options.*param.on = false;
  EXPECT_FALSE(AnyOfKind(ModelObject(scan.points, scan.X_WSupport, kNoise, options), kind));
}

INSTANTIATE_TEST_SUITE_P(
    ModelObject, SwitchedKinds,
    ::testing::Values(
        Switch{.shape = Box{.size_m = {0.12, 0.08, 0.10}},
               .height_of_center_m = 0.05,
               .on = &ModelerOptions::search_planes},
        Switch{.shape = Cylinder{.radius_m = 0.035, .length_m = 0.12},
               .height_of_center_m = 0.06,
               .on = &ModelerOptions::search_cylinders},
        Switch{.shape = Sphere{.radius_m = 0.04},
               .height_of_center_m = 0.04,
               .on = &ModelerOptions::search_spheres},
        Switch{.shape = Cone{.radius_bottom_m = 0.03, .radius_top_m = 0.045, .length_m = 0.11},
               .height_of_center_m = 0.055,
               .elevation_rad = 25 * std::numbers::pi / 180,
               .on = &ModelerOptions::search_cones}),
    [](const auto& info) { return std::string(NameOf(KindOf(info.param.shape))); });

TEST(ModelObject, FindsNothingWithAllKindsOff) {
  const ScannedObject scan =
      ScanOnTable(OfOnePart(Sphere{.radius_m = 0.04}, 0.04), kDistance_m, kElevation_rad, 14);
  ModelerOptions none;
  none.search_planes = none.search_cylinders = none.search_spheres = none.search_cones = false;
  const ObjectModel model = ModelObject(scan.points, scan.X_WSupport, kNoise, none);
  EXPECT_TRUE(model.shapes.empty());
  EXPECT_EQ(ExplainedShare(model), 0);
}

TEST(ModelObject, StopsWhenAsked) {
  std::stop_source source;
  source.request_stop();
  const ScannedObject scan =
      ScanOnTable(OfOnePart(Sphere{.radius_m = 0.04}, 0.04), kDistance_m, kElevation_rad, 14);
  EXPECT_THROW(ModelObject(scan.points, scan.X_WSupport, kNoise, ModelerOptions{},
                           {.stop = source.get_token()}),
               Stopped);
}

}  // namespace
}  // namespace cwm::perception
