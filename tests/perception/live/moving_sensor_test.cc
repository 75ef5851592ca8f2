// A depth camera that moves, with errors of its pose: what it tells of what rests, goes and is new.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "perception/live/new_surfaces.h"
#include "perception/live/past_views.h"
#include "perception/live/tracker.h"
#include "perception/simulation/scenes.h"
#include "tests/perception/live/still_sensor.h"

namespace cwm::perception {
namespace {

constexpr PoseSigma kPoseSigma = {.translation_m = 0.003, .rotation_rad = 0.0035};

// The camera goes along a line over a random table; its poses err by kPoseSigma in each frame.
class MovingSensor {
 public:
  explicit MovingSensor(std::uint64_t seed)
      : sensor_(RandomTable(seed, 6), Halved(KitchenCamera())),
        bodies_(KnownBodies(sensor_.scene)),
        random_(seed) {}

  FrameEvidence Observe() {
    sensor_.camera.X_WC.translation().y() += 0.004;
    sensor_.Change();
    const auto image = sensor_.Measure();
    const Stamp stamp(std::chrono::milliseconds(33 * ++frame_));
    return sensor_.view.Observe({.stamp = stamp,
                                 .X_WC = WithError(sensor_.camera.X_WC),
                                 .image = image,
                                 .pose_sigma = kPoseSigma,
                                 .may_move = true},
                                bodies_, {});
  }
  StepResult Step() { return tracker_.Step(Observe(), bodies_); }

  const Pose& true_pose() const { return sensor_.camera.X_WC; }
  const Pose& given_pose() const { return given_; }
  std::vector<KnownBody>& bodies() { return bodies_; }
  SimulatedScene& scene() { return sensor_.scene; }
  Tracker& tracker() { return tracker_; }

 private:
  Pose WithError(const Pose& X_WC) {
    std::normal_distribution<double> normal;
    const auto draw = [&] { return Vector3(normal(random_), normal(random_), normal(random_)); };
    given_ = X_WC;
    given_.translation() += kPoseSigma.translation_m * draw();
    const Vector3 turn = kPoseSigma.rotation_rad * draw();
    given_.linear() =
        Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * X_WC.linear();
    return given_;
  }

  StillSensor sensor_;
  std::vector<KnownBody> bodies_;
  std::mt19937_64 random_;
  Tracker tracker_;
  Pose given_ = Pose::Identity();
  int frame_ = 0;
};

TEST(MovingSensor, SaysNothingOfAStaticTableAndCorrectsItsPose) {
  for (const std::uint64_t seed : {5U, 6U, 7U}) {
    MovingSensor sensor(seed);
    double given_m2 = 0;
    double corrected_m2 = 0;
    for (int frame = 0; frame < 40; ++frame) {
      const FrameEvidence evidence = sensor.Observe();
      const StepResult result = sensor.tracker().Step(evidence, sensor.bodies());
      EXPECT_TRUE(result.changes.empty()) << "seed " << seed << ", frame " << frame;
      EXPECT_TRUE(result.requests.empty()) << "seed " << seed << ", frame " << frame;
      if (frame == 0) continue;
      // The table determines the height of the camera.
      const double height_m = sensor.true_pose().translation().z();
      given_m2 += std::pow(sensor.given_pose().translation().z() - height_m, 2);
      corrected_m2 += std::pow(evidence.X_WC.translation().z() - height_m, 2);
    }
    EXPECT_LT(corrected_m2, 0.6 * given_m2) << "half of the error is left by equal weights";
    EXPECT_EQ(sensor.tracker().FactsOf(1).visibility, Visibility::kVisible);
  }
}

TEST(MovingSensor, RemovesWhatWasTaken) {
  MovingSensor sensor(5);
  for (int frame = 0; frame < 10; ++frame) EXPECT_TRUE(sensor.Step().changes.empty());
  sensor.scene().objects.erase(sensor.scene().objects.begin() + 1);
  int removed_at = -1;
  for (int frame = 0; frame < 20 && removed_at < 0; ++frame) {
    for (const TrackChange& change : sensor.Step().changes) {
      EXPECT_EQ(change.kind, TrackChange::Kind::kRemove);
      EXPECT_EQ(change.body, 1);
      removed_at = frame;
    }
  }
  EXPECT_GE(removed_at, 2);
}

TEST(PastViews, KnowsWhereRaysPassed) {
  const DepthCamera camera = CameraOf(Halved({}));
  const DepthNoise noise(camera, SensorNoise());
  PastViews past(camera, noise);
  auto wall = std::make_shared<DepthImage>(
      DepthImage{camera.width, camera.height, std::vector<float>(camera.pixel_count(), 1.0F)});
  past.Keep(wall, Pose::Identity(), kPoseSigma, Stamp());
  EXPECT_TRUE(past.SawThrough({0, 0, 0.8}, kPoseSigma));
  EXPECT_FALSE(past.SawThrough({0, 0, 1.0}, kPoseSigma)) << "it is on the wall";
  EXPECT_FALSE(past.SawThrough({0, 0, 1.2}, kPoseSigma)) << "it was hidden";
  EXPECT_FALSE(past.SawThrough({2, 0, 0.8}, kPoseSigma)) << "it was out of view";
}

// A plate of 0.6 x 0.6 m with its middle at x.
DetectedSupport SupportAt(double x_m) {
  auto model = std::make_shared<HybridModel>();
  model->shapes.push_back(
      {.shape = Plate{.outline = {{-0.3, -0.3}, {0.3, -0.3}, {0.3, 0.3}, {-0.3, 0.3}},
                      .holes = {},
                      .thickness_m = 0.02}});
  DetectedSupport support;
  support.X_WO = MakeTranslation(x_m, 0, 0);
  support.model = std::move(model);
  return support;
}

TEST(NewSurfaces, GrowAKnownSupportWhereItGoesOn) {
  FrameEvidence frame;
  frame.X_WC.translation() = Vector3(0.3, 0, 1);
  frame.pose_sigma = kPoseSigma;
  const std::vector<KnownBody> bodies = {{.id = 4,
                                          .kind = KnownBody::Kind::kSupport,
                                          .X_WB = MakeTranslation(0, 0, 0),
                                          .model = SupportAt(0).model}};
  SceneInterpretation scene;
  scene.supports = {SupportAt(0.4), SupportAt(0.03), SupportAt(3)};
  const NewSurfaces found = FindNewSurfaces(frame, bodies, {}, scene);
  ASSERT_EQ(found.grown.size(), 1U);
  EXPECT_EQ(found.grown[0].body, 4);
  EXPECT_EQ(found.grown[0].supports, std::vector<int>({0})) << "not its fringe, nor another table";
  ASSERT_EQ(found.grown[0].model->shapes.size(), 2U);
  EXPECT_NEAR(found.grown[0].model->shapes[1].X_OS.translation().x(), 0.4, 1e-12);
}

// The sensor is asked again about what it found where a body has passed since.
TEST(NewSurfaces, LeaveWhatIsOnTheWayOfABodyThatMovedSince) {
  FrameEvidence frame;
  frame.camera = CameraOf(Halved({}));
  frame.pose_sigma = kPoseSigma;
  auto classes = std::make_shared<FrameClasses>();
  classes->block_columns = (frame.camera.width + kBlock_px - 1) / kBlock_px;
  frame.classes = std::move(classes);
  auto model = std::make_shared<HybridModel>();
  model->shapes.push_back({.shape = Box{.size_m = {0.06, 0.06, 0.06}}});
  DetectedObject box{
      .X_WO = MakeTranslation(0, 0, 1.03), .model = std::move(model), .points_L = {}};
  for (int row = -5; row < 5; ++row) {
    for (int column = -5; column < 5; ++column) {
      box.points_L.emplace_back(0.006F * static_cast<float>(column),
                                0.006F * static_cast<float>(row), 1.0F);
    }
  }
  const Aabb way_W(Vector3(-0.05, -0.05, 0.99), Vector3(0.2, 0.05, 1.1));
  const Aabb beside_W(Vector3(0.1, -0.05, 0.99), Vector3(0.3, 0.05, 1.1));
  for (const auto& [ways_W, is_left] :
       {std::pair{std::vector{way_W}, true}, std::pair{std::vector{beside_W}, false}}) {
    SceneInterpretation scene;
    scene.objects = {box};
    const NewSurfaces found = FindNewSurfaces(frame, {}, ways_W, scene);
    EXPECT_EQ(scene.objects.empty(), is_left);
    EXPECT_EQ(found.cut_blocks.empty(), !is_left);
  }
}

}  // namespace
}  // namespace cwm::perception
