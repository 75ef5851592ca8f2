// Plans a path of an arm with the two callbacks of OMPL, a validity checker of states and one of
// motions, and certifies the path that was found. The planner is the simplest rapidly-exploring
// random tree (LaValle 1998).
#include <cwm/client.h>

#include <algorithm>
#include <cstdio>
#include <random>
#include <vector>

using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector2d;

constexpr char kUrdf[] = R"(<robot name="arm">
  <link name="base"/>
  <link name="upper"><collision><origin xyz="0.25 0 0" rpy="0 1.5708 0"/>
    <geometry><cylinder radius="0.04" length="0.4"/></geometry></collision></link>
  <link name="lower"><collision><origin xyz="0.25 0 0" rpy="0 1.5708 0"/>
    <geometry><cylinder radius="0.04" length="0.4"/></geometry></collision></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/>
    <origin xyz="0.5 0 0"/><axis xyz="0 0 1"/><limit lower="-2.5" upper="2.5"/></joint>
</robot>)";

// Many small queries about one revision: a stream answers them soonest. Both may be called by
// several threads. With OMPL they are StateValidityChecker::isValid and
// MotionValidator::checkMotion, whose states are `values` of a RealVectorStateSpace.
class Validity {
 public:
  explicit Validity(const cwm::World& world) : stream_(world.At().Stream()) {}

  bool IsValid(const double* values) const {
    return stream_.Check(arm_, Eigen::Map<const Vector2d>(values), {.verdicts_only = true})
        .all_free();
  }
  // Certified, not sampled.
  bool CheckMotion(const double* from, const double* to) const {
    return stream_.Motions(arm_, Eigen::Map<const Vector2d>(from), Eigen::Map<const Vector2d>(to))
        .all_free();
  }

 private:
  const cwm::WorldView stream_;
  const cwm::RobotSubject arm_{.robot = "arm"};
};

struct Node {
  Vector2d state;
  std::size_t parent;
};

int main() try {
  const cwm::World world = cwm::Connect({.world = "plan_path"});
  world.LoadRobot({.urdf = kUrdf});
  world.Put("pillar", cwm::Cylinder{0.1, 1.0}, Isometry3d(Translation3d(0.75, 0, 0)));
  const Validity validity(world);
  const Vector2d start(-0.8, 0), goal(0.8, 0);
  if (!validity.IsValid(start.data()) || !validity.IsValid(goal.data())) return 1;

  constexpr double kRange_rad = 0.5, kGoalShare = 0.1;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> shoulder(-3, 3), elbow(-2.5, 2.5), share(0, 1);
  std::vector<Node> tree = {{start, 0}};
  while (tree.back().state != goal && tree.size() < 10'000) {
    const Vector2d target =
        share(random) < kGoalShare ? goal : Vector2d(shoulder(random), elbow(random));
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < tree.size(); ++i) {
      if ((tree[i].state - target).norm() < (tree[nearest].state - target).norm()) nearest = i;
    }
    const Vector2d from = tree[nearest].state, step = target - from;
    const bool reaches = step.norm() <= kRange_rad;
    const Vector2d to = reaches ? target : Vector2d(from + kRange_rad * step.normalized());
    if (validity.CheckMotion(from.data(), to.data())) tree.push_back({to, nearest});
  }
  if (tree.back().state != goal) return 1;

  std::vector<Vector2d> path = {goal};
  for (std::size_t i = tree.size() - 1; i != 0; i = tree[i].parent) {
    path.push_back(tree[tree[i].parent].state);
  }
  std::reverse(path.begin(), path.end());
  const Eigen::Map<const Eigen::Matrix2Xd> states(path.front().data(), 2,
                                                  static_cast<Eigen::Index>(path.size()));
  const cwm::MotionResult certificate = world.Path(cwm::RobotSubject{.robot = "arm"}, states);
  std::printf("a path of %zu states around the pillar: %s, at least %.1f mm clear\n", path.size(),
              NameOf(certificate.verdict[0]), 1e3 * certificate.clearance_m[0]);
  const cwm::MotionResult straight = world.Motions(cwm::RobotSubject{.robot = "arm"}, start, goal);
  std::printf("straight: %s of %s with %s\n", NameOf(straight.verdict[0]),
              straight.pair(0).body_link.c_str(), straight.pair(0).object.c_str());
} catch (const cwm::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
