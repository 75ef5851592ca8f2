// The labelled Kinect scans, interpreted in this process: the scans in which objects are lost or
// invented.
#include <cstdio>
#include <string>
#include <vector>

#include "perception/cloud/parallel_for.h"
#include "perception/interpret_scene.h"
#include "tests/benchmarks/benchmark_scans.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/quality/segmentation_score.h"

namespace cwm::benchmarks {
namespace {

constexpr int kScanThreads = 2;

}  // namespace

void MeasureLabelledScans(Report& report) {
  const std::vector<LabelledScan> scans = LoadLabelledScans();
  if (scans.empty()) return report.Fail("mosd/learn is not in CWM_DATA");
  std::vector<SegmentationScore> scores(scans.size());
  std::vector<std::string> failures(scans.size());
  perception::ParallelFor(
      scans.size(), 1, {.max_threads = kScanThreads}, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          perception::InterpretOptions options;
          options.max_threads = 1;
          const auto found = perception::InterpretScene(scans[k].cloud, options);
          if (!found.ok()) {
            failures[k] = std::string(found.status().message());
            continue;
          }
          scores[k] = ScoreSegmentation(scans[k].labels, found->labels, TruthLevel::kObjects);
        }
      });
  SegmentationTotals totals;
  for (std::size_t k = 0; k < scans.size(); ++k) {
    const SegmentationScore& score = scores[k];
    if (!failures[k].empty()) {
      report.Fail("learn" + std::to_string(k) + ": " + failures[k]);
      continue;
    }
    totals.Add(score);
    if (score.matched_count == score.true_count && score.found_count == score.true_count) continue;
    char text[100];
    std::snprintf(text, sizeof(text), "  learn%zu: %d objects, %d found, %d match", k,
                  score.true_count, score.found_count, score.matched_count);
    report.Detail(text);
  }
  report.Detail("  " + totals.Line("objects"));
  report.Add({.key = "labelled_f1",
              .value = totals.f1(),
              .unit = "1",
              .how = "whole objects of " + std::to_string(scans.size()) +
                     " labelled Kinect scans (mosd/learn), in process"});
}

}  // namespace cwm::benchmarks
