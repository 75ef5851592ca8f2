// Shapes found and invented, and their accuracy, over random scenes of the virtual scanner.
#include <algorithm>
#include <cstdio>
#include <initializer_list>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "perception/cloud/parallel_for.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/quality/handle_matching.h"
#include "tests/benchmarks/quality/shape_tally.h"
#include "tests/benchmarks/quality/simulated_case.h"

namespace cwm::benchmarks {
namespace {

using perception::SceneFamily;

constexpr int kThreads = 2;  // of the machine that the figures are for; a scene runs on one
constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kMillimetres = 1000;

std::vector<CaseName> Cases(const Seeds& seeds, std::initializer_list<SceneFamily> families) {
  std::vector<CaseName> cases;
  const std::uint64_t end = seeds.first + static_cast<std::uint64_t>(seeds.count);
  for (std::uint64_t seed = seeds.first; seed < end; ++seed) {
    for (SceneFamily family : families) cases.push_back({family, seed});
  }
  return cases;
}

struct EvaluatedCase {
  CaseName name;
  absl::StatusOr<SimulatedCase> run = absl::UnknownError("not run");
  SceneShapes shapes;
};

// Works in blocks, so that few clouds are in memory at a time; sums are made in the order of the
// cases.
template <class Function>
void ForEachCase(const std::vector<CaseName>& cases, const Function& evaluate,
                 const CaseSensor& sensor = {}) {
  constexpr std::size_t kBlock = 16;
  for (std::size_t begin = 0; begin < cases.size(); begin += kBlock) {
    std::vector<EvaluatedCase> block(std::min(kBlock, cases.size() - begin));
    perception::ParallelFor(block.size(), 1, {.max_threads = kThreads},
                            [&](std::size_t from, std::size_t to) {
                              for (std::size_t k = from; k < to; ++k) {
                                block[k].name = cases[begin + k];
                                block[k].run = RunCase(block[k].name, sensor);
                                if (!block[k].run.ok()) continue;
                                block[k].shapes = MatchShapes(block[k].run->view());
                              }
                            });
    for (const EvaluatedCase& evaluated : block) evaluate(evaluated);
  }
}

struct Quantiles {
  double median = 0;
  double p95 = 0;
};

Quantiles QuantilesOf(const std::vector<double>& samples, double unit) {
  return {.median = unit * Median(samples), .p95 = unit * Quantile(samples, 0.95)};
}

void PrintErrors(const char* which, const ErrorSamples& samples, Report& report) {
  const auto line = [&](const char* name, const std::vector<double>& values, double unit,
                        const char* unit_name) {
    if (values.empty()) return;
    const Quantiles q = QuantilesOf(values, unit);
    char text[160];
    std::snprintf(text, sizeof(text), "  %-10s %-16s n %5zu  median %8.3f  p95 %8.3f %s", which,
                  name, values.size(), q.median, q.p95, unit_name);
    report.Detail(text);
  };
  line("radius", samples.radius_m, kMillimetres, "mm");
  line("axis", samples.axis_rad, kDegrees, "deg");
  line("cone half angle", samples.half_angle_rad, kDegrees, "deg");
  line("length", samples.length_m, kMillimetres, "mm");
  line("box edge", samples.box_edge_m, kMillimetres, "mm");
  line("box axes", samples.box_axis_rad, kDegrees, "deg");
  line("centre", samples.centre_m, kMillimetres, "mm");
}

void PrintTally(const ShapeTally& tally, Report& report) {
  report.Detail("True shapes with 300 measured points or more, by what became of them:");
  for (const std::string& line : tally.Lines()) report.Detail(line);
  report.Detail("Errors; what was not found counts as infinite:");
  PrintErrors("all", tally.errors(), report);
  PrintErrors("z > 1 m", tally.far_errors(), report);
  PrintErrors("r < 25 mm", tally.thin_errors(), report);
}

void PrintCalibration(const ParameterCalibration& calibration, Report& report) {
  report.Detail("Errors within one reported standard deviation:");
  for (const auto& [name, parameter] : calibration.parameters()) {
    char text[120];
    std::snprintf(text, sizeof(text), "  %-24s %5.1f %% of %d", name.c_str(),
                  100 * parameter.share(), parameter.count);
    report.Detail(text);
  }
}

std::string DescribeRun(const ShapeTally& tally, std::size_t scenes) {
  return std::to_string(tally.true_count()) + " true shapes with 300 points or more in " +
         std::to_string(scenes) +
         " random scenes, half tables and half clutter, Kinect noise; pose given for even seeds, "
         "up estimated for odd ones";
}

void AddFigures(const ShapeTally& tally, std::size_t scenes, Report& report) {
  const std::string how = DescribeRun(tally, scenes);
  const auto add = [&](const char* key, double value, const char* unit, const std::string& text) {
    report.Add({.key = key, .value = value, .unit = unit, .how = text});
  };
  char equivalent[80];
  std::snprintf(equivalent, sizeof(equivalent), "; %.4f of them as another type, same surface",
                tally.equivalent_share());
  add("shape_found", tally.found_share(), "1", how + equivalent);
  add("shape_spurious", tally.spurious_share(), "1",
      "shapes of 100 points or more that match no true one, per true shape; " + how);
  const ErrorSamples& errors = tally.errors();
  const Quantiles radius = QuantilesOf(errors.radius_m, kMillimetres);
  const Quantiles axis = QuantilesOf(errors.axis_rad, kDegrees);
  std::vector<double> edges_m = errors.box_edge_m;
  edges_m.insert(edges_m.end(), errors.length_m.begin(), errors.length_m.end());
  const Quantiles edge = QuantilesOf(edges_m, kMillimetres);
  add("radius_median_mm", radius.median, "mm",
      "spheres, cylinders, cones at the height of the middle of what was seen");
  add("radius_p95_mm", radius.p95, "mm", "as radius_median_mm");
  add("axis_median_deg", axis.median, "deg", "cylinders and cones");
  add("axis_p95_deg", axis.p95, "deg", "as axis_median_deg");
  add("box_edge_median_mm", edge.median, "mm",
      "edges of boxes, lengths of cylinders and cones, where both ends were seen");
  add("box_edge_p95_mm", edge.p95, "mm", "as box_edge_median_mm");
  add("cone_half_angle_median_deg", QuantilesOf(errors.half_angle_rad, kDegrees).median, "deg",
      "true cones");
  add("centre_median_mm", QuantilesOf(errors.centre_m, kMillimetres).median, "mm",
      "without the directions in which the ends were not both seen");
  add("sigma_calibration", tally.calibration().all().share(), "1",
      "share of parameter errors within one reported standard deviation; 0.68 is true");
}

void AttachFailures(const ShapeTally& tally, Report& report) {
  const auto attach = [&report](const char* file, const char* what,
                                const std::vector<Failure>& failures) {
    std::vector<std::string> lines;
    for (const Failure& failure : failures) lines.push_back(failure.scene + ": " + failure.what);
    report.Detail(std::to_string(lines.size()) + what + ", listed in " + file +
                  " beside the figures; one of them again: ./dev bench scene FAMILY SEED");
    report.Attach(file, std::move(lines));
  };
  attach("shape_failures.txt", " failures", tally.failures());
  attach("shape_errors.txt", " shapes found with a large error", tally.large_errors());
}

void PrintShares(const std::string& of, const ShapeTally& tally, Report& report) {
  char text[120];
  std::snprintf(text, sizeof(text), "  %-22s found %.4f of %d, spurious %.4f per true shape",
                of.c_str(), tally.found_share(), tally.true_count(), tally.spurious_share());
  report.Detail(text);
}

}  // namespace

void MeasureShapesOn(const Seeds& seeds, Report& report) {
  ShapeTally tally;
  std::map<std::string, ShapeTally> parts;  // by family, and by whether the pose was given
  const std::vector<CaseName> cases = Cases(seeds, {SceneFamily::kTable, SceneFamily::kClutter});
  ForEachCase(cases, [&](const EvaluatedCase& evaluated) {
    if (!evaluated.run.ok()) {
      return report.Fail(NameOf(evaluated.name) + ": " +
                         std::string(evaluated.run.status().message()));
    }
    const std::string name = NameOf(evaluated.name);
    tally.Add(name, evaluated.run->view(), evaluated.shapes);
    for (const std::string& part :
         {std::string(FamilyName(evaluated.name.family)),
          std::string(evaluated.name.seed % 2 == 0 ? "pose given" : "up estimated")}) {
      parts[part].Add(name, evaluated.run->view(), evaluated.shapes);
    }
  });
  PrintTally(tally, report);
  for (const auto& [name, part] : parts) PrintShares(name, part, report);
  PrintCalibration(tally.calibration(), report);
  AddFigures(tally, cases.size(), report);
  AttachFailures(tally, report);
}

namespace {

std::string Describe(const Shape& shape, const Pose& X_WS) {
  char text[200];
  const Vector3 size_m = TightBounds(shape, Pose::Identity()).sizes();
  const Vector3 at = X_WS.translation(), axis = X_WS.linear().col(2);
  std::snprintf(text, sizeof(text),
                "%-8s %5.1f x %5.1f x %5.1f mm at (%7.4f %7.4f %7.4f) z (%6.3f %6.3f %6.3f)",
                std::string(NameOf(KindOf(shape))).c_str(), size_m.x() * kMillimetres,
                size_m.y() * kMillimetres, size_m.z() * kMillimetres, at.x(), at.y(), at.z(),
                axis.x(), axis.y(), axis.z());
  return text;
}

// The support of a found shape's object, as text.
std::string SupportText(const perception::DetectedObject& object) {
  if (object.rests_on >= 0) return " on object " + std::to_string(object.rests_on);
  return object.supported_by >= 0 ? " on a support" : " on nothing";
}

void PrintScene(const SceneShapes& shapes, const perception::SceneInterpretation& interpretation,
                Report& report) {
  for (std::size_t t = 0; t < shapes.truth.size(); ++t) {
    const TrueShape& truth = shapes.truth[t];
    const ShapeOutcome& outcome = shapes.outcomes[t];
    char text[160];
    std::snprintf(text, sizeof(text),
                  "  %6zu points, %-10s IoU %.2f (object %.2f), best %d, %.2f sigma",
                  truth.points.size(), std::string(NameOf(outcome.outcome)).c_str(), outcome.iou,
                  outcome.object_iou, outcome.best, outcome.surface_sigma);
    report.Detail("true  " + std::to_string(t) + " " + Describe(truth.shape, truth.X_WS) + text);
  }
  for (std::size_t f = 0; f < shapes.found.size(); ++f) {
    const FoundShape& found = shapes.found[f];
    report.Detail("found " + std::to_string(f) + " " + Describe(found.part.shape, found.X_WS) +
                  "  " + std::to_string(found.points.size()) + " points, object " +
                  std::to_string(found.object) +
                  SupportText(interpretation.objects[static_cast<std::size_t>(found.object)]) +
                  (found.part.role == PartRole::kCompleted ? ", completed" : ""));
  }
}

}  // namespace

void MeasureHandlesOn(const Seeds& seeds, Report& report) {
  const std::vector<CaseName> cases = Cases(seeds, {SceneFamily::kVessels});
  HandleTally tally;
  ForEachCase(cases, [&](const EvaluatedCase& evaluated) {
    if (!evaluated.run.ok()) {
      return report.Fail(NameOf(evaluated.name) + ": " +
                         std::string(evaluated.run.status().message()));
    }
    AddHandles(NameOf(evaluated.name), evaluated.run->view(), tally);
  });
  const std::string how =
      std::to_string(tally.true_count) + " true handles with 60 points or more, " +
      std::to_string(tally.reported_count) + " reported, in " + std::to_string(cases.size()) +
      " random scenes of mugs, pans and jugs; a match shares half of the points";
  report.Add({.key = "handle_recall", .value = tally.recall(), .unit = "1", .how = how});
  report.Add({.key = "handle_precision", .value = tally.precision(), .unit = "1", .how = how});
  report.Attach("handle_failures.txt", std::move(tally.failures));
}

void MeasureHandles(Report& report) { MeasureHandlesOn(kSeedsOfHandles, report); }

void MeasureShapes(Report& report) {
  MeasureShapesOn(kSeedsOfShapes, report);
  MeasureOtherSensorsOn(kSeedsOfSensors, "", report);
}

namespace {

struct OtherSensor {
  CaseSensor sensor;
  const char *key, *name;
};

// RealSense and time of flight: 4 and 8 mm at 0.8 m, two and a half times and five times a Kinect's
// noise.
const std::vector<OtherSensor>& OtherSensors() {
  using perception::SensorModel;
  static const std::vector<OtherSensor> sensors = {
      {{{.model = SensorModel::kRealSense}}, "realsense", "RealSense: a tenth pixel of disparity"},
      {{{.model = SensorModel::kTimeOfFlight}},
       "tof",
       "time of flight: 1 % of the depth, multipath"},
      {{{.model = SensorModel::kTiltingLaser}},
       "laser",
       "a tilting laser: 18 mm, lines that jitter"},
      {{{.model = SensorModel::kGiven, .given_sigma_m = 1e-4}}, "fine", "sigma given: 0.1 mm"},
      {{{.model = SensorModel::kGiven, .given_sigma_m = 1e-3}}, "given", "sigma given: 1 mm"},
      {{.form = CloudForm::kShuffled}, "shuffled", "Kinect, points in any order"},
      {{.form = CloudForm::kThreeViews}, "merged", "Kinect, three places, registered"},
      {{.form = CloudForm::kBodyImage}, "body", "Kinect, image in a frame with x forward, z up"},
  };
  return sensors;
}

std::string KeysOfSensors() {
  std::string keys;
  for (const OtherSensor& sensor : OtherSensors()) {
    keys += keys.empty() ? "" : ", ";
    keys += sensor.key;
  }
  return keys;
}

void MeasureSensor(const OtherSensor& other, const Seeds& seeds, Report& report) {
  const std::vector<CaseName> cases = Cases(seeds, {SceneFamily::kTable, SceneFamily::kClutter});
  ShapeTally tally;
  ForEachCase(
      cases,
      [&](const EvaluatedCase& evaluated) {
        if (!evaluated.run.ok()) {
          return report.Fail(NameOf(evaluated.name) + ": " +
                             std::string(evaluated.run.status().message()));
        }
        tally.Add(NameOf(evaluated.name), evaluated.run->view(), evaluated.shapes);
      },
      other.sensor);
  report.Detail(std::string("Seen by ") + other.name + ":");
  for (const std::string& line : tally.Lines()) report.Detail(line);
  PrintErrors("all", tally.errors(), report);
  PrintCalibration(tally.calibration(), report);
  const std::string how = std::to_string(tally.true_count()) +
                          " true shapes with 300 points or more in " +
                          std::to_string(cases.size()) + " of the random scenes, " + other.name;
  const std::string key = other.key;
  const auto add = [&](const char* what, double value) {
    report.Add({.key = key + what, .value = value, .unit = "1", .how = how});
  };
  add("_shape_found", tally.found_share());
  add("_shape_spurious", tally.spurious_share());
  add("_sigma_calibration", tally.calibration().all().share());
}

}  // namespace

void MeasureOtherSensorsOn(const Seeds& seeds, const std::string& only, Report& report) {
  bool is_known = only.empty();
  for (const OtherSensor& sensor : OtherSensors()) {
    if (!only.empty() && only != sensor.key) continue;
    is_known = true;
    MeasureSensor(sensor, seeds, report);
  }
  if (!is_known) report.Fail("sensor is '" + only + "', must be one of " + KeysOfSensors());
}

void MeasureShapesQuickly(Report& report) { MeasureShapesOn(kSeedsOfShapesQuickly, report); }

void ReplayScene(const std::string& family, std::uint64_t seed, const std::string& sensor,
                 Report& report) {
  const auto known = FamilyNamed(family);
  if (!known) return report.Fail("family is '" + family + "', must be one of " + FamilyNames());
  const std::vector<OtherSensor>& others = OtherSensors();
  const auto other = std::find_if(others.begin(), others.end(),
                                  [&](const OtherSensor& o) { return o.key == sensor; });
  if (!sensor.empty() && other == others.end())
    return report.Fail("sensor is '" + sensor + "', must be one of " + KeysOfSensors());
  const absl::StatusOr<SimulatedCase> run =
      RunCase({*known, seed}, other == others.end() ? CaseSensor() : other->sensor);
  if (!run.ok()) return report.Fail(std::string(run.status().message()));
  const SceneShapes shapes = MatchShapes(run->view());
  PrintScene(shapes, run->interpretation, report);
  ShapeTally tally;
  tally.Add(NameOf(CaseName{*known, seed}), run->view(), shapes);
  PrintTally(tally, report);
  for (const Failure& failure : tally.failures()) report.Detail(failure.what);
}

}  // namespace cwm::benchmarks
