// Solves for joint values that put the tip of an arm at poses in the world, and computes the poses
// from them again.
#include <cwm/client.h>

#include <cstdio>
#include <numbers>
#include <vector>

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector3d;

constexpr char kUrdf[] = R"(<robot name="arm">
  <link name="base"/><link name="upper"/><link name="lower"/><link name="hand">
    <collision><geometry><sphere radius="0.03"/></geometry></collision></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/>
    <origin xyz="0.5 0 0"/><axis xyz="0 0 1"/><limit lower="-3" upper="3"/></joint>
  <joint name="wrist" type="revolute"><parent link="lower"/><child link="hand"/>
    <origin xyz="0.4 0 0"/><axis xyz="0 0 1"/><limit lower="-3" upper="3"/></joint>
</robot>)";

int main() try {
  const cwm::World world = cwm::Connect({.world = "inverse_kinematics"});
  world.LoadRobot({.urdf = kUrdf});
  const cwm::RobotSubject arm{.robot = "arm"};

  const AngleAxisd turn(std::numbers::pi / 2, Vector3d::UnitZ());
  const std::vector<Isometry3d> poses = {Translation3d(0.4, 0.5, 0) * turn,  // two elbows
                                         Translation3d(1.5, 0, 0) * turn};   // out of reach
  const cwm::PoseResult answer =
      world.Solve(arm, poses, {.tool_link = "hand", .max_solutions = 8, .avoid_collision = true});
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto pose = static_cast<Eigen::Index>(i);
    std::printf("pose %zu: %s\n", i, NameOf(answer.status[i]));
    const Eigen::MatrixXd solutions = answer.solutions(pose);
    if (solutions.cols() == 0) continue;
    const cwm::LinkPoses reached = world.PosesOfLinks(arm, solutions, {"hand"});
    for (Eigen::Index k = 0; k < solutions.cols(); ++k) {
      const Vector3d tip = reached.pose(k, "hand").translation();
      std::printf("  %7.4f %7.4f %7.4f rad put the hand at %.4f %.4f m\n", solutions(0, k),
                  solutions(1, k), solutions(2, k), tip.x(), tip.y());
    }
  }
} catch (const cwm::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
