// The value of each refinement pass: every scene is interpreted with all passes and with each one
// left out, and the differences are paired scene by scene.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "perception/cloud/parallel_for.h"
#include "perception/interpret_scene.h"
#include "perception/refinement/passes.h"
#include "tests/benchmarks/benchmark_scans.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/quality/claimed_geometry.h"
#include "tests/benchmarks/quality/free_space.h"
#include "tests/benchmarks/quality/handle_matching.h"
#include "tests/benchmarks/quality/object_confusion.h"
#include "tests/benchmarks/quality/segmentation_score.h"
#include "tests/benchmarks/quality/shape_matching.h"
#include "tests/benchmarks/quality/simulated_case.h"

namespace cwm::benchmarks {
namespace {

using perception::SceneFamily;

constexpr int kThreads = 2;
constexpr int kRayStride = 4;

// The figures of one interpretation, in the order of the table's columns.
constexpr std::array<std::string_view, 9> kColumns = {
    "objects", "invented", "merged", "split", "shapes", "spurious", "handles", "free o/oo", "ms"};
using Figures = std::array<double, kColumns.size()>;

Figures FiguresOf(const CaseName& name, const SimulatedCase& run) {
  const std::vector<std::uint32_t> truth = TrueLabelsOf(run);
  const std::vector<std::uint32_t> found = CountedLabels(truth, run.interpretation.labels);
  const SegmentationScore score = ScoreSegmentation(truth, found, TruthLevel::kObjects);
  const Confusion confusion = ConfusionOf(truth, found);
  const SceneShapes shapes = MatchShapes(run.view());
  int found_shapes = 0;
  for (std::size_t k = 0; k < shapes.outcomes.size(); ++k) {
    found_shapes += IsFound(shapes.outcomes[k].outcome);
  }
  HandleTally handles;
  AddHandles(NameOf(name), run.view(), handles);
  const ClaimedGeometry claims = ClaimsOf(run.interpretation);
  const FreeSpace free = MeasureFreeSpace(claims, run.scan.cloud, run.simulated.camera, kRayStride);
  double ms = 0;
  for (const perception::StageTime& stage : run.interpretation.report.stages) {
    ms += stage.elapsed_ms;
  }
  return {static_cast<double>(score.matched_count),
          static_cast<double>(score.found_count - score.matched_count),
          static_cast<double>(confusion.merged),
          static_cast<double>(confusion.split),
          static_cast<double>(found_shapes),
          static_cast<double>(shapes.spurious.size()),
          static_cast<double>(handles.found_count) -
              static_cast<double>(handles.reported_count - handles.right_count),
          1000 * free.share(),
          ms};
}

struct AblatedCase {
  std::string failure;
  Figures all = {};
  std::vector<Figures> without;  // one for each pass
};

AblatedCase Ablate(const CaseName& name, const std::vector<std::string>& passes) {
  AblatedCase result;
  SimulatedCase run = ScanCase(name);
  const auto figures = [&](const std::vector<std::string>& disabled) {
    if (absl::Status status = InterpretCase(name, {}, disabled, run); !status.ok()) {
      result.failure = NameOf(name) + ": " + std::string(status.message());
      return Figures{};
    }
    return FiguresOf(name, run);
  };
  result.all = figures({});
  for (const std::string& pass : passes) result.without.push_back(figures({pass}));
  return result;
}

// Hand-made labels distinguish whole objects only, so the figures of shapes, handles and free space
// are 0.
AblatedCase AblateLabelled(const LabelledScan& scan, const std::vector<std::string>& passes) {
  AblatedCase result;
  const auto figures = [&](const std::vector<std::string>& disabled) {
    perception::InterpretOptions options;
    options.max_threads = 1;
    options.disabled_passes = disabled;
    const auto found = perception::InterpretScene(scan.cloud, options);
    if (!found.ok()) {
      result.failure = "a labelled scan: " + std::string(found.status().message());
      return Figures{};
    }
    const SegmentationScore score =
        ScoreSegmentation(scan.labels, found->labels, TruthLevel::kObjects);
    const Confusion confusion = ConfusionOf(scan.labels, found->labels);
    double ms = 0;
    for (const perception::StageTime& stage : found->report.stages) ms += stage.elapsed_ms;
    return Figures{static_cast<double>(score.matched_count),
                   static_cast<double>(score.found_count - score.matched_count),
                   static_cast<double>(confusion.merged),
                   static_cast<double>(confusion.split),
                   0,
                   0,
                   0,
                   0,
                   ms};
  };
  result.all = figures({});
  for (const std::string& pass : passes) result.without.push_back(figures({pass}));
  return result;
}

// The mean of the paired differences over scenes, and half the width of its 95 % confidence
// interval.
struct Difference {
  double mean = 0, half_width = 0;
};

Difference DifferenceOf(const std::vector<double>& differences) {
  const auto n = static_cast<double>(differences.size());
  double sum = 0, squares = 0;
  for (const double d : differences) sum += d, squares += d * d;
  const double mean = sum / n;
  const double variance = n > 1 ? std::max(0.0, squares - n * mean * mean) / (n - 1) : 0;
  return {mean, 1.96 * std::sqrt(variance / n)};
}

std::string RowOf(const std::string& name, const std::vector<AblatedCase>& cases,
                  std::size_t pass) {
  char text[64];
  std::snprintf(text, sizeof(text), "| %-24s |", name.c_str());
  std::string row = text;
  for (std::size_t column = 0; column < kColumns.size(); ++column) {
    std::vector<double> differences;
    for (const AblatedCase& one : cases) {
      differences.push_back(one.all[column] - one.without[pass][column]);
    }
    const Difference d = DifferenceOf(differences);
    std::snprintf(text, sizeof(text), " %+.3f+-%.3f |", d.mean, d.half_width);
    row += text;
  }
  return row;
}

std::string MeansOf(const std::vector<AblatedCase>& cases) {
  std::string row = "| all passes               |";
  for (std::size_t column = 0; column < kColumns.size(); ++column) {
    double sum = 0;
    for (const AblatedCase& one : cases) sum += one.all[column];
    char text[40];
    std::snprintf(text, sizeof(text), " %.3f |", sum / static_cast<double>(cases.size()));
    row += text;
  }
  return row;
}

void PrintTable(const std::string& which, const std::vector<AblatedCase>& cases,
                const std::vector<std::string>& passes, Report& report) {
  if (cases.empty()) return;
  std::string head = "| pass |";
  for (const std::string_view column : kColumns) head += " " + std::string(column) + " |";
  report.Detail(which + ", " + std::to_string(cases.size()) +
                " scenes; what a scene gains by the pass, with 95 % intervals:");
  report.Detail(head);
  report.Detail(MeansOf(cases));
  for (std::size_t k = 0; k < passes.size(); ++k) report.Detail(RowOf(passes[k], cases, k));
}

bool IsTuned(SceneFamily family) {
  return family == SceneFamily::kTable || family == SceneFamily::kClutter ||
         family == SceneFamily::kKitchen || family == SceneFamily::kVessels;
}

}  // namespace

void MeasureAblationOn(const Seeds& seeds, const std::string& only, Report& report) {
  const std::vector<std::string> passes = perception::PassNames();
  std::vector<CaseName> names;
  for (std::uint64_t seed = seeds.first;
       seed < seeds.first + static_cast<std::uint64_t>(seeds.count); ++seed) {
    for (const SceneFamily family : AllFamilies()) {
      if (only.empty() || only == FamilyName(family)) names.push_back({family, seed});
    }
  }
  const std::vector<LabelledScan> scans =
      only.empty() ? LoadLabelledScans() : std::vector<LabelledScan>();
  std::vector<AblatedCase> ablated(names.size()), labelled(scans.size());
  perception::ParallelFor(names.size() + scans.size(), 1, {.max_threads = kThreads},
                          [&](std::size_t begin, std::size_t end) {
                            for (std::size_t k = begin; k < end; ++k) {
                              if (k < names.size()) {
                                ablated[k] = Ablate(names[k], passes);
                              } else {
                                labelled[k - names.size()] =
                                    AblateLabelled(scans[k - names.size()], passes);
                              }
                            }
                          });
  for (const AblatedCase& one : labelled) {
    if (!one.failure.empty()) report.Fail(one.failure);
  }
  std::vector<AblatedCase> tuned, others;
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (!ablated[k].failure.empty()) {
      report.Fail(ablated[k].failure);
      continue;
    }
    (IsTuned(names[k].family) ? tuned : others).push_back(std::move(ablated[k]));
  }
  PrintTable("table, clutter, kitchen, vessels", tuned, passes, report);
  PrintTable("stacks, heaps, rows, lids, edges, containers", others, passes, report);
  PrintTable("labelled Kinect scans (mosd/learn; objects alone)", labelled, passes, report);
}

void MeasureAblation(Report& report) { MeasureAblationOn(kSeedsOfAblation, "", report); }

}  // namespace cwm::benchmarks
