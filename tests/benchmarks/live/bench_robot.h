// The robot in view of the sensors: the Panda, where its files are in CWM_DATA, or an arm of
// primitives.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "clients/cpp/robot_upload.h"
#include "collision/robot/robot_model.h"
#include "perception/simulation/sequence_script.h"

namespace cwm::benchmarks {

struct BenchRobot {
  std::string name;
  std::string urdf;
  std::string srdf = {};     // may be empty
  std::string spheres = {};  // the URDF of its spheres; may be empty
  std::vector<client::RobotFile> meshes = {};
  std::shared_ptr<const collision::RobotModel> model = {};
  std::vector<double> ready = {};  // by variable: the hand in front, above a table
  std::size_t hand_link = 0;       // index into model->links
};

// The Panda, or the arm of primitives without CWM_DATA.
absl::StatusOr<BenchRobot> ReadBenchRobot();

// The base on the table's far side, facing the sensor in front.
Pose RobotBase();

// A robot of a script at RobotBase, whose joints follow the trajectory.
perception::SimulatedRobot SimulateRobot(const BenchRobot& robot,
                                         perception::JointTrajectory trajectory);

// Stands still for `rest_s`, then sweeps from side to side over the table until `duration_s`; the
// hand reaches `speed_m_s`.
perception::JointTrajectory SweepingTrajectory(const BenchRobot& robot, double rest_s,
                                               double duration_s, double speed_m_s);

// Puts the robot into a world, at RobotBase and in the given state. Its base may touch everything.
absl::Status LoadBenchRobot(const client::Connection& connection, const std::string& world,
                            const BenchRobot& robot, const std::vector<double>& state);

}  // namespace cwm::benchmarks
