// The evidence of one frame that a body is at a pose, beside robots and other bodies.
#pragma once

#include <span>
#include <vector>

#include "perception/live/body_fit.h"
#include "perception/live/robot_links.h"

namespace cwm::perception {

// Another body at its place.
struct NeighbourBody {
  BodyId id = kNoBody;
  PlacedSurface placed = {};
};

// The surfaces about a body that are not its own: of the links of robots, and of other bodies.
class NearbySurfaces {
 public:
  // Those of which a part is within `reach_m` of a place.
  NearbySurfaces(const FrameEvidence& frame, std::span<const NeighbourBody> others, BodyId own,
                 const Vector3& center_W, double reach_m);

  // True if the point is where one of them is, up to noise and the error of the link's stamp.
  bool Explain(const Vector3& p_W) const;

 private:
  struct Link {
    const LinkSurface* surface = nullptr;
    Pose X_LW = Pose::Identity();
    float within_m = 0;
  };
  std::vector<Link> links_;
  std::vector<const PlacedSurface*> bodies_;
  Vector3 p_WC_ = Vector3::Zero();
  double within_m_ = 0;  // of bodies
};

struct PoseEvidence {
  // The logarithm of the odds that the body is at the pose, against that it is elsewhere: samples
  // of its surface are hit or passed by rays with the chances of TrackedBody's test of removal.
  double log_odds = 0;
  int hit = 0;
  int through = 0;
  int hidden = 0;    // by what is in front of the body
  int on_other = 0;  // hit, but another surface is there

  int visible() const { return hit + through; }
  // True if most of what is seen at the body's place can only be the body.
  bool IsShown() const { return hit > on_other; }
  bool IsHidden() const;
};

// `expected_px`: the pixels in which the body is seen if nothing is in front of it.
PoseEvidence EvidenceAt(const FrameEvidence& frame, const BodySurface& body, const Pose& X_WB,
                        int expected_px, const NearbySurfaces& nearby);

}  // namespace cwm::perception
