// Checks whether an arm can carry a tray before anybody grasps it: nothing of the world changes.
#include <cwm/client.h>

#include <cstdio>
#include <numbers>

using Eigen::Isometry3d;
using Eigen::Translation3d;

constexpr char kUrdf[] = R"(<robot name="arm">
  <link name="base"/>
  <link name="hand"><collision><origin xyz="0.5 0 0"/>
    <geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="hand"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3"/></joint>
</robot>)";

int main() try {
  const cwm::World world = cwm::Connect({.world = "what_if"});
  world.LoadRobot({.urdf = kUrdf});
  world.Put("tray", cwm::Box{0.3, 0.3, 0.02}, Isometry3d(Translation3d(0.8, 0, 0)));
  world.Put("post", cwm::Cylinder{0.05, 1.0}, Isometry3d(Translation3d(0, 0.9, 0)));

  const cwm::RobotSubject arm{.robot = "arm"};
  const Eigen::VectorXd from = Eigen::VectorXd::Zero(1);
  const Eigen::VectorXd to = Eigen::VectorXd::Constant(1, std::numbers::pi / 2);
  const auto print = [&](const char* what, const cwm::WorldView& view) {
    const cwm::MotionResult motion = view.Motions(arm, from, to);
    std::printf("%s: %s", what, NameOf(motion.verdict[0]));
    if (!motion.free(0) && !motion.pair(0).object.empty()) {
      const cwm::NamedPairOfParts pair = motion.pair(0);
      const std::string& who = pair.body_object.empty() ? pair.body_link : pair.body_object;
      std::printf(", %s meets %s at %.0f deg", who.c_str(), pair.object.c_str(), 90 * motion.hi[0]);
    }
    std::printf("\n");
  };

  print("as it is", world);
  const cwm::Attach grasp{.name = "tray", .robot = "arm", .link = "hand"};
  print("with the tray", world.WhatIf({grasp}));
  print("and without the post", world.WhatIf({grasp, cwm::Remove{"post"}}));
  std::printf("the world is at revision %lld, and the tray is %s\n",
              static_cast<long long>(world.revision()),
              world.Get("tray").attachment ? "attached" : "free");
} catch (const cwm::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
