// Measures how far a gripper is from a cup and the table, on its way down to the cup.
#include <cwm/client.h>

#include <cstdio>
#include <vector>

using Eigen::Isometry3d;
using Eigen::Translation3d;

int main() try {
  const cwm::World world = cwm::Connect({.world = "distances_of_a_gripper"});
  world.Apply({cwm::Put{.name = "table",
                        .body = cwm::Box{0.8, 1.2, 0.04},
                        .X_WO = Isometry3d(Translation3d(0.5, 0, -0.02))},
               cwm::Put{.name = "cup",
                        .body = cwm::Cylinder{0.04, 0.10},
                        .X_WO = Isometry3d(Translation3d(0.5, 0, 0.05))}});

  // A palm and two fingers of 6 cm that hang down from the origin of the gripper.
  const cwm::Body gripper = {
      {cwm::Box{0.20, 0.06, 0.06}, Isometry3d(Translation3d(0, 0, 0.03))},
      {cwm::Box{0.01, 0.02, 0.06}, Isometry3d(Translation3d(-0.055, 0, -0.03))},
      {cwm::Box{0.01, 0.02, 0.06}, Isometry3d(Translation3d(0.055, 0, -0.03))}};
  std::vector<Isometry3d> poses;
  for (const double z_m : {0.30, 0.20, 0.15, 0.09}) {
    poses.push_back(Isometry3d(Translation3d(0.5, 0, z_m)));
  }

  const cwm::PairResult answer = world.Distance(gripper, poses, {.max_results = 2});
  for (std::size_t row = 0; row < poses.size(); ++row) {
    std::printf("z = %.2f m:", poses[row].translation().z());
    for (Eigen::Index i = answer.row_begin[row]; i < answer.row_begin[row + 1]; ++i) {
      std::printf("  %s %.1f mm", answer.pair(i).object.c_str(), 1e3 * answer.distance_m[i]);
    }
    std::printf("\n");
  }
} catch (const cwm::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
