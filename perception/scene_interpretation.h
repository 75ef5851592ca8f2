// The interpreter's result for one scan, as values that tracking and the server read.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "collision/geometry/hybrid_model.h"

namespace cwm::perception {

// A level surface that objects can stand on. Its frame has z up and z = 0 in the top face. Its
// model is one Plate with role COMPLETED: the top face was measured, with the given quality, and
// the body of kPlateThickness_m was added. Points that the plate does not reach have a surface.
struct DetectedSupport {
  Pose X_WO = Pose::Identity();
  std::shared_ptr<const HybridModel> model;
  // Only set if the sensor's pose was given: true if the top is 0.35 to 1.5 m above the world's
  // floor z = 0 (paper, IV).
  std::optional<bool> reachable;
  int point_count = 0;
};

enum class DetectedKind { kObject, kResidual };  // on a support, or neither support nor object

struct DetectedObject {
  DetectedKind kind = DetectedKind::kObject;
  Pose X_WO = Pose::Identity();
  std::shared_ptr<const HybridModel> model;  // in the object's frame
  // Index into supports: the one at the bottom of the stack; -1 for residuals.
  int supported_by = -1;
  int rests_on = -1;  // index into objects: the one between it and the support; -1: none
  // Measured points for association, thinned to about 4 mm or to their noise if that is more. They
  // are in the level frame L, with the world's axes and its origin at the sensor (p_W =
  // X_WC.translation() + p_L), so that floats are precise at any distance from the world's origin.
  std::vector<Eigen::Vector3f> points_L;
};

struct StageTime {
  // "normals", "supports", "clusters", "split", or "shapes" (surfaces included); the server adds
  // its own.
  std::string stage;
  double elapsed_ms = 0;
};

struct InterpretReport {
  std::uint64_t points_in = 0;
  std::uint64_t points_finite = 0;
  // Number of points within tolerance of a support, shape, handle or surface. For an object that is
  // sampled, the share of its sample times all its points.
  std::uint64_t points_explained = 0;
  // Finite points with label 0: isolated, or beyond the sensor's range.
  std::uint64_t points_rejected = 0;
  std::vector<std::string> warnings;
  std::vector<StageTime> stages;
};

struct SceneInterpretation {
  Pose X_WC = Pose::Identity();  // given or estimated
  // X_WC was estimated without confirmation: no plane determines up, the plane may be a wall, or
  // another up is nearly as likely.
  // Such a pose is only valid for this scan.
  bool pose_is_guess = false;
  // False: not all points were seen from the origin of C, so that no ray is evidence of free space.
  bool seen_from_origin = true;
  // Half of the points lie where the sensor sees nothing: their unit is another one than metres.
  bool scale_is_implausible = false;
  std::vector<DetectedSupport> supports;
  std::vector<DetectedObject> objects;  // objects first, then residuals
  // One label per input point: 0 none, 1-9 supports, 10 * (i + 1) + part for object i (from 1, in
  // the order above, residuals included), with part 0 for the object itself and 1-9 for its parts.
  // Supports after the ninth share label 9, and so do parts of an object after the ninth.
  std::vector<std::uint32_t> labels;
  InterpretReport report;
};

}  // namespace cwm::perception
