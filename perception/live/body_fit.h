// Finds the pose of a followed body in one frame, and judges poses by the frame's depths.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "perception/live/frame_evidence.h"
#include "perception/track/model_surface.h"

namespace cwm::perception {

// A body's surface, prepared once per model. Immutable, shared.
class BodySurface {
 public:
  explicit BodySurface(std::shared_ptr<const HybridModel> model);

  const HybridModel& model() const { return *model_; }
  const ModelSurface& surface() const { return surface_; }
  const std::vector<SurfaceSample>& samples() const { return samples_; }
  // Root mean square distance of the samples from the body's origin, in metres; turns rotations
  // into lengths.
  double lever_m() const { return lever_m_; }
  const Aabb& bounds_O() const { return bounds_O_; }

 private:
  std::shared_ptr<const HybridModel> model_;
  ModelSurface surface_;
  std::vector<SurfaceSample> samples_;
  double lever_m_ = 0;
  Aabb bounds_O_;
};

// A sample of a surface that faces the camera, and the depth of its pixel.
struct SeenSample {
  Vector3 p_C = Vector3::Zero();         // of the sample, in the optical frame
  std::optional<float> measured_m = {};  // empty: outside of the image, or no return
};
// Empty: the sample faces away, is grazed by its ray, or lies behind the camera.
std::optional<SeenSample> SeenAt(const FrameEvidence& frame, const Pose& X_CB,
                                 const SurfaceSample& sample);

// Samples of the surface that face the sensor, by what the frame's depth says of them.
struct PoseScore {
  int hit = 0;
  int through = 0;
  int hidden = 0;

  int visible() const { return hit + through; }
  // From -1, all seen through, to 1, all hit.
  double value() const;
};
PoseScore ScoreOf(const FrameEvidence& frame, const BodySurface& body, const Pose& X_WB);

// The largest distance, in metres, of a sample between the two poses.
double LargestShift_m(const BodySurface& body, const Pose& X_WB, const Pose& X_WB_other);

// The distance within which the surface explains a depth of this frame at the body's place, metres:
// three standard deviations of noise, warp and the sensor's pose.
double FitGate_m(const FrameEvidence& frame, const Pose& X_WB);

// A surface at its place in the level frame L of a frame.
struct PlacedSurface {
  std::shared_ptr<const BodySurface> surface = {};
  Pose X_LB = Pose::Identity();

  // True if the point lies on the surface or inside of it, within the distance.
  bool Explains(const Vector3& p_L, double within_m) const;
};

// The points of the evidence that none of the supports explains.
std::vector<Eigen::Vector3f> OwnPoints(const BodyEvidence& evidence,
                                       std::span<const PlacedSurface> supports, double within_m);

// The purpose of a fit: it must show
enum class FitFor {
  kStart,  // that the body moved: it agrees better with the frame than the old pose does
  kGoOn    // that it agrees with the frame
};

// Aligns the body with its own points, from the guess. Empty if the frame does not confirm the
// aligned pose: few points lie on it, or more rays pass through it than through the body at rest,
// where its score was `rest_score`: rays pass through a model that is larger than the thing.
std::optional<Pose> FitPose(const FrameEvidence& frame,
                            const std::vector<Eigen::Vector3f>& points_L, const BodySurface& body,
                            double rest_score, const Pose& X_WB_old, const Pose& X_WB_guess,
                            FitFor purpose);

// Looks for a body that is not where it was in the hot regions that are about as large as it is:
// aligns it from the place at which the middle of its visible side is that of the region's points.
// Empty if no region is the body.
std::optional<Pose> FindInRegions(const FrameEvidence& frame, const BodySurface& body,
                                  double rest_score, const Pose& X_WB_old);

}  // namespace cwm::perception
