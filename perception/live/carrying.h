// Tells which bodies move with a link of a robot though nobody attached them, and where they are.
#pragma once

#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "perception/live/body_fit.h"
#include "perception/live/pose_evidence.h"

namespace cwm::perception {

// One body: it rests, moves by itself, or moves with a link. In each frame these hypotheses compete
// by the depths at the poses that they call for: "it moves with the link since t", for each link
// that touched it at a moment t of the last half second; "it rests since t"; and a pose that was
// found without either. Another hypothesis is believed if it explains the frame better by odds of
// kDecisive. A body that is found by itself moves with a link if the two move as one for a while.
// A value: copies are independent.
class Carrying {
 public:
  // chosen: the logarithm of odds of 20,000: some four samples of a surface that are hit at one
  // place and passed at the other.
  static constexpr double kDecisive = 10;

  enum class Verdict {
    kNone,    // not carried
    kBegins,  // moves with a link from this frame on
    kGoesOn,
    kEnds,  // the link has left it
    kLost   // it is not where the link would have it
  };
  struct Outcome {
    Verdict verdict = Verdict::kNone;
    Pose X_WB = Pose::Identity();  // of the body now, but with kNone
  };

  // A body that is not carried. `X_WB`: its pose without a link, the one at which it rests or was
  // found in this frame. A moving body has been found at its poses.
  Outcome Watch(const FrameEvidence& frame, const BodyEvidence& evidence, const BodySurface& body,
                std::span<const NeighbourBody> others, const Pose& X_WB, bool rests);
  // A body that is carried. `X_WB`: where the link has it; `fit`: the pose that its points say.
  Outcome Follow(const FrameEvidence& frame, const BodyEvidence& evidence, const BodySurface& body,
                 std::span<const NeighbourBody> others, const Pose& X_WB,
                 const std::optional<Pose>& fit);

  bool is_carried() const { return carrier_.has_value(); }
  // The "robot/link" that carries the body; empty if none does, and as long as a push explains its
  // motion: it was not lifted, and a link is behind it. What lies between several links is carried
  // by the link that moves all of them.
  std::string carried_by() const;
  // The place of a carried body. Empty: not carried, or the links' places are not known.
  std::optional<Pose> PoseAt(std::span<const RobotLinks> robots) const;

  void Reset() { *this = Carrying(); }

 private:
  struct Link {
    std::string robot = {};
    int index = -1;
    Pose X_WL = Pose::Identity();
  };
  // The body in one frame, and the links that touched it or moved all that did.
  struct Moment {
    Stamp stamp = {};
    Pose X_WB = Pose::Identity();
    double log_odds = 0;
    std::vector<Link> links = {};
  };
  struct Carrier {
    std::string robot = {};
    int index = -1;
    std::string name = {};
    Pose X_LB = Pose::Identity();
    int fits = 0;  // that its place is the mean of
    // When it began: the body, and its points that were the nearest to links, in its frame.
    Pose X_WB_begin = Pose::Identity();
    std::vector<Vector3> touched_B = {};
    bool is_held = false;
  };
  // A moment since which a link may carry the body, and where the body would be now.
  struct Candidate {
    const Moment* since = nullptr;
    const Link* link = nullptr;
    Pose X_WB = Pose::Identity();
    double log_odds = 0;
  };

  std::vector<Candidate> Candidates(const FrameEvidence& frame, const BodySurface& body,
                                    const Pose& X_WB) const;
  std::optional<Candidate> BestCarrier(const FrameEvidence& frame, const BodyEvidence& evidence,
                                       const BodySurface& body, const NearbySurfaces& nearby,
                                       const Pose& X_WB, double believed_odds, bool rests) const;
  void Begin(const FrameEvidence& frame, const BodySurface& body, const Candidate& candidate,
             const Pose& X_WB);
  void Remember(const FrameEvidence& frame, const BodySurface& body, const Pose& X_WB,
                double log_odds);
  void NoteHeld(const FrameEvidence& frame, const BodySurface& body, const Pose& X_WB);

  std::deque<Moment> moments_;  // oldest first
  std::optional<Carrier> carrier_;
  int lost_frames_ = 0;
};

}  // namespace cwm::perception
