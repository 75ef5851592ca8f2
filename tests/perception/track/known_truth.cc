#include "tests/perception/track/known_truth.h"

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <tuple>

#include "perception/simulation/random_draws.h"

namespace cwm::perception {
namespace {

constexpr double kFitSigma_m = 0.001;
constexpr std::size_t kMinPoints = 30;

Shape Perturbed(const Shape& shape, RandomDraws& draws) {
  Shape perturbed = shape;
  const double error_m = kFitSigma_m * draws.Normal();
  if (auto* sphere = std::get_if<Sphere>(&perturbed)) sphere->radius_m += error_m;
  if (auto* box = std::get_if<Box>(&perturbed)) box->size_m.array() += error_m;
  if (auto* cylinder = std::get_if<Cylinder>(&perturbed)) cylinder->radius_m += error_m;
  if (auto* cone = std::get_if<Cone>(&perturbed)) cone->radius_bottom_m += error_m;
  return perturbed;
}

std::shared_ptr<const HybridModel> FittedModel(const SimulatedObject& object, int point_count,
                                               RandomDraws& draws) {
  HybridModel model;
  for (const Placed<>& part : object.parts) {
    model.shapes.push_back({.X_OS = part.X_FS,
                            .shape = Perturbed(part.shape, draws),
                            .role = PartRole::kFitted,
                            .fit = FitQuality{.inlier_count = point_count, .parameter_sigma = {}}});
  }
  model.point_count = point_count;
  return std::make_shared<const HybridModel>(std::move(model));
}

Pose Perturbed(Pose X_WO, RandomDraws& draws) {
  for (int axis = 0; axis < 3; ++axis) X_WO.translation()[axis] += kFitSigma_m * draws.Normal();
  return X_WO;
}

// One point of each cell of 4 mm.
std::vector<Eigen::Vector3f> Subsampled(const std::vector<Eigen::Vector3f>& points) {
  std::set<std::tuple<int, int, int>> seen;
  std::vector<Eigen::Vector3f> thinned;
  for (const Eigen::Vector3f& p : points) {
    const Eigen::Vector3i cell = (p / 0.004F).array().floor().cast<int>();
    if (seen.insert({cell.x(), cell.y(), cell.z()}).second) thinned.push_back(p);
  }
  return thinned;
}

}  // namespace

TrueScan ScanAndInterpret(const SimulatedScene& scene, const PinholeCamera& camera,
                          std::uint64_t seed) {
  TrueScan result{.scan = Scan(scene, camera, {.seed = seed}),
                  .scene = {},
                  .object_names = {},
                  .support_names = {}};
  result.scene.X_WC = camera.X_WC;
  std::map<int, std::vector<Eigen::Vector3f>> points_of;
  for (std::size_t i = 0; i < result.scan.object.size(); ++i) {
    if (result.scan.object[i] < 0) continue;
    points_of[result.scan.object[i]].push_back(camera.X_WC.linear().cast<float>() *
                                               result.scan.cloud.points[i]);
  }
  RandomDraws draws(seed, 100);
  for (const auto& [index, points] : points_of) {
    const SimulatedObject& object = scene.objects[index];
    if (points.size() < kMinPoints) continue;
    const auto model = FittedModel(object, static_cast<int>(points.size()), draws);
    if (object.is_support) {
      result.scene.supports.push_back({.X_WO = object.X_WO,
                                       .model = model,
                                       .reachable = std::nullopt,
                                       .point_count = static_cast<int>(points.size())});
      result.support_names.push_back(object.name);
      continue;
    }
    const bool residual = object.name == "wall" || object.name == "cabinet";
    result.scene.objects.push_back(
        {.kind = residual ? DetectedKind::kResidual : DetectedKind::kObject,
         .X_WO = Perturbed(object.X_WO, draws),
         .model = model,
         .supported_by = residual ? -1 : 0,
         .points_L = Subsampled(points)});
    result.object_names.push_back(object.name);
  }
  return result;
}

std::vector<KnownObject> Remember(const TrueScan& scan) {
  std::vector<KnownObject> known;
  for (std::size_t i = 0; i < scan.scene.supports.size(); ++i) {
    const DetectedSupport& support = scan.scene.supports[i];
    known.push_back({.name = scan.support_names[i],
                     .kind = KnownObject::Kind::kSupport,
                     .X_WO = support.X_WO,
                     .model = support.model});
  }
  for (std::size_t i = 0; i < scan.scene.objects.size(); ++i) {
    const DetectedObject& object = scan.scene.objects[i];
    known.push_back({.name = scan.object_names[i],
                     .kind = object.kind == DetectedKind::kObject ? KnownObject::Kind::kObject
                                                                  : KnownObject::Kind::kResidual,
                     .X_WO = object.X_WO,
                     .model = object.model});
  }
  return known;
}

int IndexOf(const SimulatedScene& scene, const std::string& name) {
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (scene.objects[i].name == name) return static_cast<int>(i);
  }
  throw std::invalid_argument("no object " + name);
}

int IndexOf(const std::vector<KnownObject>& known, const std::string& name) {
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (known[i].name == name) return static_cast<int>(i);
  }
  throw std::invalid_argument("no known object " + name);
}

int IndexOf(const TrueScan& scan, const std::string& object_name) {
  for (std::size_t i = 0; i < scan.object_names.size(); ++i) {
    if (scan.object_names[i] == object_name) return static_cast<int>(i);
  }
  throw std::invalid_argument("no detection of " + object_name);
}

}  // namespace cwm::perception
