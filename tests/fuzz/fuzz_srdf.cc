#include "collision/robot/robot_model.h"
#include "collision/robot/srdf.h"
#include "collision/robot/urdf.h"
#include "tests/fuzz/fuzz_target.h"

using namespace cwm::collision;

namespace {

constexpr char kUrdf[] = R"(<robot name="arm">
<link name="base"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<link name="upper"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<link name="fore"/><link name="left"/><link name="free"/>
<joint name="elbow" type="revolute"><parent link="base"/><child link="upper"/><limit lower="-1" upper="1"/></joint>
<joint name="slide" type="prismatic"><parent link="upper"/><child link="fore"/><limit upper="0.5"/></joint>
<joint name="grip" type="prismatic"><parent link="fore"/><child link="left"/><limit upper="0.1"/>
<mimic joint="slide" multiplier="-1"/></joint>
<joint name="float" type="floating"><parent link="base"/><child link="free"/></joint>
</robot>)";

}  // namespace

void cwm::fuzz::TestBytes(std::string_view bytes) {
  static const RobotDescription robot = *ReadUrdf(kUrdf, nullptr);
  const auto semantic = ReadSrdf(bytes, robot);
  if (!semantic.ok()) return;
  const auto model = MakeRobotModel(robot, &*semantic);
  Check(model.ok() || !model.status().message().empty(), "a refusal must have a message");
}
