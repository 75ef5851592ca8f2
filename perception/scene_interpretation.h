// What one scan holds: the interpreter's result, as values that tracking and the server read.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "collision/geometry/hybrid_model.h"

namespace cwm::perception {

// A horizontal surface that things can stand on. Its frame has z up and z = 0 in the top face; its
// model is one Plate: its top face was measured, as its quality says; its body, kPlateThickness_m,
// was supplied, so its role is COMPLETED; and a surface for those of its points that the plate does
// not reach, if any.
struct DetectedSupport {
  Pose X_WO = Pose::Identity();
  std::shared_ptr<const HybridModel> model;
  // Set when the sensor's pose was given: top between 0.35 and 1.5 m above the world's floor z = 0
  // (paper, IV).
  std::optional<bool> reachable;
  int point_count = 0;
};

enum class DetectedKind { kObject, kResidual };  // on a support, or neither support nor object

struct DetectedObject {
  DetectedKind kind = DetectedKind::kObject;
  Pose X_WO = Pose::Identity();
  std::shared_ptr<const HybridModel> model;  // in the object's frame
  // Index into supports: the one below, at the bottom of a stack; -1 for residuals.
  int supported_by = -1;
  int rests_on = -1;  // index into objects: what is between it and the support; -1 for nothing
  // Its measured points, thinned to about 4 mm or to their noise where that is more, for
  // association. In the level frame L, whose axes are the world's and whose origin is the sensor
  // (p_W = X_WC.translation() + p_L): floats are precise near the sensor, and would not be far
  // from the world's origin.
  std::vector<Eigen::Vector3f> points_L;
};

struct StageTime {
  std::string stage;  // "normals", "supports", "clusters", "split", or "shapes" (surfaces included)
  double elapsed_ms = 0;
};

struct InterpretReport {
  std::uint64_t points_in = 0;
  std::uint64_t points_finite = 0;
  // Within tolerance of a support, a shape, a handle or a surface; of a thing that is measured far
  // more densely than its noise asks for, the share of an even sample of its points times all.
  std::uint64_t points_explained = 0;
  std::uint64_t points_rejected = 0;  // finite, labelled 0: isolated points that belong to nothing
  std::vector<std::string> warnings;
  std::vector<StageTime> stages;
};

struct SceneInterpretation {
  Pose X_WC = Pose::Identity();  // given or estimated
  // X_WC was estimated, and nothing bears it out: no plane tells where up is, or one that may be a
  // wall. Good for this scan alone.
  bool pose_is_guess = false;
  std::vector<DetectedSupport> supports;
  std::vector<DetectedObject> objects;  // objects first, then residuals
  // One label per input point: 0 none, 1-9 supports, object i (from 1, in the order above,
  // residuals included) 10 * (i + 1) + part, part 0 the object as such, 1-9 its parts. Supports
  // after the ninth share label 9, and so do an object's parts after its ninth.
  std::vector<std::uint32_t> labels;
  InterpretReport report;
};

}  // namespace cwm::perception
