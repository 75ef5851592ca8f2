#include <chrono>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "perception/interpret_scene.h"
#include "tests/benchmarks/benchmark_scans.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/pcl_plain.h"

namespace cwm::benchmarks {
namespace {

double Elapsed_ms(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

std::string Line(const std::string& name, const std::vector<double>& values_ms) {
  char text[96];
  std::snprintf(text, sizeof(text), "  %-24s %8.1f ms", name.c_str(), Median(values_ms));
  return text;
}

}  // namespace

void MeasureInterpreter(Report& report) {
  const BenchmarkScans scans = LoadBenchmarkScans();
  constexpr int kRounds = 3;  // in turn with the baseline, so that both run under the same load
  std::map<std::string, std::vector<double>> stages;
  std::vector<std::string> stage_order;
  std::vector<double> ours_ms, ratios;
  std::vector<PclPlainTimes> baselines;
  for (int round = 0; round < kRounds; ++round) {
    for (const perception::PointCloud& cloud : scans.clouds) {
      const auto start = std::chrono::steady_clock::now();
      const auto scene = perception::InterpretScene(cloud, {});
      const double elapsed_ms = Elapsed_ms(start);
      if (!scene.ok()) {
        report.Fail("a scan failed: " + std::string(scene.status().message()));
        continue;
      }
      for (const perception::StageTime& stage : scene->report.stages) {
        if (!stages.count(stage.stage)) stage_order.push_back(stage.stage);
        stages[stage.stage].push_back(stage.elapsed_ms);
      }
      ours_ms.push_back(elapsed_ms);
      baselines.push_back(RunPclPlain(cloud));
      ratios.push_back(baselines.back().total_ms() / elapsed_ms);
    }
  }
  report.Detail(
      "Interpreter, two threads, supports + objects + shapes + surfaces, median per stage; " +
      scans.source + ":");
  for (const std::string& stage : stage_order) report.Detail(Line(stage, stages[stage]));
  report.Detail(Line("total", ours_ms));
  report.Detail("PCL's plain pipeline, one thread, supports + clusters alone, same scans in turn:");
  const auto baseline = [&](const char* name, auto PclPlainTimes::*member) {
    std::vector<double> values;
    for (const PclPlainTimes& times : baselines) values.push_back(times.*member);
    report.Detail(Line(name, values));
  };
  baseline("voxel grid", &PclPlainTimes::voxel_grid_ms);
  baseline("kNN normals", &PclPlainTimes::normals_ms);
  baseline("SAC plane", &PclPlainTimes::plane_ms);
  baseline("prism", &PclPlainTimes::prism_ms);
  baseline("Euclidean clusters", &PclPlainTimes::clusters_ms);
  std::vector<double> totals;
  for (const PclPlainTimes& times : baselines) totals.push_back(times.total_ms());
  report.Detail(Line("total", totals));
  report.Add(
      AsRatio({.key = "pcl_plain_ratio",
               .value = Median(ours_ms),
               .unit = "ms",
               .baseline = "PCL plain pipeline",
               .baseline_value = Median(totals),
               .ratio = Median(ratios),
               .how = "in process, 640 x 480, median of PCL's time over ours, scan by scan; ours "
                      "makes shapes and "
                      "meshes too, PCL's does not"}));
}

}  // namespace cwm::benchmarks
