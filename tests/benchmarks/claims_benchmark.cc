// Nothing lost, nothing invented: the claims of interpretations compared with the measurements, on
// real and on simulated scans.
#include <algorithm>
#include <array>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "perception/cloud/parallel_for.h"
#include "perception/interpret_scene.h"
#include "tests/benchmarks/benchmark_scans.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/quality/coverage.h"
#include "tests/benchmarks/quality/free_space.h"
#include "tests/benchmarks/quality/simulated_case.h"

namespace cwm::benchmarks {
namespace {

using perception::SceneFamily;

constexpr int kThreads = 2;
// Every third finite point and the rays of every fourth column and row: 19 200 of a Kinect's image,
// at the same places in every scan.
constexpr std::size_t kPointStride = 3;
constexpr int kRayStride = 4;
constexpr std::size_t kBoxScans = 25;          // the first scans of mosd/learn contain boxes only
constexpr std::uint64_t kSeedsPerFamily = 24;  // of each family of simulated scenes

struct Claims {
  bool ok = false;
  Coverage coverage;
  FreeSpace free_space;
  Coverage explained;  // points on true objects, by shapes
  int curved = 0;      // cylinders, spheres, cones and vessels of 300 points or more

  void Add(const Claims& other) {
    coverage.Add(other.coverage);
    free_space.Add(other.free_space);
    explained.Add(other.explained);
    curved += other.curved;
  }
};

int CurvedShapes(const perception::SceneInterpretation& scene) {
  constexpr int kCountedPoints = 300;
  int count = 0;
  for (const perception::DetectedObject& object : scene.objects) {
    for (const ShapePart& part : object.model->shapes) {
      const ShapeKind kind = KindOf(part.shape);
      const bool curved = kind == ShapeKind::kCylinder || kind == ShapeKind::kSphere ||
                          kind == ShapeKind::kCone || kind == ShapeKind::kCapsule ||
                          part.vessel != nullptr;
      count += curved && part.fit && part.fit->inlier_count >= kCountedPoints;
    }
  }
  return count;
}

Claims AssessClaims(const perception::PointCloud& cloud, const perception::PinholeCamera& camera,
                    const perception::SceneInterpretation& scene,
                    const std::vector<std::uint32_t>& points_on_objects) {
  const ClaimedGeometry claims = ClaimsOf(scene);
  return {.ok = true,
          .coverage = MeasureCoverage(claims, cloud, scene.labels, kPointStride),
          .free_space = MeasureFreeSpace(claims, cloud, camera, kRayStride),
          .explained = CoverageBySolids(claims, cloud, points_on_objects),
          .curved = CurvedShapes(scene)};
}

Claims AssessReal(const LabelledScan& scan) {
  constexpr std::uint32_t kFirstObjectLabel = 10;
  perception::InterpretOptions options;
  options.max_threads = 1;
  const auto scene = perception::InterpretScene(scan.cloud, options);
  if (!scene.ok()) return {};
  std::vector<std::uint32_t> on_objects;
  for (std::uint32_t i = 0; i < scan.labels.size(); ++i) {
    if (scan.labels[i] >= kFirstObjectLabel) on_objects.push_back(i);
  }
  return AssessClaims(scan.cloud, {}, *scene, on_objects);
}

Claims AssessSimulated(const CaseName& name) {
  const absl::StatusOr<SimulatedCase> run = RunCase(name);
  if (!run.ok()) return {};
  std::vector<std::uint32_t> on_objects;
  for (const TrueShape& truth : TrueShapes(run->view())) {
    on_objects.insert(on_objects.end(), truth.points.begin(), truth.points.end());
  }
  return AssessClaims(run->scan.cloud, run->simulated.camera, run->interpretation, on_objects);
}

std::vector<Claims> AssessAll(std::size_t count, const std::function<Claims(std::size_t)>& assess) {
  std::vector<Claims> all(count);
  perception::ParallelFor(count, 1, {.max_threads = kThreads},
                          [&](std::size_t begin, std::size_t end) {
                            for (std::size_t k = begin; k < end; ++k) all[k] = assess(k);
                          });
  return all;
}

std::string FormatByClaim(const char* how, const std::array<std::int64_t, kClaimCount>& counts) {
  std::string text;
  for (int c = 0; c < kClaimCount; ++c) {
    const std::int64_t count = counts[static_cast<std::size_t>(c)];
    if (count == 0) continue;
    text += std::string(", ") + how + " " + std::string(NameOf(static_cast<Claim>(c))) + " " +
            std::to_string(count);
  }
  return text;
}

// The lost points, by where they lie.
std::string FormatBarePoints(const Coverage& coverage) {
  return FormatByClaim("points deep in", coverage.deep) +
         ", bare points: " + std::to_string(coverage.bare[Coverage::kOfSupport]) +
         " of supports, " + std::to_string(coverage.bare[Coverage::kOfObject]) + " of objects, " +
         std::to_string(coverage.bare[Coverage::kRejected]) + " rejected";
}

void Print(const std::string& name, const Claims& claims, Report& report) {
  char text[200];
  std::snprintf(text, sizeof(text),
                "  %-22s coverage %.5f; %.5f of %lld rays violate free space; on true objects %.4f "
                "explained by shapes",
                name.c_str(), claims.coverage.share(), claims.free_space.share(),
                static_cast<long long>(claims.free_space.rays), claims.explained.share());
  report.Detail(text + FormatByClaim("rays deep in", claims.free_space.deep) +
                FormatByClaim("across", claims.free_space.crossed) +
                FormatBarePoints(claims.coverage));
}

struct Source {
  std::string name;
  Claims sum;
};

// Prints the few cases with the most violating rays, so that they can be inspected.
void PrintWorst(const std::vector<Claims>& all, const std::function<std::string(std::size_t)>& name,
                Report& report) {
  std::vector<std::size_t> order(all.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return all[a].free_space.violating > all[b].free_space.violating;
  });
  for (std::size_t k = 0; k < std::min<std::size_t>(3, order.size()); ++k) {
    if (all[order[k]].free_space.violating == 0) break;
    Print("worst: " + name(order[k]), all[order[k]], report);
  }
}

Source SumUp(const std::string& source, const std::vector<Claims>& all,
             const std::function<std::string(std::size_t)>& name, Report& report) {
  Source result{.name = source, .sum = {}};
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (!all[k].ok) report.Fail(name(k) + " could not be interpreted");
    result.sum.Add(all[k]);
  }
  Print(source, result.sum, report);
  PrintWorst(all, name, report);
  return result;
}

Source AssessLearn(const std::vector<LabelledScan>& scans, Report& report) {
  const std::vector<Claims> all =
      AssessAll(scans.size(), [&](std::size_t k) { return AssessReal(scans[k]); });
  const auto name = [](std::size_t k) { return "learn" + std::to_string(k); };
  int curved = 0;
  for (std::size_t k = 0; k < std::min(kBoxScans, all.size()); ++k) curved += all[k].curved;
  report.Add({.key = "curved_on_boxes",
              .value = static_cast<double>(curved),
              .unit = "shapes",
              .how =
                  "cylinders, spheres, cones and vessels of 300 points or more on mosd/learn 0-24, "
                  "which hold boxes alone"});
  return SumUp("mosd/learn", all, name, report);
}

Source AssessFamily(SceneFamily family, Report& report) {
  const auto named = [&](std::size_t k) { return CaseName{family, k}; };
  const std::vector<Claims> all =
      AssessAll(kSeedsPerFamily, [&](std::size_t k) { return AssessSimulated(named(k)); });
  return SumUp(
      "simulated " + std::string(FamilyName(family)), all,
      [&](std::size_t k) { return NameOf(named(k)); }, report);
}

// Adds the worst of the sources as the figure; its text quotes each of them.
void AddFigure(const char* key, const std::vector<Source>& sources,
               const std::function<double(const Claims&)>& value,
               const std::function<bool(double, double)>& worse, const std::string& what,
               Report& report) {
  double worst = value(sources.front().sum);
  std::string how = what + ", the worst of";
  for (const Source& source : sources) {
    const double here = value(source.sum);
    if (worse(here, worst)) worst = here;
    char text[80];
    std::snprintf(text, sizeof(text), " %s %.5f", source.name.c_str(), here);
    how += text;
  }
  report.Add({.key = key, .value = worst, .unit = "1", .how = how});
}

}  // namespace

void MeasureClaims(Report& report) {
  report.Detail("What is claimed against what was measured, every third point, every 16th ray:");
  std::vector<Source> sources;
  const std::vector<LabelledScan> scans = LoadLabelledScans();
  if (scans.empty()) {
    report.Detail("  mosd/learn skipped: not in CWM_DATA");
  } else {
    sources.push_back(AssessLearn(scans, report));
  }
  for (SceneFamily family : {SceneFamily::kTable, SceneFamily::kClutter, SceneFamily::kKitchen}) {
    sources.push_back(AssessFamily(family, report));
  }
  AddFigure(
      "coverage", sources, [](const Claims& c) { return c.coverage.share(); }, std::less<double>(),
      "share of points within max(10 mm, 3 sigma) of a collision surface and not deeper in a "
      "solid",
      report);
  AddFigure(
      "free_space_violation", sources, [](const Claims& c) { return c.free_space.share(); },
      std::greater<double>(),
      "share of rays that run 10 mm deep in a solid, or cross a surface far from all points, "
      "30 mm / cos(theta) before their hit or earlier",
      report);
  AddFigure(
      "shape_explained", sources, [](const Claims& c) { return c.explained.share(); },
      std::less<double>(), "share of points on true objects that shapes explain, meshes not",
      report);
}

}  // namespace cwm::benchmarks
