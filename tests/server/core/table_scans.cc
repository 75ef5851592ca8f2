#include "tests/server/core/table_scans.h"

#include <memory>

namespace cwm::server {
namespace {

constexpr double kTableHeight_m = 0.9;

std::shared_ptr<const HybridModel> ModelOf(const perception::SimulatedObject& object) {
  HybridModel model;
  for (const Placed<>& part : object.parts) {
    model.shapes.push_back({.X_OS = part.X_FS, .shape = part.shape, .fit = {}});
  }
  return std::make_shared<const HybridModel>(std::move(model));
}

// A quarter of the Kinect's resolution in each direction, with the same field of view.
perception::PinholeCamera CoarseCamera() {
  perception::PinholeCamera camera;
  camera.width = 160;
  camera.height = 120;
  camera.focal_px = 525.0 / 4;
  camera.center_x_px = 79.5;
  camera.center_y_px = 59.5;
  camera.X_WC = TableCamera_X_WC();
  return camera;
}

}  // namespace

perception::SimulatedScene EmptyTable() {
  Plate top;
  top.outline = {{-0.5, -0.4}, {0.5, -0.4}, {0.5, 0.4}, {-0.5, 0.4}};
  top.thickness_m = 0.02;
  perception::SimulatedScene scene;
  scene.objects.push_back({.name = "table",
                           .parts = {{Pose::Identity(), top}},
                           .X_WO = MakeTranslation(0, 0, kTableHeight_m),
                           .is_support = true});
  return scene;
}

void AddBox(perception::SimulatedScene& scene, const std::string& name, double x_m, double y_m,
            const Vector3& size_m) {
  scene.objects.push_back({.name = name,
                           .parts = {{Pose::Identity(), Box{size_m}}},
                           .X_WO = MakeTranslation(x_m, y_m, kTableHeight_m + size_m.z() / 2)});
}

perception::SimulatedScene TwoBoxes() {
  perception::SimulatedScene scene = EmptyTable();
  AddBox(scene, "left", 0, 0.2, {0.1, 0.16, 0.12});
  AddBox(scene, "right", 0, -0.2, {0.08, 0.08, 0.2});
  return scene;
}

Pose TableCamera_X_WC() {
  constexpr double kDown_rad = 40 * M_PI / 180;
  // Optical frame: z forward, x right, y down; forward is the world's x before tilting.
  Matrix3 R_WC;
  R_WC.col(0) = -Vector3::UnitY();
  R_WC.col(2) = Vector3(std::cos(kDown_rad), 0, -std::sin(kDown_rad));
  R_WC.col(1) = R_WC.col(2).cross(R_WC.col(0));
  return MakePose({-0.7, 0, kTableHeight_m + 0.6}, Quaternion(R_WC));
}

TableScan ScanTable(const perception::SimulatedScene& scene) {
  const perception::PinholeCamera camera = CoarseCamera();
  const perception::SimulatedCloud simulated =
      perception::Scan(scene, camera, {.noise = {}, .noiseless = true, .seed = 1});
  TableScan scan{.cloud = simulated.cloud, .truth = {}};
  scan.truth.X_WC = camera.X_WC;
  scan.truth.supports.push_back(
      {.X_WO = scene.objects[0].X_WO, .model = ModelOf(scene.objects[0]), .reachable = true});
  scan.truth.labels.resize(simulated.cloud.size());
  std::uint32_t label = 10;  // object i, from 1, takes 10 * (i + 1)
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    perception::DetectedObject detected;
    for (std::size_t p = 0; p < simulated.cloud.size(); ++p) {
      if (simulated.object[p] != static_cast<std::int32_t>(i)) continue;
      scan.truth.labels[p] = i == 0 ? 1 : label + 10;
      detected.points_L.push_back(
          (camera.X_WC.linear() * simulated.cloud.points[p].cast<double>()).cast<float>());
    }
    if (i == 0 || detected.points_L.empty()) continue;  // the table, or hidden altogether
    detected.X_WO = scene.objects[i].X_WO;
    detected.model = ModelOf(scene.objects[i]);
    detected.supported_by = 0;
    scan.truth.objects.push_back(std::move(detected));
    label += 10;
  }
  scan.truth.report.points_in = simulated.cloud.size();
  return scan;
}

IngestRequest RequestFor(const TableScan& scan) {
  IngestRequest request;
  request.cloud = scan.cloud;
  request.sensor = "head";
  request.options.X_WC = scan.truth.X_WC;
  return request;
}

Interpreter TruthOf(const TableScan& scan) {
  return [scan](const perception::PointCloud&, const perception::InterpretOptions&,
                std::stop_token) -> absl::StatusOr<perception::SceneInterpretation> {
    return scan.truth;
  };
}

}  // namespace cwm::server
