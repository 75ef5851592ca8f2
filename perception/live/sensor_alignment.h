// The pose of a sensor by the surfaces at rest that another sensor sees too.
#pragma once

#include <optional>
#include <span>

#include "perception/live/mean_view.h"

namespace cwm::perception {

// How the view of a sensor lies to that of another one. A twist is (translation in m, rotation in
// rad) of the sensor about its own origin, in the world's axes.
struct ViewAlignment {
  // False: the views share no surface, or no small motion of the sensor makes them agree.
  bool is_aligned = false;
  // The motion of the sensor that brings its surfaces onto those of the other one, and what
  // determines it: the inverse of its covariance, with the errors of both sensors and of neither
  // pose. Both are zero in directions that no shared surface determines.
  Vector6 twist = Vector6::Zero();
  Matrix6 information = Matrix6::Zero();
  int determined = 0;  // directions, of six
  // Shared pieces of surface of a hand's breadth, of similar normals.
  int patches = 0;
  // Root mean square distance by which the sensors see the shared surfaces apart, metres: that of
  // the motion if they are aligned, else the median of what contradicts.
  double apart_m = 0;
  // The share of the sensor's points, of those that the other one could see, that lie before what
  // it sees, by more than noise and after the alignment. Points behind are hidden from it and say
  // nothing.
  double contradicting = 0;
  int compared = 0;  // points that the other sensor could see
};

// Iterated closest points with the distance from planes (Chen and Medioni 1991), on points of the
// sensor against the local planes of the other one's depths. Finds errors of the pose of some
// centimetres and degrees. A patch counts as one measurement with the warp of both sensors: their
// errors are alike over a patch, however many pixels it has.
ViewAlignment AlignViews(const MeanView& sensor, const MeanView& other);

// The pose moved by a twist about its origin, and the twist that moves one pose to another.
Pose Moved(const Pose& X_WC, const Vector6& twist);
Vector6 TwistBetween(const Pose& X_WC_from, const Pose& X_WC_to);
// The same alignment as the other sensor sees it: its motion onto the sensor.
ViewAlignment Reversed(const ViewAlignment& alignment, const MeanView& sensor,
                       const MeanView& other);

// The same alignment if all that the other sensor sees moves by X_WW.
ViewAlignment WithOtherMoved(const ViewAlignment& alignment, const MeanView& sensor,
                             const Pose& X_WW);

// True if the views differ by more than the errors of both given poses and of the alignment
// explain: beyond the 99.73 % quantile, that of three standard deviations.
bool Contradicts(const ViewAlignment& alignment, const MeanView& sensor, const MeanView& other);

// The most likely pose of a sensor by its given one and by its alignments with others, each with
// its errors. The given pose where nothing else determines it.
Pose MostLikelyPose(const MeanView& sensor, std::span<const ViewAlignment> alignments);

// The pose of a sensor by what the others see.
struct SensorPoseEstimate {
  Pose X_WC = Pose::Identity();
  double translation_error_m = 0;  // from the used pose
  double rotation_error_rad = 0;
  double sigma_m = 0;  // standard deviations in the direction that is known least
  double sigma_rad = 0;
  int patches = 0;
};

// Combines the alignments of one sensor with others: those that agree with each other and with the
// given pose best, weighted by their information. Empty if these do not determine all six
// directions to within kUndetermined_m; then `undetermined` gets the motion, a twist of unit length
// at a lever of a metre, that is known least, if there is any alignment.
inline constexpr double kUndetermined_m = 0.01;  // chosen: worse is no estimate
std::optional<SensorPoseEstimate> EstimatePose(const MeanView& sensor,
                                               std::span<const ViewAlignment> alignments,
                                               std::optional<Vector6>* undetermined = nullptr);

}  // namespace cwm::perception
