// Objects told apart in random scenes of each family, under the noise of two sensors: rules tuned
// on some families are measured on all.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "perception/cloud/parallel_for.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/quality/object_confusion.h"
#include "tests/benchmarks/quality/segmentation_score.h"
#include "tests/benchmarks/quality/simulated_case.h"

namespace cwm::benchmarks {
namespace {

constexpr int kFamilyThreads = 2;
struct FamilyTotals {
  SegmentationTotals scores;
  Confusion confusion;
  int objects = 0;
  double ms = 0;
};

struct FamilyScore {
  absl::Status status = absl::UnknownError("not run");
  SegmentationScore score;
  Confusion confusion;
  double ms = 0;
  std::string remarks;
};

// The objects that share their found object with another one, for example "can can box".
std::string MergedNames(const SimulatedCase& run, const Confusion& confusion) {
  std::string names;
  for (const std::uint32_t label : confusion.merged_labels) {
    names += " " + run.simulated.scene.objects[label / 10 - 2].name;
  }
  return names;
}

// The found objects most of whose points do not belong to any counted object, for example ";
// invented: 512 of table".
std::string InventedNames(const SimulatedCase& run, const std::vector<std::uint32_t>& truth,
                          const std::vector<std::uint32_t>& labels) {
  struct Members {
    std::size_t points = 0, counted = 0;
    std::map<std::string, std::size_t> of;
  };
  std::map<std::uint32_t, Members> found;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] < 10 || truth[i] == 0) continue;
    Members& members = found[labels[i] / 10];
    ++members.points;
    members.counted += truth[i] >= 10;
    ++members.of[run.simulated.scene.objects[static_cast<std::size_t>(run.scan.object[i])].name];
  }
  std::string names;
  for (const auto& [label, members] : found) {
    if (2 * members.counted >= members.points) continue;
    const auto most_frequent =
        std::ranges::max_element(members.of, {}, [](const auto& entry) { return entry.second; });
    names += "; invented: " + std::to_string(members.points) + " of " + most_frequent->first;
  }
  return names;
}

FamilyScore ScoreCase(const CaseName& name, const CaseSensor& sensor) {
  auto run = RunCase(name, sensor);
  if (!run.ok())
    return {.status = run.status(), .score = {}, .confusion = {}, .ms = 0, .remarks = {}};
  const std::vector<std::uint32_t> truth = TrueLabelsOf(*run);
  const std::vector<std::uint32_t> found = CountedLabels(truth, run->interpretation.labels);
  const Confusion confusion = ConfusionOf(truth, found);
  double ms = 0;
  for (const perception::StageTime& stage : run->interpretation.report.stages)
    ms += stage.elapsed_ms;
  return {.status = absl::OkStatus(),
          .score = ScoreSegmentation(truth, found, TruthLevel::kObjects),
          .confusion = confusion,
          .ms = ms,
          .remarks = MergedNames(*run, confusion) + InventedNames(*run, truth, found)};
}

FamilyTotals MeasureFamily(perception::SceneFamily family, const Seeds& seeds,
                           const CaseSensor& sensor, std::vector<std::string>& lines,
                           Report& report) {
  std::vector<FamilyScore> scores(static_cast<std::size_t>(seeds.count));
  const auto name_of = [&](std::size_t k) { return CaseName{family, seeds.first + k}; };
  perception::ParallelFor(scores.size(), 1, {.max_threads = kFamilyThreads},
                          [&](std::size_t begin, std::size_t end) {
                            for (std::size_t k = begin; k < end; ++k) {
                              scores[k] = ScoreCase(name_of(k), sensor);
                            }
                          });
  FamilyTotals totals;
  for (std::size_t k = 0; k < scores.size(); ++k) {
    const FamilyScore& one = scores[k];
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
    lines.push_back(text + one.remarks);
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
