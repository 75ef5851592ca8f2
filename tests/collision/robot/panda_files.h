// The Franka Panda of MotionBenchMaker, which the repository does not hold.
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

// Nothing where motion_bench_maker is not in CWM_DATA.
std::optional<PandaFiles> ReadPandaFiles();

}  // namespace cwm::collision::testing
