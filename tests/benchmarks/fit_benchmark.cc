// Model fitting alone, beside CGAL's Efficient_RANSAC on the same points and normals.
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "perception/cloud/measured_points.h"
#include "perception/modeler/object_modeler.h"
#include "perception/segmentation/segment_scene.h"
#include "tests/benchmarks/benchmark_scans.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/support/process.h"

namespace cwm::benchmarks {
namespace {

using perception::OrientedPoints;

// One object as the interpreter hands it to the modeler.
struct FitObject {
  OrientedPoints points;
  std::optional<Pose> X_LSupport;
};

std::vector<FitObject> FitObjectsOf(const perception::PointCloud& cloud) {
  auto measured = perception::CollectMeasured(cloud, {});
  if (!measured.ok()) return {};
  const auto scene = perception::SegmentScene(*std::move(measured), {});
  if (!scene.ok()) return {};
  std::vector<FitObject> objects;
  for (const perception::SegmentedHypothesis& object : scene->hypotheses) {
    if (object.supported_by < 0) continue;
    FitObject& out = objects.emplace_back();
    out.points.viewpoint = scene->points.viewpoint;
    for (std::uint32_t i : object.points) {
      out.points.points.push_back(scene->points.points[i]);
      out.points.normals.push_back(scene->points.normals[i]);
      out.points.sigma_m.push_back(scene->points.sigma_m[i]);
      out.points.normal_sigma_rad.push_back(scene->points.normal_sigma_rad[i]);
      out.points.cloud_index.push_back(scene->points.cloud_index[i]);
    }
    Pose X_LSupport = scene->supports[static_cast<std::size_t>(object.supported_by)].plate.X_FS;
    X_LSupport.translate(Vector3(0, 0, object.foot_height_m));
    out.X_LSupport = X_LSupport;
  }
  return objects;
}

struct FitTimes {
  double ms = 0;
  double points = 0;
  double explained = 0;

  double coverage() const { return points > 0 ? explained / points : 0; }
};

FitTimes FitOurs(const std::vector<FitObject>& objects) {
  FitTimes times;
  for (const FitObject& object : objects) {
    const auto start = std::chrono::steady_clock::now();
    const perception::ObjectModel model =
        perception::ModelObject(object.points, object.X_LSupport, {}, {});
    times.ms +=
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    times.points += static_cast<double>(object.points.size());
    for (std::int32_t part : model.part_of_point) {
      times.explained += part != perception::kUnexplained;
    }
  }
  return times;
}

void WriteObjects(const std::vector<FitObject>& objects, const std::string& path) {
  std::ofstream file(path, std::ios::binary);
  for (const FitObject& object : objects) {
    const auto count = static_cast<std::uint32_t>(object.points.size());
    file.write(reinterpret_cast<const char*>(&count), sizeof(count));
    for (std::size_t k = 0; k < count; ++k) {
      const Eigen::Vector3f &p = object.points.points[k], &n = object.points.normals[k];
      const std::array<float, 6> row = {p.x(), p.y(), p.z(), n.x(), n.y(), n.z()};
      file.write(reinterpret_cast<const char*>(row.data()), sizeof(row));
    }
  }
}

double MeanSigma_m(const std::vector<FitObject>& objects) {
  double sum = 0, count = 0;
  for (const FitObject& object : objects) {
    for (float sigma_m : object.points.sigma_m) sum += sigma_m, ++count;
  }
  return count > 0 ? sum / count : 0;
}

std::string CgalProgram() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / "cwm-bench-cgal";
}

// Runs CGAL with the modeler's gates and minimum point count, and the same probability (0.01) of
// missing the largest shape; empty if the program failed.
std::optional<FitTimes> FitCgal(const std::vector<FitObject>& objects, const std::string& path) {
  const perception::ModelerOptions ours;
  const double gate_m = 3 * MeanSigma_m(objects);
  const double cosine = std::cos(15 * std::numbers::pi / 180);
  const double gap_m = 2 * gate_m;  // of connected inliers: about as in our own search
  WriteObjects(objects, path);
  const testing::ProcessResult run =
      testing::RunProgram({CgalProgram(), path, std::to_string(gate_m), std::to_string(cosine),
                           std::to_string(ours.min_inliers),
                           std::to_string(ours.missed_shape_probability), std::to_string(gap_m)});
  FitTimes times;
  std::istringstream words(run.out);
  if (run.exit_code != 0 || !(words >> times.ms >> times.points >> times.explained)) {
    return std::nullopt;
  }
  return times;
}

std::string Line(const char* name, const std::vector<FitTimes>& fits) {
  std::vector<double> ms, coverage;
  for (const FitTimes& fit : fits) ms.push_back(fit.ms), coverage.push_back(fit.coverage());
  char text[160];
  std::snprintf(text, sizeof(text), "  %-28s median %8.1f ms a scene, %.4f of the points explained",
                name, Median(ms), Median(coverage));
  return text;
}

}  // namespace

void MeasureFitting(Report& report) {
  if (!std::filesystem::exists(CgalProgram())) {
    return report.Detail("cgal_fit_ratio skipped: no libcgal-dev when this was built");
  }
  const BenchmarkScans scans = LoadBenchmarkScans();
  const testing::ScratchDirectory scratch;
  std::vector<FitTimes> ours, baselines;
  std::vector<double> ratios;
  for (const perception::PointCloud& cloud : scans.clouds) {
    const std::vector<FitObject> objects = FitObjectsOf(cloud);
    if (objects.empty()) continue;
    for (int round = 0; round < 3; ++round) {  // in turn, so that both run under the same load
      const std::optional<FitTimes> baseline = FitCgal(objects, scratch / "objects");
      if (!baseline) return report.Fail("cwm-bench-cgal failed");
      baselines.push_back(*baseline);
      ours.push_back(FitOurs(objects));
      ratios.push_back(baselines.back().ms / ours.back().ms);
    }
  }
  report.Detail("Model fitting alone, one thread, same object points and normals; " + scans.source);
  report.Detail(Line("ours", ours));
  report.Detail(Line("CGAL Efficient_RANSAC", baselines));
  std::vector<double> ours_ms, baselines_ms;
  for (const FitTimes& fit : ours) ours_ms.push_back(fit.ms);
  for (const FitTimes& fit : baselines) baselines_ms.push_back(fit.ms);
  report.Add(AsRatio(
      {.key = "cgal_fit_ratio",
       .value = Median(ours_ms),
       .unit = "ms",
       .baseline = "CGAL Efficient_RANSAC",
       .baseline_value = Median(baselines_ms),
       .ratio = Median(ratios),
       .how = "ModelObject beside CGAL with the same epsilon (3 sigma), angle (15 degrees), "
              "least points (60) and probability 0.01; median of CGAL's time over ours"}));
}

}  // namespace cwm::benchmarks
