// Running sensors and robots: frames in, what became of them out. X_AB is the pose of B in A: W is
// the world, S the sensor, L a link, B the base of a robot.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "cwm/namespace.h"
#include "cwm/objects.h"
#include "cwm/scans.h"

namespace cwm::CWM_API {

// A camera without distortion in its optical frame (z forward, x right, y down): u = fx x / z + cx,
// v = fy y / z + cy; the centre of the first pixel is (0, 0).
struct Pinhole {
  double fx_px = 0, fy_px = 0;  // positive
  double cx_px = 0, cy_px = 0;
};

// The place of a sensor on a robot.
struct SensorMount {
  std::string robot;
  std::string link;
  Eigen::Isometry3d X_LS = Eigen::Isometry3d::Identity();
};

// The integers of a depth image have no return at 0 and 65535; its floats at 0, NaN and infinity.
enum class DepthType { kU16 = 1, kF32 };

// A sensor that sends depth images. A sensor of the same name and calibration keeps what was learnt
// of it.
struct SensorCalibration {
  std::string sensor;  // its name, 1 to 128 characters
  int width = 0, height = 0;
  Pinhole pinhole = {};
  DepthType depth_type = DepthType::kU16;
  double unit_m = 0;  // metres per unit; 0: 0.001 for integers, 1 for floats
  std::variant<SensorModel, SensorNoise> model = SensorModel::kKinect;
  // At most one of the two. Neither: every frame has its pose, an earlier scan of the sensor had
  // one, or the first frame is interpreted to tell it.
  std::optional<Eigen::Isometry3d> X_WS = {};
  std::optional<SensorMount> mount = {};
  double min_range_m = 0, max_range_m = 0;  // other depths are no return; 0: those of the model
  // Standard deviations of the pose; 0: 5 mm, 0.005 rad.
  double pose_sigma_m = 0, pose_sigma_rad = 0;
  // Frames take turns with those of other sensors, and each is answered when everything that it
  // began is done: what all sensors of a world stream so can be replayed to the bit.
  bool lockstep = false;
};

// The facts of a frame besides its image.
struct FrameInfo {
  Time stamp = {};  // the middle of the exposure
  double exposure_s = 0;
  std::optional<Eigen::Isometry3d> X_WS = {};  // of a sensor that moves, at the stamp
  // The covariance of that pose: translation (m), then rotation (rad), both in the world's frame.
  std::optional<Eigen::Matrix<double, 6, 6>> covariance = {};
};

enum class FrameFate { kProcessed = 1, kDropped, kRefused };

// Numbers of pixels by class; see docs/live.md.
struct PixelCounts {
  std::int64_t consistent = 0;
  std::int64_t nearer = 0;
  std::int64_t farther = 0;
  std::int64_t missing = 0;
  std::int64_t robot = 0;
  std::int64_t carried = 0;
  std::int64_t mixed = 0;
  std::int64_t hidden = 0;
};

// The changes of the world by a frame, by name.
struct FrameChanges {
  std::vector<std::string> added = {};
  std::vector<std::string> moved = {};
  std::vector<std::string> replaced = {};
  std::vector<std::string> removed = {};
  std::vector<std::string> movers = {};  // objects of the kind kMover
};

// The fate of a frame.
struct FrameResult {
  std::int64_t frame = 0;  // its number in the stream, from 0
  Time stamp = {};
  FrameFate fate = FrameFate::kProcessed;
  std::string reason = {};   // of a refusal or a reservation, such as STALE_FRAME; or empty
  std::string message = {};  // the reason in words
  std::string world_uid = {};
  std::int64_t revision = 0;  // of the world after the frame
  FrameChanges changes = {};
  PixelCounts pixels = {};
  Eigen::Isometry3d X_WS = Eigen::Isometry3d::Identity();  // that was used
  std::optional<double> robot_state_age_ms = {};
  std::vector<std::pair<std::string, double>> stages_ms = {};
  bool interpreting = false;  // a region of the view is interpreted beside the frames
  // In the order in which the frames of all sensors were taken into the world, from 1; 0: it was not
  // processed.
  std::int64_t sequence_number = 0;
};

// Made by World::StreamSensor. Every frame is answered once, in order; the newest one wins: while
// one is processed at most one waits, and a newer one takes its place (kDropped). One thread may
// send while another reads.
//
//   stream.Process(image, {.stamp = now})    one at a time, or
//   stream.Send(image, {.stamp = now})       here, and
//   while (const auto result = stream.Next()) { ... }   there
class SensorStream {
 public:
  class Call;
  explicit SensorStream(std::unique_ptr<Call> call);
  ~SensorStream();  // ends the stream; frames that were not answered may be lost
  SensorStream(SensorStream&&) noexcept;
  SensorStream& operator=(SensorStream&&) noexcept;

  // Sends a depth image of height x width numbers, row by row, of the calibration's type; returns
  // the frame's number. Throws Error: kInvalidArgument for another number or type, and the reason
  // of the server once it has ended the stream.
  std::int64_t Send(std::span<const std::uint16_t> depths, const FrameInfo& frame);
  std::int64_t Send(std::span<const float> depths, const FrameInfo& frame);
  // Waits for the next answer; none after Finish and the last one. Throws Error if the server ends
  // the stream.
  std::optional<FrameResult> Next();
  // Send, then Next until the answer to this frame.
  FrameResult Process(std::span<const std::uint16_t> depths, const FrameInfo& frame);
  FrameResult Process(std::span<const float> depths, const FrameInfo& frame);
  // No more frames come; those that were sent are still answered.
  void Finish();
  // Ends the stream at once; from any thread.
  void Close();

 private:
  std::unique_ptr<Call> call_;
};

struct RobotStatesSummary {
  std::string world_uid;
  std::int64_t revision = 0;
  std::int64_t state_count = 0;    // that were taken
  std::int64_t ignored_count = 0;  // whose stamps were known already
};

// Made by World::StreamRobotStates: where a robot stands while it moves. For one thread.
class RobotStateStream {
 public:
  class Call;
  explicit RobotStateStream(std::unique_ptr<Call> call);
  ~RobotStateStream();  // ends the stream
  RobotStateStream(RobotStateStream&&) noexcept;
  RobotStateStream& operator=(RobotStateStream&&) noexcept;

  // The values of the stream's variables, rad or m, at a time. Throws Error: the reason of the
  // server once it has ended the stream, as it does for a wrong number of values.
  void Send(Time stamp, const Eigen::Ref<const Eigen::VectorXd>& values,
            const std::optional<Eigen::Isometry3d>& X_WB = {});
  // Several: one column for each stamp, and one base or none at all.
  void Send(std::span<const Time> stamps, const Eigen::Ref<const Eigen::MatrixXd>& values,
            std::span<const Eigen::Isometry3d> X_WB = {});
  // Ends the stream. Throws Error if the server refused states.
  RobotStatesSummary Finish();

 private:
  std::unique_ptr<Call> call_;
};

// The pose of a sensor that surfaces at rest suggest.
struct SensorPoseEstimate {
  Eigen::Isometry3d X_WS = Eigen::Isometry3d::Identity();
  double translation_error_m = 0;  // from the pose that is used
  double rotation_error_rad = 0;
  double sigma_m = 0, sigma_rad = 0;
  std::int64_t surface_count = 0;
};

// A sensor that streams or has streamed.
struct Sensor {
  std::string name;
  bool is_streaming = false;
  Eigen::Isometry3d X_WS = Eigen::Isometry3d::Identity();  // of its newest frame
  std::optional<SensorMount> mount = {};
  std::optional<Time> last_frame = {};
  double frame_rate_hz = 0;  // of processed frames, over the last seconds
  double latency_p50_ms = 0, latency_p95_ms = 0;
  std::int64_t processed_count = 0, dropped_count = 0, refused_count = 0;
  std::optional<SensorPoseEstimate> estimate = {};  // absent: too few surfaces determine it
  std::optional<double> delay_ms = {};              // between stamps and arrival, the least
  std::vector<std::string> conflicts = {};          // with other sensors, newest last
};

}  // namespace cwm::CWM_API
