#include "tests/perception/track/head_on.h"

#include <cmath>
#include <utility>

namespace cwm::perception {
namespace {

constexpr int kHalfWidth_px = 160, kHalfHeight_px = 120;
constexpr double kFocal_px = 260;

Pose PlaceOf(const HeadOnBox& box) {
  return MakePose(kHeadOnSensor_W + box.middle_L, Quaternion::Identity());
}

// The depth at which a ray meets the front of the box, given its direction per metre of depth; more
// than the wall's depth if it misses.
double DepthOfFront_m(const HeadOnBox& box, const Vector3& direction) {
  const double depth_m = box.middle_L.z() - 0.5 * box.size_m.z();
  const Vector3 from_middle = depth_m * direction - box.middle_L;
  const bool hits = std::abs(from_middle.x()) <= 0.5 * box.size_m.x() &&
                    std::abs(from_middle.y()) <= 0.5 * box.size_m.y();
  return hits ? depth_m : 2 * kWallDepth_m;
}

}  // namespace

std::shared_ptr<const HybridModel> ModelOfBox(const HeadOnBox& box) {
  HybridModel model;
  model.shapes.push_back({.shape = Box{box.size_m}, .fit = {}});
  return std::make_shared<const HybridModel>(std::move(model));
}

KnownObject KnownBox(const std::string& name, const HeadOnBox& box) {
  return {.name = name, .X_WO = PlaceOf(box), .model = ModelOfBox(box)};
}

HeadOnScan::HeadOnScan(std::vector<HeadOnBox> boxes)
    : boxes_(std::move(boxes)),
      image_(See(boxes_)),
      evidence_(image_.cloud, MakePose(kHeadOnSensor_W, Quaternion::Identity()),
                {.model = SensorModel::kGiven, .given_sigma_m = 0.002}) {}

HeadOnScan::Image HeadOnScan::See(const std::vector<HeadOnBox>& boxes) {
  Image image;
  image.cloud.width = 2 * kHalfWidth_px + 1;
  image.cloud.height = 2 * kHalfHeight_px + 1;
  for (int v = -kHalfHeight_px; v <= kHalfHeight_px; ++v) {
    for (int u = -kHalfWidth_px; u <= kHalfWidth_px; ++u) {
      const Vector3 direction(u / kFocal_px, v / kFocal_px, 1);
      double depth_m = kWallDepth_m;
      int owner = -1;
      for (std::size_t k = 0; k < boxes.size(); ++k) {
        const double front_m = DepthOfFront_m(boxes[k], direction);
        if (front_m < depth_m) depth_m = front_m, owner = static_cast<int>(k);
      }
      image.cloud.points.push_back((depth_m * direction).cast<float>());
      image.owner.push_back(owner);
    }
  }
  return image;
}

DetectedObject HeadOnScan::Detected(std::size_t box) const {
  DetectedObject object;
  object.X_WO = PlaceOf(boxes_[box]);
  object.model = ModelOfBox(boxes_[box]);
  for (std::size_t i = 0; i < image_.owner.size(); ++i) {
    if (image_.owner[i] == static_cast<int>(box)) object.points_L.push_back(image_.cloud.points[i]);
  }
  return object;
}

SceneInterpretation HeadOnScan::Scene() const {
  SceneInterpretation scene;
  scene.X_WC = MakePose(kHeadOnSensor_W, Quaternion::Identity());
  for (std::size_t k = 0; k < boxes_.size(); ++k) scene.objects.push_back(Detected(k));
  return scene;
}

}  // namespace cwm::perception
