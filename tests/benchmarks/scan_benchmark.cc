// Real scans through the running server: the time of a scan, the quality of its segmentation, and
// the time that PCL's chain takes for the same outputs.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "clients/cpp/cloud_upload.h"
#include "perception/interpret_scene.h"
#include "tests/benchmarks/benchmark_scans.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/pcl_full.h"
#include "tests/benchmarks/quality/segmentation_score.h"
#include "tests/benchmarks/running_server.h"

namespace cwm::benchmarks {
namespace {

using Clock = std::chrono::steady_clock;

double Milliseconds(Clock::duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

struct ScanTimes {
  std::vector<double> whole_ms;            // of the call, upload included
  std::vector<double> after_last_byte_ms;  // until the reply: the world is published by then
};

struct Ingested {
  double whole_ms = 0;
  double after_last_byte_ms = 0;
  std::vector<std::uint32_t> labels;
};

absl::StatusOr<Ingested> Ingest(const RunningServer& server, const std::string& world,
                                const formats::CloudFile& file) {
  v1::IngestCloudHeader header;
  header.set_world(world);
  header.set_want_point_labels(true);
  const Clock::time_point start = Clock::now();
  Clock::time_point last_byte = start;
  const auto reply = client::IngestCloud(server.connection(), header, file,
                                         [&](auto, auto) { last_byte = Clock::now(); });
  const Clock::time_point end = Clock::now();
  if (!reply.ok()) return reply.status();
  auto labels = client::ReadLabels(server.connection(), *reply, file.size());
  if (!labels.ok()) return labels.status();
  return Ingested{Milliseconds(end - start), Milliseconds(end - last_byte), *std::move(labels)};
}

void AddSegmentation(const SegmentationTotals& objects, const SegmentationTotals& parts,
                     Report& report) {
  report.Detail("Labels of the server's replies to the 45 labelled Kinect scans (mosd/learn):");
  report.Detail("  " + objects.Line("objects"));
  report.Detail("  " + parts.Line("parts"));
  const auto add = [&](const char* key, double value, double of_parts) {
    char how[120];
    std::snprintf(how, sizeof(how), "whole objects, %d scans, default options; parts %.4f",
                  objects.scenes(), of_parts);
    report.Add({.key = key, .value = value, .unit = "1", .how = how});
  };
  add("seg_learn_wov", objects.weighted_overlap(), parts.weighted_overlap());
  add("seg_learn_fus", objects.under_segmentation(), parts.under_segmentation());
  add("seg_learn_fos", objects.over_segmentation(), parts.over_segmentation());
  add("seg_learn_f1", objects.f1(), parts.f1());
}

void AddTimes(const ScanTimes& times, std::size_t scans, const std::string& source,
              Report& report) {
  char text[160];
  std::snprintf(text, sizeof(text),
                "IngestCloud of %zu scans, new worlds: whole call median %.1f ms p95 %.1f ms",
                scans, Median(times.whole_ms), Quantile(times.whole_ms, 0.95));
  report.Detail(text);
  const std::string how =
      "IngestCloud of 640 x 480 into a new world with point labels, from the last byte sent to the "
      "reply; " +
      source;
  report.Add(
      {.key = "scan_ms", .value = Median(times.after_last_byte_ms), .unit = "ms", .how = how});
  report.Add({.key = "scan_p95_ms",
              .value = Quantile(times.after_last_byte_ms, 0.95),
              .unit = "ms",
              .how = how});
}

std::size_t TrianglesOf(const HybridModel& model) {
  std::size_t count = 0;
  for (const SurfacePart& part : model.surfaces) count += part.surface.mesh->triangles.size();
  for (const Handle& handle : model.handles) count += handle.surface.mesh->triangles.size();
  return count;
}

// The number of triangles of the surfaces that no shape explains; meshes of shapes are made on
// demand.
double TrianglesOf(const perception::SceneInterpretation& scene) {
  std::size_t count = 0;
  for (const auto& support : scene.supports) count += TrianglesOf(*support.model);
  for (const auto& object : scene.objects) count += TrianglesOf(*object.model);
  return static_cast<double>(count);
}

// Takes each of a few scans in turn with the baseline; our time is the median of three.
void MeasureBesidePcl(const RunningServer& server, const std::vector<formats::CloudFile>& files,
                      const std::vector<perception::PointCloud>& clouds, Report& report) {
  constexpr std::size_t kBaselineScans = 5;  // four seconds each
  const std::size_t stride = std::max<std::size_t>(1, files.size() / kBaselineScans);
  std::vector<double> ours_ms, baseline_ms, models_ms, ratios, one_model_ms, one_model_ratios;
  int models = 0, clusters = 0;
  for (std::size_t i = 0; i < files.size() && ratios.size() < kBaselineScans; i += stride) {
    const PclFullTimes baseline = RunPclFull(clouds[i]);
    std::vector<double> rounds_ms;
    for (int round = 0; round < 3; ++round) {
      const auto ingested =
          Ingest(server, "beside_pcl_" + std::to_string(i) + "_" + std::to_string(round), files[i]);
      if (!ingested.ok()) return report.Fail(std::string(ingested.status().message()));
      rounds_ms.push_back(ingested->after_last_byte_ms);
    }
    ours_ms.push_back(Median(rounds_ms));
    baseline_ms.push_back(baseline.total_ms());
    models_ms.push_back(baseline.models_ms);
    ratios.push_back(baseline.total_ms() / ours_ms.back());
    one_model_ms.push_back(baseline.with_one_model_ms());
    one_model_ratios.push_back(baseline.with_one_model_ms() / ours_ms.back());
    models += baseline.models;
    clusters += baseline.clusters;
  }
  char text[200];
  std::snprintf(
      text, sizeof(text),
      "PCL's chain with shapes and meshes: median %.0f ms a scan, %.0f ms of it models (%d in "
      "%d clusters)",
      Median(baseline_ms), Median(models_ms), models, clusters);
  report.Detail(text);
  std::snprintf(text, sizeof(text),
                "  with one model a cluster, which is less than our outputs: %.0f ms, ratio %.1f",
                Median(one_model_ms), Median(one_model_ratios));
  report.Detail(text);
  report.Add(AsRatio(
      {.key = "pcl_full_ratio",
       .value = Median(ours_ms),
       .unit = "ms",
       .baseline = "PCL, all models",
       .baseline_value = Median(baseline_ms),
       .ratio = Median(ratios),
       .how = "PCL in process (voxels, normals, plane, prism, clusters, models until none is "
              "left, MLS, GP3), one thread, over ours through the server, scan by scan on " +
              std::to_string(ratios.size()) + " scans"}));
}

void MeasureLabelled(const RunningServer& server, const std::vector<LabelledScan>& scans,
                     Report& report) {
  constexpr int kRounds = 2;
  ScanTimes times;
  SegmentationTotals objects, parts;
  std::vector<double> triangles;
  int disagreements = 0;
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t i = 0; i < scans.size(); ++i) {
      const std::string world = "scan_" + std::to_string(round) + "_" + std::to_string(i);
      const auto ingested = Ingest(server, world, scans[i].file);
      if (!ingested.ok()) return report.Fail(std::string(ingested.status().message()));
      times.whole_ms.push_back(ingested->whole_ms);
      times.after_last_byte_ms.push_back(ingested->after_last_byte_ms);
      if (round > 0) continue;
      objects.Add(ScoreSegmentation(scans[i].labels, ingested->labels, TruthLevel::kObjects));
      parts.Add(ScoreSegmentation(scans[i].labels, ingested->labels, TruthLevel::kParts));
      // The quality figures come from the library in this process, the times from the server: their
      // labels must agree point by point.
      const auto scene = perception::InterpretScene(scans[i].cloud, {});
      if (!scene.ok()) return report.Fail(std::string(scene.status().message()));
      disagreements += scene->labels != ingested->labels;
      triangles.push_back(TrianglesOf(*scene));
    }
  }
  AddTimes(times, scans.size(), "the 45 labelled Kinect scans", report);
  AddSegmentation(objects, parts, report);
  char how[120];
  std::snprintf(how, sizeof(how), "median over the scans, of all surfaces of a scan; p95 %.0f",
                Quantile(triangles, 0.95));
  report.Add({.key = "scan_triangles", .value = Median(triangles), .unit = "1", .how = how});
  if (disagreements > 0) {
    report.Fail("the server labels " + std::to_string(disagreements) +
                " scans otherwise than the library in this process");
  }
}

void MeasureUnlabelled(const RunningServer& server, const BenchmarkScans& scans, Report& report) {
  report.Detail("seg_learn_wov, _fus, _fos, _f1 skipped: mosd/learn is not in CWM_DATA");
  ScanTimes times;
  for (std::size_t i = 0; i < scans.files.size(); ++i) {
    const auto ingested = Ingest(server, "scan_" + std::to_string(i), scans.files[i]);
    if (!ingested.ok()) return report.Fail(std::string(ingested.status().message()));
    times.whole_ms.push_back(ingested->whole_ms);
    times.after_last_byte_ms.push_back(ingested->after_last_byte_ms);
  }
  AddTimes(times, scans.files.size(), scans.source, report);
}

}  // namespace

void MeasureScans(Report& report) {
  const RunningServer server;
  if (!server.up()) return report.Fail("the server did not come up: no figures of scans");
  const BenchmarkScans scans = LoadBenchmarkScans();
  const std::vector<LabelledScan> labelled = LoadLabelledScans();
  if (labelled.empty()) {
    MeasureUnlabelled(server, scans, report);
  } else {
    MeasureLabelled(server, labelled, report);
  }
  MeasureBesidePcl(server, scans.files, scans.clouds, report);
}

}  // namespace cwm::benchmarks
