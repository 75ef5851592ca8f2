// One object above or beside a table that is seen from above its edge.
#include "perception/segmentation/support_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "perception/cloud/downsample.h"

namespace cwm::perception {
namespace {

constexpr double kFloorStep_m = 0.005;
constexpr float kFloorCell_m = 1.25f * kFloorStep_m;    // wider than a step: no cell stays empty
constexpr float kFloorPitch_rad = 1.5f * kFloorStep_m;  // of the sight map; points are 0.8 m away
constexpr double kFloorSide_m = 0.6;
const Vector3 kFloorCorner(0.6, -0.3, -0.8);  // of the table, from the sensor

// All places are measured from the table's corner.
class OverAFloor {
 public:
  OverAFloor() { AddLevel({0, 0, 0}, kFloorSide_m, kFloorSide_m, kTable); }

  // Adds an upright rectangle that faces the sensor, given its lower corner.
  OverAFloor& AddFront(const Vector3& corner_m, double width_m, double height_m) {
    return AddUpright(corner_m, width_m, height_m, kObject);
  }
  // Adds the front and the top of a box of 10 cm.
  OverAFloor& AddBox(const Vector3& corner_m) {
    AddLevel(corner_m + 0.1 * Vector3::UnitZ(), 0.1, 0.1, kObject);
    return AddFront(corner_m, 0.1, 0.1);
  }
  // Adds a screen that hides the places behind it.
  OverAFloor& AddScreen(const Vector3& corner_m, double width_m, double height_m) {
    return AddUpright(corner_m, width_m, height_m, kScreen);
  }

  bool CarriesTheObject() const {
    const VoxelGrid grid = VoxelGrid::Build(points_.points, kFloorCell_m);
    const OrientedPoints nodes = Downsample(points_, grid);
    const SurfaceGraph graph = SurfaceGraph::OfGrid(nodes, grid, {});
    const CoarseCloud coarse = MakeCoarseCloud(nodes);
    SupportPlane support;
    support.plane = {Vector3::UnitZ(), kFloorCorner.z()};
    for (std::uint32_t c = 0; c < coarse.cells.size(); ++c) {
      if (std::abs(coarse.cells.points[c].z() - kFloorCorner.z()) < 0.001) {
        support.cells.push_back(c);
      }
    }
    Placed<Plate> plate;
    plate.X_FS = MakeTranslation(kFloorCorner.x(), kFloorCorner.y(), kFloorCorner.z());
    plate.shape.outline = {
        {0, 0}, {kFloorSide_m, 0}, {kFloorSide_m, kFloorSide_m}, {0, kFloorSide_m}};
    plate.shape.thickness_m = 0.02;
    SupportSurface::NodeList object;
    for (std::uint32_t i = 0; i < nodes.size(); ++i) {
      if (label_[grid.PointsOf(i)[0]] == kObject) object.push_back(i);
    }
    EXPECT_FALSE(object.empty());
    const SightMap sight(nodes, kFloorPitch_rad);
    return SupportSurface(graph, coarse, support, plate, sight).Carries(object);
  }

 private:
  enum Label { kTable, kObject, kScreen };

  void AddLevel(const Vector3& corner_m, double depth_m, double width_m, Label label) {
    for (double x = 0.5 * kFloorStep_m; x < depth_m; x += kFloorStep_m) {
      for (double y = 0.5 * kFloorStep_m; y < width_m; y += kFloorStep_m) {
        Put(corner_m + Vector3(x, y, 0), Vector3::UnitZ(), label);
      }
    }
  }

  OverAFloor& AddUpright(const Vector3& corner_m, double width_m, double height_m, Label label) {
    for (double y = 0.5 * kFloorStep_m; y < width_m; y += kFloorStep_m) {
      for (double z = 0.5 * kFloorStep_m; z < height_m; z += kFloorStep_m) {
        Put(corner_m + Vector3(0, y, z), -Vector3::UnitX(), label);
      }
    }
    return *this;
  }

  void Put(const Vector3& place_m, const Vector3& normal, Label label) {
    points_.points.push_back((kFloorCorner + place_m).cast<float>());
    points_.normals.push_back(normal.cast<float>());
    points_.sigma_m.push_back(0.0015f);
    points_.normal_sigma_rad.push_back(0.02f);
    points_.cloud_index.push_back(static_cast<std::uint32_t>(label_.size()));
    label_.push_back(label);
  }

  OrientedPoints points_;
  std::vector<Label> label_;
};

TEST(SupportSurface, CarriesABoxUnlessOneSeesBelowIt) {
  EXPECT_TRUE(OverAFloor().AddBox({0.2, 0.25, 0.005}).CarriesTheObject());
  EXPECT_FALSE(OverAFloor().AddBox({0.2, 0.25, 0.15}).CarriesTheObject());
}

// The screen is 15 cm in front of the box. Rays past its lower and its upper edge meet the box's
// front at the table's height and 15 cm above it.
TEST(SupportSurface, CarriesWhatNobodySeesBelow) {
  EXPECT_TRUE(OverAFloor()
                  .AddBox({0.2, 0.25, 0.15})
                  .AddScreen({0.05, 0.2, 0.15}, 0.2, 0.12)
                  .CarriesTheObject());
}

// A footprint of at least two cells of 1 cm (2 cm^2) makes an object.
TEST(SupportSurface, CarriesNothingWithoutAFootprint) {
  EXPECT_FALSE(OverAFloor().AddFront({0.205, 0.3, 0}, 0.01, 0.1).CarriesTheObject());
  EXPECT_TRUE(OverAFloor().AddFront({0.205, 0.3, 0}, 0.04, 0.1).CarriesTheObject());
}

TEST(SupportSurface, CarriesNothingBelowItOrBesideIt) {
  EXPECT_FALSE(OverAFloor().AddFront({-0.02, 0.2, -0.4}, 0.2, 0.35).CarriesTheObject());
  EXPECT_FALSE(OverAFloor().AddBox({0.2, kFloorSide_m + 0.1, 0.005}).CarriesTheObject());
}

}  // namespace
}  // namespace cwm::perception
