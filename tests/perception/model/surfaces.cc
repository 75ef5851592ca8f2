#include "tests/perception/model/surfaces.h"

#include <cmath>

#include "perception/cloud/measured_points.h"
#include "perception/cloud/normals.h"

namespace cwm::perception {
namespace {

Pose LookAt(const Vector3& eye, const Vector3& target) {
  Pose X = Pose::Identity();
  const Vector3 z = (target - eye).normalized();
  const Vector3 x = z.cross(Vector3::UnitZ()).normalized();
  X.linear().col(0) = x;
  X.linear().col(1) = z.cross(x);
  X.linear().col(2) = z;
  X.translation() = eye;
  return X;
}

}  // namespace

SimulatedObject OfOnePart(const Shape& shape, double height_of_center_m) {
  SimulatedObject object;
  object.name = "object";
  object.parts = {{MakeTranslation(0, 0, height_of_center_m), shape}};
  return object;
}

ScannedObject ScanOnTable(const SimulatedObject& object, double distance_m, double elevation_rad,
                          std::uint64_t seed) {
  SimulatedObject table = OfOnePart(Box{.size_m = {1.5, 1.5, 0.02}}, -0.01);
  table.is_support = true;
  const SimulatedScene scene{.objects = {table, object}};
  PinholeCamera camera;
  const Vector3 target(0, 0, 0.05);
  camera.X_WC = LookAt(
      target + distance_m * Vector3(-std::cos(elevation_rad), 0, std::sin(elevation_rad)), target);
  ScanOptions options;
  options.seed = seed;
  const SimulatedCloud scan = Scan(scene, camera, options);
  MeasuredPoints measured = *CollectMeasured(scan.cloud, options.noise);
  EstimateImageNormals(measured, {.max_threads = 1});
  ScannedObject out;
  out.points.viewpoint = camera.X_WC.translation();
  const OrientedPoints& all = measured.oriented;
  constexpr std::size_t kOneRayIn = 7;
  out.passing.weight = kOneRayIn;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (scan.object[all.cloud_index[i]] != 1) {
      if (i % kOneRayIn != 0) continue;
      out.passing.ends.push_back((camera.X_WC * all.points[i].cast<double>()).cast<float>());
      out.passing.sigma_m.push_back(all.sigma_m[i]);
      continue;
    }
    out.points.points.push_back((camera.X_WC * all.points[i].cast<double>()).cast<float>());
    out.points.normals.push_back(
        (camera.X_WC.linear() * all.normals[i].cast<double>()).cast<float>());
    out.points.sigma_m.push_back(all.sigma_m[i]);
    out.points.normal_sigma_rad.push_back(all.normal_sigma_rad[i]);
    out.points.cloud_index.push_back(all.cloud_index[i]);
  }
  out.passing.around_count = out.passing.ends.size();
  return out;
}

}  // namespace cwm::perception
