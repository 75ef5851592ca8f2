// Objects told apart in random scenes of each family, under the noise of two sensors: what was tuned
// on some families is measured on all.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "perception/cloud/parallel_for.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/quality/segmentation_score.h"
#include "tests/benchmarks/quality/simulated_case.h"

namespace cwm::benchmarks {
namespace {

constexpr int kFamilyThreads = 2;
// True objects with fewer points are seen too little for people to agree on their outline.
constexpr std::size_t kFewestPoints = 300;

// 0 for what counts nowhere, 1 for supports, 10 k for the k-th object.
std::vector<std::uint32_t> TrueLabelsOf(const SimulatedCase& run) {
  const auto& objects = run.simulated.scene.objects;
  std::vector<std::size_t> points(objects.size(), 0);
  for (const std::int32_t object : run.scan.object) {
    if (object >= 0) ++points[static_cast<std::size_t>(object)];
  }
  std::vector<std::uint32_t> label_of(objects.size(), 0);
  for (std::size_t k = 0; k < objects.size(); ++k) {
    if (objects[k].is_support) {
      label_of[k] = 1;
    } else if (!IsFurniture(objects[k]) && points[k] >= kFewestPoints) {
      label_of[k] = static_cast<std::uint32_t>(10 * (k + 2));
    }
  }
  std::vector<std::uint32_t> labels(run.scan.object.size(), 0);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const std::int32_t object = run.scan.object[i];
    if (object >= 0) labels[i] = label_of[static_cast<std::size_t>(object)];
  }
  return labels;
}

// How true objects were taken together or apart.
struct Confusion {
  int merged = 0;  // true objects that share their found object with another one
  int split = 0;   // true objects of which two found ones hold a fifth each
};

Confusion ConfusionOf(const std::vector<std::uint32_t>& truth,
                      const std::vector<std::uint32_t>& found) {
  constexpr double kHeld = 0.5, kPiece = 0.2;  // of a true object's points
  std::map<std::uint32_t, std::map<std::uint32_t, std::size_t>> shared;  // by true, by found
  std::map<std::uint32_t, std::size_t> points;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth[i] < 10) continue;
    ++points[truth[i]];
    if (found[i] >= 10) ++shared[truth[i]][found[i] / 10];
  }
  Confusion confusion;
  std::map<std::uint32_t, int> holds;  // by found object: how many true ones it holds
  std::map<std::uint32_t, std::uint32_t> holder;
  for (const auto& [object, by_found] : shared) {
    int pieces = 0;
    for (const auto& [other, count] : by_found) {
      const double share = static_cast<double>(count) / static_cast<double>(points[object]);
      pieces += share >= kPiece;
      if (share >= kHeld) ++holds[other], holder[object] = other;
    }
    confusion.split += pieces > 1;
  }
  for (const auto& [object, other] : holder) confusion.merged += holds[other] > 1;
  return confusion;
}

struct FamilyTotals {
  SegmentationTotals scores;
  Confusion confusion;
  int objects = 0;
  double ms = 0;
};

struct Judged {
  absl::Status status = absl::UnknownError("not run");
  SegmentationScore score;
  Confusion confusion;
  double ms = 0;
};

Judged Judge(const CaseName& name, const CaseSensor& sensor) {
  auto run = RunCase(name, sensor);
  if (!run.ok()) return {.status = run.status(), .score = {}, .confusion = {}, .ms = 0};
  const std::vector<std::uint32_t> truth = TrueLabelsOf(*run);
  double ms = 0;
  for (const perception::StageTime& stage : run->interpretation.report.stages)
    ms += stage.elapsed_ms;
  return {.status = absl::OkStatus(),
          .score = ScoreSegmentation(truth, run->interpretation.labels, TruthLevel::kObjects),
          .confusion = ConfusionOf(truth, run->interpretation.labels),
          .ms = ms};
}

FamilyTotals MeasureFamily(perception::SceneFamily family, const Seeds& seeds,
                           const CaseSensor& sensor, std::vector<std::string>& lines,
                           Report& report) {
  std::vector<Judged> judged(static_cast<std::size_t>(seeds.count));
  const auto name_of = [&](std::size_t k) { return CaseName{family, seeds.first + k}; };
  perception::ParallelFor(judged.size(), 1, {.max_threads = kFamilyThreads},
                          [&](std::size_t begin, std::size_t end) {
                            for (std::size_t k = begin; k < end; ++k) {
                              judged[k] = Judge(name_of(k), sensor);
                            }
                          });
  FamilyTotals totals;
  for (std::size_t k = 0; k < judged.size(); ++k) {
    const Judged& one = judged[k];
    if (!one.status.ok()) {
      report.Fail(NameOf(name_of(k)) + ": " + std::string(one.status.message()));
      continue;
    }
    totals.scores.Add(one.score);
    totals.confusion.merged += one.confusion.merged;
    totals.confusion.split += one.confusion.split;
    totals.objects += one.score.true_count;
    totals.ms += one.ms;
    char text[160];
    std::snprintf(text, sizeof(text), "%s: true %d found %d matched %d merged %d split %d",
                  NameOf(name_of(k)).c_str(), one.score.true_count, one.score.found_count,
                  one.score.matched_count, one.confusion.merged, one.confusion.split);
    lines.emplace_back(text);
  }
  return totals;
}

}  // namespace

void MeasureFamiliesOn(const Seeds& seeds, const std::string& only, Report& report) {
  const std::vector<std::pair<std::string, CaseSensor>> sensors = {
      {"kinect", {}},
      {"realsense",
       {.noise = {.model = perception::SensorModel::kRealSense}, .matches_windows = true}}};
  std::vector<std::string> lines;
  for (const auto& [sensor_name, sensor] : sensors) {
    for (const perception::SceneFamily family : AllFamilies()) {
      const std::string name(FamilyName(family));
      if (!only.empty() && only != name) continue;
      const FamilyTotals totals = MeasureFamily(family, seeds, sensor, lines, report);
      if (totals.scores.scenes() == 0) continue;
      const double objects = std::max(1, totals.objects);
      char text[120];
      std::snprintf(text, sizeof(text), " merged %.3f split %.3f, %.0f ms a scene",
                    totals.confusion.merged / objects, totals.confusion.split / objects,
                    totals.ms / totals.scores.scenes());
      report.Detail("  " + totals.scores.Line(sensor_name + " " + name) + text);
      report.Add({.key = "objects_f1_" + sensor_name + "_" + name,
                  .value = totals.scores.f1(),
                  .unit = "1",
                  .how = std::to_string(totals.objects) +
                         " objects of 300 points or more, labels of points"});
    }
  }
  report.Attach("family_scenes.txt", std::move(lines));
}

void MeasureFamilies(Report& report) { MeasureFamiliesOn(kSeedsOfFamilies, "", report); }

}  // namespace cwm::benchmarks
