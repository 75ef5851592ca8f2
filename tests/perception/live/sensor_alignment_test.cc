// Three depth cameras around a table: where one of them stands, by what the others see.
#include "perception/live/sensor_alignment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "perception/simulation/furniture.h"
#include "perception/simulation/look_at.h"
#include "perception/simulation/sequence_renderer.h"
#include "tests/perception/live/known_scene.h"

namespace cwm::perception {
namespace {

constexpr double kTop_m = 0.75;
constexpr double kDegree_rad = std::numbers::pi / 180;
const Vector3 kMiddle(0.7, 0, kTop_m);

SimulatedObject Standing(const char* name, Shape shape, double height_m, const Vector2& at,
                         double yaw_rad) {
  const Quaternion yaw(Eigen::AngleAxisd(yaw_rad, Vector3::UnitZ()));
  return {.name = name,
          .parts = {{.X_FS = MakeTranslation(0, 0, 0.5 * height_m), .shape = std::move(shape)}},
          .X_WO = MakePose(Vector3(at.x(), at.y(), kTop_m), yaw)};
}

SequenceScript Table(bool has_things) {
  SequenceScript script;
  script.duration_s = 1;
  script.scene.objects = {
      MakeTop("table", {.area_W = {Vector2(-0.2, -1.2), Vector2(1.8, 1.2)}, .top_m = kTop_m})};
  for (int i = 0; has_things && i < 12; ++i) {
    const Vector2 at(0.5 + 0.2 * (i / 4), -0.3 + 0.2 * (i % 4));
    const double height_m = 0.08 + 0.01 * (i % 5);
    const Shape carton = Box{.size_m = {0.09, 0.06, height_m}};
    const Shape can = Cylinder{.radius_m = 0.04, .length_m = height_m};
    script.scene.objects.push_back(
        Standing("thing", i % 2 == 0 ? carton : can, height_m, at, 0.7 * i));
  }
  const Vector3 eyes[] = {{0.15, 0, 1.55}, {0.5, -0.7, 1.5}, {0.5, 0.7, 1.5}};
  for (const Vector3& eye : eyes) {
    SequenceSensor sensor;
    sensor.name = "camera_" + std::to_string(script.sensors.size() + 1);
    sensor.mount = LookAt(eye, kMiddle);
    sensor.device_seed = 100 + script.sensors.size();
    script.sensors.push_back(sensor);
  }
  return script;
}

std::vector<StillFrame> Frames(const SequenceRenderer& renderer, std::size_t sensor) {
  std::vector<StillFrame> frames;
  for (int k = 0; k < 8; ++k) {
    const SequenceFrame rendered = renderer.Render(sensor, k);
    auto image = std::make_shared<DepthImage>();
    image->width = rendered.depth.width;
    image->height = rendered.depth.height;
    image->depth_m = rendered.depth.depth_m;
    auto classes = std::make_shared<FrameClasses>();
    classes->pixels.assign(image->depth_m.size(), PixelClass::kConsistent);
    frames.push_back({std::move(image), std::move(classes)});
  }
  return frames;
}

std::vector<MeanView> Views(const SequenceScript& script) {
  const SequenceRenderer renderer(script);
  std::vector<MeanView> views;
  for (std::size_t s = 0; s < script.sensors.size(); ++s) {
    MeanView view{.sensor = script.sensors[s].name,
                  .X_WC = std::get<Pose>(script.sensors[s].mount),
                  .camera = CameraOf(script.sensors[s].camera)};
    view.depth_m = MeanAtRest(Frames(renderer, s), view.camera, view.noise);
    views.push_back(std::move(view));
  }
  return views;
}

const std::vector<MeanView>& TableViews() {
  static const std::vector<MeanView> views = Views(Table(true));
  return views;
}

Vector6 Twist(const Vector3& shift_m, const Vector3& turn_rad) {
  Vector6 twist;
  twist << shift_m, turn_rad;
  return twist;
}

// A pose that is wrong by 30 mm and 2 degrees.
const Vector6 kWrong =
    Twist(0.03 * Vector3(2, -1, 1).normalized(), 2 * kDegree_rad * Vector3(1, 2, -2).normalized());

// How far the pose takes a point of the table from where it is.
double MissAtTable_m(const Pose& X_WC, const Pose& X_WC_true) {
  return (X_WC * (X_WC_true.inverse() * kMiddle) - kMiddle).norm();
}

// They share the table and the tops of things, which determine no shift along it.
TEST(SensorAlignmentTest, CamerasThatLookAtEachOtherAgreeAtTheirPoses) {
  for (const auto& [sensor, other] : {std::pair{1, 2}, std::pair{2, 1}}) {
    const MeanView& view = TableViews()[static_cast<std::size_t>(sensor)];
    const ViewAlignment alignment = AlignViews(view, TableViews()[static_cast<std::size_t>(other)]);
    EXPECT_TRUE(alignment.is_aligned);
    EXPECT_LT(alignment.contradicting, 0.05);
    EXPECT_LT(alignment.apart_m, 0.004);
  }
}

TEST(SensorAlignmentTest, TheMostLikelyPoseWeighsTheGivenOne) {
  MeanView wrong = TableViews()[1];
  const Pose X_WC_true = wrong.X_WC;
  wrong.X_WC = Moved(wrong.X_WC, 0.3 * kWrong);
  const ViewAlignment alignments[] = {AlignViews(wrong, TableViews()[0])};
  EXPECT_GT(MissAtTable_m(wrong.X_WC, X_WC_true), 0.008);
  EXPECT_LT(MissAtTable_m(MostLikelyPose(wrong, alignments), X_WC_true), 0.005);
  EXPECT_EQ(MostLikelyPose(wrong, {}).matrix(), wrong.X_WC.matrix());
  // A pose that is known to a tenth of a millimetre stays.
  wrong.pose_sigma_m = wrong.pose_sigma_rad = 1e-4;
  EXPECT_LT(MissAtTable_m(MostLikelyPose(wrong, alignments), wrong.X_WC), 0.001);
}

TEST(SensorAlignmentTest, FindsAPoseThatIsWrongByThreeCentimetresAndTwoDegrees) {
  MeanView wrong = TableViews()[1];
  wrong.X_WC = Moved(wrong.X_WC, kWrong);
  const ViewAlignment alignment = AlignViews(wrong, TableViews()[0]);
  ASSERT_TRUE(alignment.is_aligned);
  EXPECT_EQ(alignment.determined, 6);
  EXPECT_TRUE(Contradicts(alignment, wrong, TableViews()[0]));
  EXPECT_GT(alignment.apart_m, 0.02);
  const ViewAlignment alignments[] = {alignment};
  const auto estimate = EstimatePose(wrong, alignments);
  ASSERT_TRUE(estimate.has_value());
  EXPECT_NEAR(estimate->translation_error_m, 0.03, 4 * estimate->sigma_m);
  EXPECT_NEAR(estimate->rotation_error_rad, 2 * kDegree_rad, 4 * estimate->sigma_rad);
  // A twentieth of the error is left.
  EXPECT_LT(MissAtTable_m(estimate->X_WC, TableViews()[1].X_WC),
            0.1 * MissAtTable_m(wrong.X_WC, TableViews()[1].X_WC));
}

TEST(SensorAlignmentTest, TheOtherSensorSeesTheOppositeMotion) {
  MeanView wrong = TableViews()[1];
  wrong.X_WC = Moved(wrong.X_WC, kWrong);
  const ViewAlignment there = AlignViews(wrong, TableViews()[0]);
  const ViewAlignment back = Reversed(there, wrong, TableViews()[0]);
  // Points that the other sensor sees go the other way by as much.
  const Pose X_WC = Moved(wrong.X_WC, there.twist);
  const Pose X_WC_other = Moved(TableViews()[0].X_WC, back.twist);
  const Vector3 forth = X_WC * (wrong.X_WC.inverse() * kMiddle) - kMiddle;
  const Vector3 opposite = X_WC_other * (TableViews()[0].X_WC.inverse() * kMiddle) - kMiddle;
  EXPECT_LT((forth + opposite).norm(), 0.1 * forth.norm());
  EXPECT_NEAR(back.twist.dot(back.information * back.twist),
              there.twist.dot(there.information * there.twist), 1e-6 * there.information.norm());
}

TEST(SensorAlignmentTest, PosesWithinTheirErrorsAreNoContradiction) {
  for (const double share : {0.0, 0.1, 0.3}) {
    MeanView view = TableViews()[1];
    view.X_WC = Moved(view.X_WC, share * kWrong);
    const ViewAlignment alignment = AlignViews(view, TableViews()[0]);
    ASSERT_TRUE(alignment.is_aligned);
    EXPECT_FALSE(Contradicts(alignment, view, TableViews()[0])) << share;
    const ViewAlignment alignments[] = {alignment};
    const auto estimate = EstimatePose(view, alignments);
    ASSERT_TRUE(estimate.has_value());
    EXPECT_NEAR(estimate->translation_error_m, share * 0.03, 4 * estimate->sigma_m);
  }
}

TEST(SensorAlignmentTest, PosesThatAreKnownBetterContradictSooner) {
  MeanView view = TableViews()[1];
  view.X_WC = Moved(view.X_WC, 0.3 * kWrong);
  MeanView other = TableViews()[0];
  for (MeanView* each : {&view, &other}) each->pose_sigma_m = each->pose_sigma_rad = 0.0005;
  EXPECT_TRUE(Contradicts(AlignViews(view, other), view, other));
}

TEST(SensorAlignmentTest, ATableAloneDeterminesItsHeightAndSlopeOnly) {
  std::vector<MeanView> views = Views(Table(false));
  views[1].X_WC = Moved(views[1].X_WC, Twist({0, 0, 0.03}, Vector3::Zero()));
  const ViewAlignment alignment = AlignViews(views[1], views[0]);
  ASSERT_TRUE(alignment.is_aligned);
  EXPECT_EQ(alignment.determined, 3);
  EXPECT_NEAR(alignment.twist[2], -0.03, 0.005);
  const ViewAlignment alignments[] = {alignment};
  std::optional<Vector6> undetermined;
  EXPECT_FALSE(EstimatePose(views[1], alignments, &undetermined).has_value());
  ASSERT_TRUE(undetermined.has_value());
  // It slides on the table, or turns about the vertical.
  const Vector3 turn = undetermined->tail<3>();
  EXPECT_LT(turn.head<2>().norm(), 0.1);
}

TEST(SensorAlignmentTest, ViewsOfDifferentPlacesSayNothing) {
  MeanView away = TableViews()[1];
  away.X_WC.translation() += Vector3(0, 20, 0);
  const ViewAlignment alignment = AlignViews(away, TableViews()[0]);
  EXPECT_FALSE(alignment.is_aligned);
  EXPECT_FALSE(Contradicts(alignment, away, TableViews()[0]));
  EXPECT_FALSE(EstimatePose(away, {&alignment, 1}).has_value());
}

TEST(SensorAlignmentTest, APoseThatIsWrongByHalfAMetreContradictsWithoutAnEstimate) {
  MeanView wrong = TableViews()[1];
  wrong.X_WC.translation() += Vector3(0.1, 0.2, 0.5);
  const ViewAlignment alignment = AlignViews(wrong, TableViews()[0]);
  EXPECT_FALSE(alignment.is_aligned);
  EXPECT_TRUE(Contradicts(alignment, wrong, TableViews()[0]));
  EXPECT_FALSE(EstimatePose(wrong, {&alignment, 1}).has_value());
}

TEST(SensorAlignmentTest, OneWrongSensorDoesNotPullARightOne) {
  MeanView wrong = TableViews()[1];
  wrong.X_WC = Moved(wrong.X_WC, kWrong);
  const MeanView& right = TableViews()[0];
  const ViewAlignment alignments[] = {AlignViews(right, wrong), AlignViews(right, TableViews()[2])};
  const auto estimate = EstimatePose(right, alignments);
  ASSERT_TRUE(estimate.has_value());
  EXPECT_LT(estimate->translation_error_m, 4 * estimate->sigma_m);
  const ViewAlignment of_wrong[] = {AlignViews(wrong, right), AlignViews(wrong, TableViews()[2])};
  const auto corrected = EstimatePose(wrong, of_wrong);
  ASSERT_TRUE(corrected.has_value());
  EXPECT_LT(MissAtTable_m(corrected->X_WC, TableViews()[1].X_WC), 0.006);
}

TEST(SensorAlignmentTest, TheMeanIsOfWhatRestsAndShowsInMostFrames) {
  constexpr int kWidth = 7;
  DepthCamera camera;
  camera.width = kWidth;
  camera.height = 1;
  std::vector<StillFrame> frames;
  for (int k = 0; k < 8; ++k) {
    auto image = std::make_shared<DepthImage>();
    image->width = kWidth;
    image->height = 1;
    image->depth_m.assign(kWidth, 1.0F);
    auto classes = std::make_shared<FrameClasses>();
    classes->pixels.assign(kWidth, PixelClass::kConsistent);
    const auto miss = [&](std::size_t pixel) {
      image->depth_m[pixel] = 0;
      classes->pixels[pixel] = PixelClass::kMissing;
    };
    image->depth_m[1] += 0.01F * static_cast<float>(k);
    if (k % 2 == 0) miss(2);  // it flickers
    if (k == 7) classes->pixels[3] = PixelClass::kRobot;
    if (k < 3) miss(4);                        // it has come
    if (k > 4) miss(5);                        // it has gone
    if (k % 4 == 1) image->depth_m[6] = 1.2F;  // beside an edge
    frames.push_back({std::move(image), std::move(classes)});
  }
  EXPECT_THAT(MeanAtRest(frames, camera, {}), testing::ElementsAre(1.0F, 0, 1.0F, 0, 0, 0, 1.0F));
}

}  // namespace
}  // namespace cwm::perception
