// The evidence of one frame about the known world: the input of the tracker.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "perception/cloud/sensor_noise.h"
#include "perception/live/depth_image.h"
#include "perception/live/frame_classes.h"
#include "perception/live/known_body.h"
#include "perception/live/pose_sigma.h"
#include "perception/live/robot_links.h"

namespace cwm::perception {

using Stamp = std::chrono::system_clock::time_point;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// chosen: so many pixels that differ may show that a body is not where it was.
inline constexpr int kMinChanged_px = 12;
inline constexpr double kMinChangedShare = 0.03;

// The evidence about one body that is expected in it.
struct BodyEvidence {
  BodyId id = kNoBody;
  // Pixels in which the body is the first expected surface, and how many of them have each class.
  // `hidden` holds those of robots, of what they carry, and of their outlines.
  int expected = 0;
  int consistent = 0;
  int nearer = 0;
  int farther = 0;
  int missing = 0;
  int hidden = 0;
  // The rigid motion of the body, since it was given its pose, that explains the differences of
  // depths at its pixels, and of its outline, from their usual values: the normal equations
  // information * twist = moment, each depth with weight 1 / (sigma^2 kPointsPerIndependentSample),
  // sigma being the pixel's spread in time. At most 400 pixels, evenly chosen, stand for all; those
  // that differ by more than 10 mm say nothing. twist is (translation in m, rotation in rad) about
  // the body's origin in the world's axes. Zero for a sensor without a reference.
  Matrix6 information = Matrix6::Zero();
  Vector6 moment = Vector6::Zero();
  int moment_pixels = 0;

  // True if pixels of the body, or beside its outline, are in hot blocks.
  bool is_hot = false;
  // Only if hot: of the pixels that showed the body itself at rest, or might have, those that still
  // do, and those that rays pass through. Pixels of a model that is larger than the thing, and
  // those beside edges that show one side and the other, are evidence of nothing; nor are, while
  // the sensor moves, pixels that would be consistent without the body, by the error of its pose.
  int shown = 0;
  int passed = 0;
  // Only if hot, and for a sensor at rest: pixels that are farther than what was seen at rest and
  // than the body. Behind what hid the body and left, it is seen again, which is no motion.
  int beyond = 0;
  // Only if hot, or if the body was given another pose in the last frames: measured points that may
  // be of the body, which are neither robot nor mixed, and not nearer than the body by more than 30
  // mm, within 30 mm of its outline. At most kMaxBodyPoints, in the frame L (world's axes, origin
  // at the sensor).
  std::vector<Eigen::Vector3f> points_L = {};

  // So many of its pixels must differ.
  double MinChanged_px() const {
    return std::max<double>(kMinChanged_px, kMinChangedShare * (consistent + farther));
  }
  // True if rays pass through a part of it, for a sensor at rest.
  bool IsSeenThrough() const { return beyond >= MinChanged_px(); }
};
inline constexpr int kMaxBodyPoints = 600;

// A connected part of the image that differs from what is known.
struct HotRegion {
  std::vector<std::int32_t> blocks = {};  // indices of blocks, ascending
  int nearer = 0;                         // pixels
  int farther = 0;
  // Nearer pixels in which a sensor at rest saw something farther before: they show something that
  // has come, whereas others may show what something else hid.
  int entered = 0;
  std::vector<BodyId> bodies = {};  // whose expected pixels it touches, ascending
  // Time for which the main share of its blocks has stayed the same within noise; 0 if they still
  // change.
  double rest_s = 0;
  int rest_frames = 0;
  double half_rest_s = 0;  // the time for which half of its blocks have stayed the same
  // Blocks of which at least half shows something nearer. The rim of a known surface has none.
  int full_blocks = 0;
  bool is_cut = false;  // reaches the border of the image: what it shows may go on beyond
  // Points that no known surface explains (kNearer), in the frame L, at most one per 2 x 2 pixels.
  // While the sensor moves, only those at places that an earlier frame saw through: they are of
  // what has come, and not of what was always there and is seen for the first time.
  std::vector<Eigen::Vector3f> points_L = {};
};

struct FrameEvidence {
  std::string sensor = {};
  Stamp stamp = {};
  Pose X_WC = Pose::Identity();  // p_W = X_WC.translation() + p_L
  bool is_still = false;         // the sensor has the same pose as before, to the bit
  // The sensor has another pose than before: X_WC is the given one, corrected by the surfaces that
  // it sees, and its error is not known to better than this.
  bool is_moving = false;
  PoseSigma pose_sigma = {};
  bool may_move = false;  // the sensor's frames have poses of their own
  DepthCamera camera = {};
  SensorNoise noise = {};
  std::shared_ptr<const DepthImage> image = {};
  std::shared_ptr<const FrameClasses> classes = {};
  std::vector<BodyEvidence> bodies = {};  // expected in the view, by ascending id
  std::vector<HotRegion> regions = {};    // the largest first
  // At the stamp; only those whose state is known then and that no ray contradicts.
  std::vector<RobotLinks> robots = {};
  // False while the sensor moves, and until it has learnt its reference once it stands.
  bool has_reference = false;
};

}  // namespace cwm::perception
