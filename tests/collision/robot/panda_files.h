// The Franka Panda from MotionBenchMaker, which is not in the repository.
#pragma once

#include <optional>
#include <string>

#include "collision/robot/urdf.h"

namespace cwm::collision::testing {

struct PandaFiles {
  std::string urdf;
  std::string srdf;
  std::string spherized_urdf;
  MeshSource meshes;
};

// Empty if motion_bench_maker is not in CWM_DATA.
std::optional<PandaFiles> ReadPandaFiles();

}  // namespace cwm::collision::testing
