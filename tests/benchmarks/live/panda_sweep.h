// A simulated Panda that sweeps its hand closely over things on a table, seen by a fixed camera,
// with truth: for measuring how its pixels are told apart. The images of the truth are ray casts of
// the scanner, which shares nothing with the code that is measured.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "collision/robot/robot_model.h"
#include "perception/live/robot_view.h"
#include "perception/simulation/frame_errors.h"

namespace cwm::benchmarks {

struct SweepFrame {
  double time_s = 0;
  perception::DepthImage image;
  // Per pixel, as MeasuredDepth::object: things first, then links.
  std::vector<std::int32_t> object;
};

class PandaSweep {
 public:
  // Empty if motion_bench_maker is not in CWM_DATA.
  static std::optional<PandaSweep> Read();

  const collision::RobotModel& model() const { return *model_; }
  const std::shared_ptr<const perception::RobotSurface>& surface() const { return surface_; }
  const perception::DepthCamera& camera() const { return camera_; }
  const Pose& X_WC() const { return pinhole_.X_WC; }
  const perception::SensorNoise& noise() const { return noise_; }
  int thing_count() const { return static_cast<int>(things_.objects.size()); }
  bool IsRobot(std::int32_t object) const { return object >= thing_count(); }
  // The root mean square of the hand's speed.
  double hand_speed_m_s() const { return hand_speed_m_s_; }

  // The poses of the links at a time, with their velocities.
  std::vector<perception::LinkAtStamp> LinksAt(double time_s) const;
  SweepFrame Frame(double time_s, std::uint64_t seed) const;

  // The known things as they should look without the robot.
  const std::vector<float>& expected_m() const { return expected_m_; }
  const std::vector<perception::BodyId>& expected_body() const { return expected_body_; }

  // The least distance of the hand and the fingers from each thing's points that the frame shows.
  std::vector<double> HandDistances_m(const SweepFrame& frame) const;

 private:
  std::vector<Pose> PosesAt(double time_s) const;
  void PlaceThings();
  // True if the top of a can stays farther than a gap from the hand's links on its whole path.
  bool IsClear(const std::vector<std::vector<Pose>>& path, const Vector3& foot_W, double radius_m,
               double height_m, double gap_m) const;
  void RenderExpected();

  std::shared_ptr<const collision::RobotModel> model_;
  std::shared_ptr<const perception::RobotSurface> surface_;
  std::vector<int> hand_links_;
  perception::SensorNoise noise_;
  perception::PinholeCamera pinhole_;
  perception::DepthCamera camera_;
  perception::SimulatedScene things_;
  perception::DeviceErrors device_;
  std::vector<float> expected_m_;
  std::vector<perception::BodyId> expected_body_;
  double rate_ = 1;  // of the trajectory, so that the hand has its speed
  double hand_speed_m_s_ = 0;
};

}  // namespace cwm::benchmarks
