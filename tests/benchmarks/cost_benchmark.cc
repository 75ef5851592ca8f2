// The processor time of real depth images of a RealSense, beside the labelled Kinect scans.
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include "perception/interpret_scene.h"
#include "tests/benchmarks/benchmark_scans.h"
#include "tests/benchmarks/benchmarks.h"

namespace cwm::benchmarks {
namespace {

constexpr std::size_t kKinectScans = 12;

// Processor seconds of one interpretation on one thread, per million points; the least of two runs.
double Cost_us(const perception::PointCloud& cloud, const perception::SensorNoise& noise) {
  double least_us = 0;
  for (int run = 0; run < 2; ++run) {
    perception::InterpretOptions options;
    options.noise = noise;
    options.max_threads = 1;
    timespec begin{}, end{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &begin);
    const auto found = perception::InterpretScene(cloud, options);
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &end);
    if (!found.ok()) return 0;
    const double spent_us = 1e6 * static_cast<double>(end.tv_sec - begin.tv_sec) +
                            1e-3 * static_cast<double>(end.tv_nsec - begin.tv_nsec);
    const double us = spent_us / static_cast<double>(found->report.points_finite);
    least_us = run == 0 ? us : std::min(least_us, us);
  }
  return least_us;
}

double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

}  // namespace

void MeasureCost(Report& report) {
  const std::vector<LabelledScan> kinect = LoadLabelledScans();
  const std::vector<NamedCloud> realsense = LoadRealSenseImages();
  if (kinect.empty() || realsense.empty()) {
    report.Detail("  cost skipped: mosd/learn or real/realsense_clutter is not in CWM_DATA");
    return;
  }
  std::vector<double> of_kinect, of_realsense;
  for (std::size_t k = 0; k < kinect.size(); k += kinect.size() / kKinectScans) {
    of_kinect.push_back(Cost_us(kinect[k].cloud, {}));
  }
  for (const NamedCloud& image : realsense) {
    const perception::SensorNoise noise{.model = perception::SensorModel::kRealSense};
    of_realsense.push_back(Cost_us(image.cloud, noise));
    char text[160];
    std::snprintf(text, sizeof(text), "  %s: %.2f us of processor time a point", image.name.c_str(),
                  of_realsense.back());
    report.Detail(text);
  }
  report.Add({.key = "cpu_per_point_ratio",
              .value = Mean(of_realsense) / Mean(of_kinect),
              .unit = "1",
              .how = "processor time a point of " + std::to_string(of_realsense.size()) +
                     " RealSense images of heaps, over that of " +
                     std::to_string(of_kinect.size()) + " labelled Kinect scans, one thread"});
  report.Add({.key = "cpu_per_point_us",
              .value = Mean(of_realsense),
              .unit = "us",
              .how = "of the RealSense images"});
}

}  // namespace cwm::benchmarks
