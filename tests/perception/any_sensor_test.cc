// One table with three objects, scanned with each sensor model and in each form that a cloud may
// have. Objects that stand out from the sensor's noise are found.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "perception/simulation/unorganised.h"
#include "tests/perception/table_scene.h"

namespace cwm::perception {
namespace {

enum class Form { kImage, kBodyImage, kShuffled };

struct Seen {
  std::string name;
  SensorNoise noise;
  Form form = Form::kImage;
  double error_m = 0;  // of sizes and positions: what this sensor's noise at 1.1 m explains
};

void PrintTo(const Seen& seen, std::ostream* out) { *out << seen.name; }

SensorNoise Given(double sigma_m) {
  return {.model = SensorModel::kGiven, .given_sigma_m = sigma_m};
}

std::vector<Seen> AllSensors() {
  std::vector<Seen> all;
  const auto add = [&](const std::string& name, const SensorNoise& noise, double error_m) {
    all.push_back({name, noise, Form::kImage, error_m});
    all.push_back({name + "InABodysFrame", noise, Form::kBodyImage, error_m});
    // Cells of 2.7 sigma are 30 mm wide there: a box of 0.1 m is three cells wide.
    if (noise.model == SensorModel::kTimeOfFlight) return;
    all.push_back({name + "InAnyOrder", noise, Form::kShuffled, error_m});
  };
  add("TenthOfAMillimetre", Given(1e-4), 0.004);  // pixels on the tops are as far apart
  add("ThirdOfAMillimetre", Given(3e-4), 0.003);
  add("Millimetre", Given(1e-3), 0.003);
  add("ThreeMillimetres", Given(3e-3), 0.006);
  add("Kinect", {}, 0.005);
  add("RealSense", {.model = SensorModel::kRealSense}, 0.015);
  add("TimeOfFlight", {.model = SensorModel::kTimeOfFlight}, 0.025);
  return all;
}

class AnySensor : public ::testing::TestWithParam<Seen> {};

// X_BC: the pose of the optical frame in a body frame with x forward and z up.
Pose BodyOfCamera() {
  Pose X_BC = Pose::Identity();
  X_BC.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return X_BC;
}

std::string Bounds(const Aabb& bounds) {
  std::ostringstream text;
  text << bounds.min().transpose() << " to " << bounds.max().transpose();
  return text.str();
}

std::string Listed(const SceneInterpretation& scene) {
  std::string list;
  for (const DetectedObject& object : scene.objects) {
    list += object.kind == DetectedKind::kObject ? "\n  object" : "\n  residual";
    for (const ShapePart& part : object.model->shapes) {
      list += " " + std::string(NameOf(KindOf(part.shape))) + " " +
              Bounds(TightBounds(part.shape, object.X_WO * part.X_OS));
    }
  }
  return list;
}

auto CountObjects(const SceneInterpretation& scene) {
  return std::ranges::count(scene.objects, DetectedKind::kObject, &DetectedObject::kind);
}

// The merged, unordered cloud of two cameras that face each other across the table, in the frame of
// the first.
PointCloud FromBothSides(const SimulatedScene& scene) {
  const PinholeCamera near = TableCamera();
  PinholeCamera far = near;
  far.X_WC = Eigen::AngleAxisd(std::numbers::pi, Vector3::UnitZ()) * near.X_WC;
  PointCloud merged;
  for (const PinholeCamera& camera : {near, far}) {
    const Pose X_NearC = near.X_WC.inverse() * camera.X_WC;
    const PointCloud cloud = Shuffled(Scan(scene, camera, {.noise = {}}), 1).cloud;
    for (const Eigen::Vector3f& p : cloud.points) {
      merged.points.push_back((X_NearC * p.cast<double>()).cast<float>());
    }
  }
  merged.width = static_cast<int>(merged.points.size());
  merged.height = 1;
  return merged;
}

// The points that the far camera sees lie behind those that the near camera sees. If all rays began
// at one viewpoint, they would cross the can, and the far wall would be seen from inside.
TEST(MergedViews, ShowCansFromBothSides) {
  for (const double radius_m : {0.05, 0.06, 0.07}) {
    for (const double length_m : {0.18, 0.22}) {
      const Cylinder can{.radius_m = radius_m, .length_m = length_m};
      SCOPED_TRACE(testing::Message() << radius_m << " by " << length_m << " m");
      const SimulatedScene scene{
          {Table(), MakeObject("can", can, MakeTranslation(0, 0.1, 0.5 * length_m))}};
      InterpretOptions options;
      options.X_WC = TableCamera().X_WC;
      const auto found = InterpretScene(FromBothSides(scene), options);
      ASSERT_TRUE(found.ok()) << found.status();
      ASSERT_EQ(CountObjects(*found), 1) << Listed(*found);
      ASSERT_EQ(found->objects.front().model->shapes.size(), 1u) << Listed(*found);
      const ShapePart& part = found->objects.front().model->shapes.front();
      const auto* cylinder = std::get_if<Cylinder>(&part.shape);
      ASSERT_NE(cylinder, nullptr) << Listed(*found);
      EXPECT_NEAR(cylinder->radius_m, can.radius_m, 0.002);
      EXPECT_NEAR(cylinder->length_m, can.length_m, 0.004);
    }
  }
}

TEST_P(AnySensor, FindsWhatStandsOnATable) {
  const Seen& seen = GetParam();
  const SimulatedScene scene{
      {Table(), MakeObject("box", Box{{0.1, 0.14, 0.16}}, MakeTranslation(0.05, -0.25, 0.08)),
       MakeObject("can", Cylinder{0.06, 0.18}, MakeTranslation(0, 0, 0.09)),
       MakeObject("ball", Sphere{0.07}, MakeTranslation(-0.05, 0.25, 0.07))}};
  const PinholeCamera camera = TableCamera();
  SimulatedCloud scan = Scan(scene, camera, {.noise = seen.noise});
  InterpretOptions options;
  options.noise = seen.noise;
  options.X_WC = camera.X_WC;
  if (seen.form == Form::kShuffled) scan = Shuffled(scan, 1);
  if (seen.form == Form::kBodyImage) {
    const Pose X_BC = BodyOfCamera();
    for (Eigen::Vector3f& p : scan.cloud.points) p = (X_BC * p.cast<double>()).cast<float>();
    options.X_WC = camera.X_WC * X_BC.inverse();
  }
  const auto found = InterpretScene(scan.cloud, options);
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_EQ(found->supports.size(), 1u);
  // In an unordered cloud whose noise is far below the cell width, a lid can be cut off.
  if (seen.form != Form::kShuffled) {
    EXPECT_EQ(CountObjects(*found), 3) << Listed(*found);
  }
  for (std::size_t k = 1; k < scene.objects.size(); ++k) {
    const SimulatedObject& truth = scene.objects[k];
    const Aabb true_bounds = BoundsInWorld(truth);
    const auto is_it = [&](const DetectedObject& object) {
      if (object.kind != DetectedKind::kObject || object.model->shapes.size() != 1) return false;
      const ShapePart& part = object.model->shapes[0];
      const Aabb bounds = TightBounds(part.shape, object.X_WO * part.X_OS);
      const double off_m = std::max((bounds.min() - true_bounds.min()).cwiseAbs().maxCoeff(),
                                    (bounds.max() - true_bounds.max()).cwiseAbs().maxCoeff());
      return KindOf(object.model->shapes[0].shape) == KindOf(truth.parts[0].shape) &&
             off_m <= seen.error_m;
    };
    EXPECT_EQ(std::count_if(found->objects.begin(), found->objects.end(), is_it), 1)
        << truth.name << " of " << Bounds(true_bounds) << ", found:" << Listed(*found);
  }
}

INSTANTIATE_TEST_SUITE_P(All, AnySensor, ::testing::ValuesIn(AllSensors()),
                         [](const auto& named) { return named.param.name; });

}  // namespace
}  // namespace cwm::perception
