// The evidence of one frame that a body is at a pose, beside robots whose own surfaces count as
// nothing.
#pragma once

#include <span>
#include <vector>

#include "perception/live/body_fit.h"
#include "perception/live/robot_links.h"

namespace cwm::perception {

// The links of robots that come near a body.
class NearLinks {
 public:
  // Those of which a part is within `reach_m` of a ball about the body, whatever its pose.
  NearLinks(const FrameEvidence& frame, const Vector3& center_W, double reach_m);

  // True if the point is where a link's surface is, up to noise and the error of its stamp.
  bool IsLink(const Vector3& p_W) const;
  bool empty() const { return links_.empty(); }

 private:
  struct Near {
    const LinkSurface* surface = nullptr;
    Pose X_LW = Pose::Identity();
    float within_m = 0;
  };
  std::vector<Near> links_;
};

struct PoseEvidence {
  // The logarithm of the odds that the body is at the pose, against that it is elsewhere: samples
  // of its surface are hit or passed by rays with the chances of TrackedBody's test of removal.
  double log_odds = 0;
  int hit = 0;
  int through = 0;
  int hidden = 0;  // by what is in front of the body, robots included

  int visible() const { return hit + through; }
  bool IsHidden() const;
};

// `expected_px`: the pixels in which the body is seen if nothing is in front of it.
PoseEvidence EvidenceAt(const FrameEvidence& frame, const BodySurface& body, const Pose& X_WB,
                        int expected_px, const NearLinks& links);

}  // namespace cwm::perception
