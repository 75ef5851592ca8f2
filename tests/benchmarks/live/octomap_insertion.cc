#include "tests/benchmarks/live/octomap_insertion.h"

#include <octomap/OcTree.h>
#include <octomap/Pointcloud.h>

#include <ctime>

namespace cwm::benchmarks {
namespace {

double ThreadTime_ms() {
  timespec time = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

}  // namespace

struct OctoMapInsertion::Map {
  octomap::OcTree tree;
};

OctoMapInsertion::OctoMapInsertion(double voxel_m)
    : map_(std::make_unique<Map>(Map{.tree = octomap::OcTree(voxel_m)})) {}
OctoMapInsertion::~OctoMapInsertion() = default;

double OctoMapInsertion::Insert_ms(std::span<const Eigen::Vector3f> points_W,
                                   const Vector3& origin_W) {
  octomap::Pointcloud cloud;
  cloud.reserve(points_W.size());
  for (const Eigen::Vector3f& p_W : points_W) cloud.push_back(p_W.x(), p_W.y(), p_W.z());
  const Eigen::Vector3f origin = origin_W.cast<float>();
  const double before_ms = ThreadTime_ms();
  // One ray to each voxel with returns, which takes a fifth of the time of one to each return.
  map_->tree.insertPointCloud(cloud, octomap::point3d(origin.x(), origin.y(), origin.z()),
                              /*maxrange=*/-1, /*lazy_eval=*/false, /*discretize=*/true);
  return ThreadTime_ms() - before_ms;
}

}  // namespace cwm::benchmarks
