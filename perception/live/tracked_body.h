// One body that is followed: rests, moves, is hidden, is gone. A value: copies are independent.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "perception/live/body_fit.h"
#include "perception/live/frame_evidence.h"
#include "perception/live/shift_test.h"
#include "perception/live/tracker.h"

namespace cwm::perception {

class TrackedBody {
 public:
  struct Outcome {
    std::optional<Pose> X_WB = {};     // the pose to publish
    std::optional<Pose> seen_at = {};  // the pose in a frame that gives none to publish
    bool is_gone = false;  // rays pass through its place, or it moved and was not seen for long
  };

  // Takes the evidence of one frame about the body as the world holds it. Points on the supports
  // are not of the body. `is_touched`: something else may be at the body, such as a finger.
  Outcome Update(const FrameEvidence& frame, const BodyEvidence& evidence, const KnownBody& body,
                 std::span<const PlacedSurface> supports, bool is_touched);
  // The pose of a body that a link of a robot carries, by its own points; the body's X_WB is where
  // the link has it. Empty if too little of it is seen.
  std::optional<Pose> FitCarried(const FrameEvidence& frame, const BodyEvidence& evidence,
                                 const KnownBody& body,
                                 std::span<const PlacedSurface> supports) const;
  // A link carries the body in this frame; `has_moved`: its pose has changed. Null: the view does
  // not contain it.
  void Carry(const FrameEvidence& frame, const BodyEvidence* evidence,
             const std::string& carried_by, bool has_moved);
  // The link has left the body at this pose, or, `is_lost`, it is not where the link has it.
  void LetGo(Stamp stamp, const Pose& X_WB, bool is_lost);
  // The frame's view does not contain the body.
  Outcome OutOfView(const FrameEvidence& frame);
  void ForgetSensor(const std::string& sensor);

  const TrackedFacts& facts() const { return facts_; }
  // Null before the first Update.
  const std::shared_ptr<const BodySurface>& surface() const { return surface_; }
  bool rests() const { return facts_.motion == Motion::kAtRest; }
  bool is_carried() const { return is_carried_; }

 private:
  struct SensorEvidence {
    Visibility visibility = Visibility::kStale;
    Stamp last = {};         // its newest frame with the body
    double information = 0;  // of its visible pixels in that frame, by their noise
    double gone_log_odds = 0;
    int through_frames = 0;
    Stamp through_since = {};
    ShiftTest shift = {};
    Pose X_WB = Pose::Identity();  // in the last frame
  };
  struct StampedPose {
    Stamp stamp = {};
    Pose X_WB = Pose::Identity();
  };

  // Makes the sensor that tells most of the body its leader, with some inertia. True if that is the
  // frame's: only the leader's frames give poses, so that a body is not moved back and forth by the
  // differences of what sensors measure.
  bool TakeLead(const FrameEvidence& frame, const BodyEvidence& evidence, const KnownBody& body);
  bool IsGone(const FrameEvidence& frame, const BodyEvidence& evidence, SensorEvidence& sensor);
  bool IsLostForLong(Stamp stamp);
  std::optional<Pose> SmallShift(const FrameEvidence& frame, const BodyEvidence& evidence,
                                 const KnownBody& body, SensorEvidence& sensor) const;
  // The mean motion over the kept poses, each component in m/s, turns at the body's lever.
  struct Speed {
    Vector6 mean = Vector6::Zero();
    Vector6 sigma = Vector6::Zero();  // its standard deviations, by the scatter of the poses
  };
  Speed SpeedOfPoses() const;
  bool HasSettled() const;
  Pose Predicted(Stamp stamp, const Pose& X_WB) const;
  std::optional<Pose> Follow(Stamp stamp, const Pose& X_WB, const std::optional<Pose>& fit);
  std::optional<Pose> Rest();
  void JoinVisibility();
  void NoteRest(const FrameEvidence& frame, const BodyEvidence& evidence, const KnownBody& body);

  TrackedFacts facts_ = {};
  std::map<std::string, SensorEvidence> sensors_;
  std::string leader_;  // a sensor
  std::shared_ptr<const BodySurface> surface_;
  double rest_score_ = 1;          // see FitPose; as when it was last seen at rest
  bool knows_rest_ = false;        // it was, at its present pose
  std::deque<StampedPose> poses_;  // of the last moments of a motion, oldest first
  Stamp settles_since_ = {};
  Stamp last_fit_ = {};  // of the newest frame that confirmed a pose of a motion
  std::optional<Stamp> lost_since_ = {};
  bool is_carried_ = false;
  Stamp last_carried_ = {};  // of the newest frame in which a link moved it
};

}  // namespace cwm::perception
