// Tells the pixels of a frame that show a robot, what it carries, or the edge or the shadow of
// either, by the robot's model at the frame's stamp.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "perception/cloud/sensor_noise.h"
#include "perception/live/depth_image.h"
#include "perception/live/known_body.h"
#include "perception/live/robot_mask.h"
#include "perception/live/robot_reach.h"
#include "perception/live/robot_surface.h"

namespace cwm::perception {

// The velocity of a frame F in the world: of its origin, and of its rotation.
struct SpatialVelocity {
  Vector3 angular_W_rad_s = Vector3::Zero();
  Vector3 linear_W_m_s = Vector3::Zero();
};

// The constant velocity that takes a frame from one pose to the other in `duration_s` (positive).
SpatialVelocity VelocityBetween(const Pose& X_WF_before, const Pose& X_WF_after, double duration_s);

struct LinkAtStamp {
  Pose X_WL = Pose::Identity();
  SpatialVelocity V_WL = {};
};

// How the state of a robot at a frame's stamp was found.
enum class StateSource : std::uint8_t {
  kInterpolated,  // between two states
  kExtrapolated,  // by the velocity of the last states
  kHeld,          // the last state, as it was
  kMissing        // there is none that tells where the links are
};

struct RobotAtStamp {
  StateSource source = StateSource::kMissing;
  // The time by which the frame's stamp is later than the newest state: 0 if interpolated. The
  // links may have moved since by their speed.
  double late_s = 0;
  std::span<const LinkAtStamp> links = {};  // one per link; not used if the state is missing
  ReachSphere reach_W = {};                 // where the links may be if the state is missing
};

// A body that a robot carries. The body's X_WB is its pose at the stamp; it moves with the link.
struct CarriedAtStamp {
  const KnownBody* body = nullptr;  // not null, nor its model
  int link = 0;
};

// The least distance from the model of a link within which measured points are the robot's is the
// sum of kGate_sigma times the sensor's noise and warp, `calibration_m`, and the speed of the link,
// relative to the camera, times (`clock_s` + RobotAtStamp::late_s + `exposure_s` / 2).
struct RobotMargins {
  // chosen: covers hand-eye calibrations, encoders, and visible surfaces outside of the collision
  // geometry, as far as they are known to be good to two centimetres.
  double calibration_m = 0.02;
  // The same for what is carried, beside its link's.
  double carried_m = 0.01;
  // chosen: by how much the stamps of frames and states may disagree.
  double clock_s = 0.005;
  double exposure_s = 0;
};

struct RobotFrame {
  const DepthCamera* camera = nullptr;  // not null
  Pose X_WC = Pose::Identity();
  SpatialVelocity V_WC = {};          // of a camera that moves, such as one on a link
  const DepthImage* image = nullptr;  // not null; of the camera's size
  SensorNoise noise = {};
  // Of the known bodies, without or with those that are carried, as ExpectedView has them; empty if
  // they are not known. A pixel that a known surface explains better than the robot is left to it.
  std::span<const float> expected_m = {};
  std::span<const BodyId> expected_body = {};
};

enum class RobotStateFault : std::uint8_t {
  kNone,
  kMissing,  // no state: the frame may add nothing within the robot's reach
  kWrong     // rays pass through a link: its state is late or the calibration is wrong
};

struct RobotSighting {
  RobotMask mask = {};
  RobotStateFault fault = RobotStateFault::kNone;
  // The link through which most rays pass, of those whose pose is wrong if any is: how many do, and
  // their share of those that must meet the link if its pose is right within the margin. -1: no ray
  // passes through any link.
  int through_link = -1;
  int through_pixels = 0;
  double through_share = 0;
};

// Not thread safe: it keeps buffers. Deterministic: a result follows from the arguments of its call
// alone.
class RobotView {
 public:
  explicit RobotView(std::shared_ptr<const RobotSurface> surface);
  ~RobotView();

  // A measured point within the margin of a link is kRobot, or kCarried within that of a carried
  // body, whichever is nearer. Others are kMixed if their pixel is at most 3 pixels from one of
  // these or from the rendered outline, and their depth behind it is not that of a known surface;
  // and kHidden if the pixel is rendered, has no return, and no known surface is before the robot.
  // Points before the robot are left alone. If kWrong, whatever the pose may have hidden is kMixed:
  // what is within kWrongState_m beyond the margin, or passes the robot so closely, unless a known
  // surface explains it.
  static constexpr double kWrongState_m = 0.08;
  RobotSighting Mask(const RobotFrame& frame, const RobotAtStamp& robot,
                     std::span<const CarriedAtStamp> carried, const RobotMargins& margins);

 private:
  struct Scratch;
  std::shared_ptr<const RobotSurface> surface_;
  std::unique_ptr<Scratch> scratch_;
};

// Adds another robot's mask of the same frame. Robots and what they carry come before outlines, and
// those before what is hidden.
void MergeMask(const RobotMask& other, const DepthCamera& camera, RobotMask& mask);

}  // namespace cwm::perception
