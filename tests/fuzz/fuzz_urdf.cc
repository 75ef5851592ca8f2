#include "collision/robot/robot_model.h"
#include "collision/robot/urdf.h"
#include "tests/fuzz/fuzz_target.h"

using namespace cwm::collision;

// Reads a robot whose meshes are all the same tetrahedron.
void cwm::fuzz::TestBytes(std::string_view bytes) {
  const MeshSource meshes = [](std::string_view) -> absl::StatusOr<std::string> {
    return "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  };
  auto robot = ReadUrdf(bytes, meshes);
  if (!robot.ok()) return;
  const auto model = MakeRobotModel(*std::move(robot), nullptr);
  Check(model.ok(), "what ReadUrdf takes must make a model");
}
