// Shows a world what a depth camera sees, and lists what it makes of it. The camera, which looks
// down at a ball on a table, is computed here.
#include <cwm/client.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <type_traits>
#include <variant>

constexpr int kWidth = 320, kHeight = 240;

// Points of the camera's optical frame (z forward, x right, y down), row by row.
Eigen::Matrix3Xf BallOnATable(double table_m, double radius_m) {
  constexpr double kFocal_px = 280;
  const Eigen::Vector3d centre(0.1, 0, table_m - radius_m);
  Eigen::Matrix3Xf points(3, kWidth * kHeight);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const Eigen::Vector3d ray((u - kWidth / 2.0) / kFocal_px, (v - kHeight / 2.0) / kFocal_px, 1);
      const double a = ray.squaredNorm(), b = ray.dot(centre);
      const double root = b * b - a * (centre.squaredNorm() - radius_m * radius_m);
      const double depth_m = root > 0 ? (b - std::sqrt(root)) / a : table_m;
      points.col(v * kWidth + u) = (depth_m * ray).cast<float>();
    }
  }
  return points;
}

int main() try {
  const cwm::World world = cwm::Connect({.world = "ingest_scan"});
  Eigen::Isometry3d X_WS(Eigen::Translation3d(0, 0, 1.0));  // 1 m above the table
  X_WS.rotate(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  const Eigen::Matrix3Xf points = BallOnATable(1.0, 0.12);
  // A cloud of PCL is cloud.getMatrixXfMap(3, 4, 0).

  const cwm::IngestResult scan =
      world.Ingest(points, {.X_WS = X_WS, .sensor = cwm::SensorModel::kKinect, .height = kHeight});
  std::printf("%lld of %lld points explained\n",
              static_cast<long long>(scan.report.points_explained),
              static_cast<long long>(scan.report.points_finite));
  for (const cwm::Object& object : scan.objects) {
    const Eigen::Vector3d p = object.X_WO.translation();
    std::printf("%s at %.2f %.2f %.2f, %zu points\n", object.name.c_str(), p.x(), p.y(), p.z(),
                scan.PointsOf(object.name).size());
    for (const cwm::Part& part : object.parts) {
      if (const auto* sphere = std::get_if<cwm::Sphere>(&part.shape)) {
        std::printf("  sphere, radius %.1f mm", 1e3 * sphere->radius_m);
      } else {
        std::printf("  shape %zu", part.shape.index());
      }
      if (part.fit) std::printf(", rms %.1f mm", 1e3 * part.fit->rms_m);
      std::printf("\n");
    }
  }
} catch (const cwm::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
