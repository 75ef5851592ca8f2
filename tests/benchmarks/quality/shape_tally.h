// Sums over many scenes.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tests/benchmarks/quality/parameter_calibration.h"
#include "tests/benchmarks/quality/shape_matching.h"

namespace cwm::benchmarks {

// The errors of all counted true shapes; those of shapes not found are infinite.
struct ErrorSamples {
  std::vector<double> radius_m, axis_rad, half_angle_rad, length_m, box_edge_m, box_axis_rad,
      centre_m;

  void Add(const TrueShape& truth, const ShapeErrors& errors);
};

// A true shape that was not found, or an invented one, with the scene in which to look at it again.
struct Failure {
  std::string scene;  // family and seed, as `cwm-bench scene` takes them
  std::string what;
};

class ShapeTally {
 public:
  // Adds a scene. All views have the same sensor; `scene` names the failures.
  void Add(const std::string& scene, const InterpretedView& view, const SceneShapes& shapes);

  int true_count() const { return true_count_; }
  double found_share() const;
  double equivalent_share() const;  // of all true shapes
  double spurious_share() const;    // spurious shapes per true one
  const ErrorSamples& errors() const { return all_; }
  const ErrorSamples& far_errors() const { return far_; }    // beyond kFar_m
  const ErrorSamples& thin_errors() const { return thin_; }  // below kThin_m of radius
  const std::vector<Failure>& failures() const { return failures_; }
  const std::vector<Failure>& large_errors() const { return large_errors_; }  // of found shapes
  const ParameterCalibration& calibration() const { return calibration_; }

  // A table of kinds against outcomes, and one of the invented shapes.
  std::vector<std::string> Lines() const;

  static constexpr double kFar_m = 1.0;
  static constexpr double kThin_m = 0.025;
  // Errors beyond these limits are listed; 95 of 100 should be below them.
  static constexpr double kLargeRadius_m = 0.0025, kLargeAxis_deg = 2.5, kLargeLength_m = 0.006;

 private:
  void AddTruth(const std::string& scene, const InterpretedView& view, const TrueShape& truth,
                const SceneShapes& shapes, const ShapeOutcome& outcome);

  int true_count_ = 0;
  std::map<ShapeKind, std::array<int, kOutcomeCount>> outcomes_;
  std::array<int, kInventionCount> inventions_ = {};
  ErrorSamples all_, far_, thin_;
  std::vector<Failure> failures_, large_errors_;
  ParameterCalibration calibration_;
};

}  // namespace cwm::benchmarks
