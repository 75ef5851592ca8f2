// The parts of a scene that belong to a wall: they lie on its plane and are connected behind what
// hides the wall.
#include "perception/segmentation/structures.h"

#include <gtest/gtest.h>

#include "perception/cloud/downsample.h"

namespace cwm::perception {
namespace {

constexpr double kStep_m = 0.02;
constexpr float kCell_m = 1.25f * kStep_m;    // wider than a step, so that no cell stays empty
constexpr float kPitch_rad = 2 * kStep_m;     // of the sight map: the nearest points are 1 m away
constexpr double kWall_m = 2, kBehind_m = 4;  // in front of the sensor, which looks along x
constexpr double kHalfHeight_m = 0.2;         // 20 cm of it are less than a wall's minimum

// Upright rectangles that face the sensor, each a piece; a nearer one hides those behind it. They
// are added in the order of their distance, the nearest first.
class Rectangles {
 public:
  // Adds a rectangle from y = `from_m` to `to_m`, kHalfHeight_m up and down.
  std::int32_t Add(double at_m, double from_m, double to_m) {
    for (double y = from_m + 0.5 * kStep_m; y < to_m; y += kStep_m) {
      for (double z = -kHalfHeight_m + 0.5 * kStep_m; z < kHalfHeight_m; z += kStep_m) {
        if (!IsHidden({at_m, y, z})) Put({at_m, y, z});
      }
    }
    seen_.push_back({at_m, from_m, to_m});
    return pieces_.piece_count++;
  }

  Structures Find() const {
    const VoxelGrid grid = VoxelGrid::Build(points_.points, kCell_m);
    const OrientedPoints nodes = Downsample(points_, grid, kSerialWork);
    const SurfaceGraph graph = SurfaceGraph::OfGrid(nodes, grid, kSerialWork);
    Pieces pieces = pieces_;
    for (std::size_t c = 0; c < grid.size(); ++c) {
      pieces.of_node.push_back(piece_of_point_[grid.PointsOf(c)[0]]);
    }
    return FindStructures(graph, pieces, SightMap(nodes, kPitch_rad));
  }

 private:
  struct Seen {
    double at_m, from_m, to_m;
  };

  bool IsHidden(const Vector3& p) const {
    for (const Seen& nearer : seen_) {
      const Vector3 there = nearer.at_m / p.x() * p;
      if (there.y() > nearer.from_m && there.y() < nearer.to_m &&
          std::abs(there.z()) < kHalfHeight_m) {
        return true;
      }
    }
    return false;
  }

  void Put(const Vector3& p) {
    points_.points.push_back(p.cast<float>());
    points_.normals.push_back(-Eigen::Vector3f::UnitX());
    points_.sigma_m.push_back(0.0015f);
    points_.normal_sigma_rad.push_back(0.02f);
    points_.cloud_index.push_back(static_cast<std::uint32_t>(piece_of_point_.size()));
    piece_of_point_.push_back(pieces_.piece_count);
  }

  OrientedPoints points_;
  std::vector<std::int32_t> piece_of_point_;
  Pieces pieces_;
  std::vector<Seen> seen_;
};

TEST(FindStructures, AWallGoesOnBehindWhatHidesItsMiddle) {
  Rectangles scene;
  const std::int32_t pole = scene.Add(1, 0.2, 0.4);
  const auto left = static_cast<std::size_t>(scene.Add(kWall_m, -1, 0.5));
  const auto right = static_cast<std::size_t>(scene.Add(kWall_m, 0.7, 0.9));
  scene.Add(kBehind_m, -4, 4);
  const Structures found = scene.Find();
  ASSERT_NE(found.of_piece[left], kNoIndex);
  EXPECT_EQ(found.of_piece[right], found.of_piece[left]);
  EXPECT_NE(found.of_piece[static_cast<std::size_t>(pole)], found.of_piece[left]);
}

TEST(FindStructures, AFrontInTheWallsPlaneThatOneSeesPastIsNoneOfIt) {
  Rectangles scene;
  const auto wall = static_cast<std::size_t>(scene.Add(kWall_m, -1, 0.5));
  const auto box = static_cast<std::size_t>(scene.Add(kWall_m, 0.8, 1));
  scene.Add(kBehind_m, -4, 4);
  const Structures found = scene.Find();
  ASSERT_NE(found.of_piece[wall], kNoIndex);
  EXPECT_EQ(found.of_piece[box], kNoIndex);
}

}  // namespace
}  // namespace cwm::perception
