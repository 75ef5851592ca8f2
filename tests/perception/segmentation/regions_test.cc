// Objects on a support: their footprint, their foot and the empty space below them.
#include "perception/segmentation/regions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include "perception/cloud/downsample.h"

namespace cwm::perception {
namespace {

constexpr double kStep_m = 0.004;
constexpr float kCell_m = 1.25f * kStep_m;    // wider than a step, so that no cell stays empty
constexpr float kPitch_rad = 1.5f * kStep_m;  // of the sight map: the nearest points are 0.9 m away
constexpr double kTop_m = -0.8;               // of the table, below the sensor at the origin
const Vector3 kCorner(0.6, -0.3, kTop_m);
const Vector2 kSize_m(0.6, 0.6);

// An upright screen across the view, in its middle. Points behind it and below its shadow's edge
// are not seen.
struct Screen {
  double distance_m, half_width_m, height_m;  // the distance from the table's corner

  bool Hides(const Vector3& p) const {
    const double at_m = kCorner.x() + distance_m, scale = at_m / p.x();
    return p.x() > at_m && std::abs(scale * p.y()) < half_width_m &&
           scale * p.z() < kTop_m + height_m;
  }
};

// A table and one object above it.
class TableScene {
 public:
  explicit TableScene(std::optional<Screen> screen = std::nullopt) : screen_(screen) {
    for (double x = 0.5 * kStep_m; x < kSize_m.x(); x += kStep_m) {
      for (double y = 0.5 * kStep_m; y < kSize_m.y(); y += kStep_m) {
        Put(kCorner + Vector3(x, y, 0), Vector3::UnitZ(), 0);
      }
    }
    if (!screen) return;
    for (double y = -screen->half_width_m; y < screen->half_width_m; y += kStep_m) {
      for (double z = 0.5 * kStep_m; z < screen->height_m; z += kStep_m) {
        Put({kCorner.x() + screen->distance_m, y, kTop_m + z}, -Vector3::UnitX(), 2);
      }
    }
  }

  // Adds the front and the top of a box; its low front corner is measured from the table's corner.
  TableScene& AddBox(const Vector3& corner_m, const Vector3& size_m) {
    const Vector3 low = kCorner + corner_m;
    for (double y = 0.5 * kStep_m; y < size_m.y(); y += kStep_m) {
      for (double z = 0.5 * kStep_m; z < size_m.z(); z += kStep_m) {
        Put(low + Vector3(0, y, z), -Vector3::UnitX(), 1);
      }
      for (double x = 0.5 * kStep_m; x < size_m.x(); x += kStep_m) {
        Put(low + Vector3(x, y, size_m.z()), Vector3::UnitZ(), 1);
      }
    }
    return *this;
  }

  // Adds the part of a ball that is seen from above: everything higher than `from_rad` above its
  // equator. The ball touches the table or hangs `hangs_m` above it.
  TableScene& AddBall(const Vector2& at_m, double radius_m, double from_rad, double hangs_m) {
    const Vector3 middle = kCorner + Vector3(at_m.x(), at_m.y(), radius_m + hangs_m);
    for (double up_rad = from_rad; up_rad < 0.5 * std::numbers::pi; up_rad += kStep_m / radius_m) {
      const double step_rad = kStep_m / (radius_m * std::cos(up_rad));
      for (double turn_rad = 0; turn_rad < 2 * std::numbers::pi; turn_rad += step_rad) {
        const Vector3 out(std::cos(up_rad) * std::cos(turn_rad),
                          std::cos(up_rad) * std::sin(turn_rad), std::sin(up_rad));
        Put(middle + radius_m * out, out, 1);
      }
    }
    return *this;
  }

  // Adds points that belong to no piece, apart from everything else.
  TableScene& AddStray(int count) {
    for (int i = 0; i < count; ++i) {
      const int column = i % 5, row = i / 5 % 5, layer = i / 25;
      Put(kCorner + Vector3(0.1 * column, 0.1 * row, 0.4 + 0.1 * layer), Vector3::UnitZ(),
          kNoIndex);
    }
    return *this;
  }

  Regions Form() const {
    const VoxelGrid grid = VoxelGrid::Build(points_.points, kCell_m);
    const OrientedPoints nodes = Downsample(points_, grid, kSerialWork);
    const SurfaceGraph graph = SurfaceGraph::OfGrid(nodes, grid, kSerialWork);
    const CoarseCloud coarse = MakeCoarseCloud(graph.nodes());
    Pieces pieces{.of_node = {}, .support_count = 1, .piece_count = 3, .patch_of = {}};
    for (std::size_t c = 0; c < grid.size(); ++c) {
      pieces.of_node.push_back(piece_of_point_[grid.PointsOf(c)[0]]);
    }
    SupportPlane support;
    support.plane = {Vector3::UnitZ(), kTop_m};
    for (std::uint32_t c = 0; c < coarse.cells.size(); ++c) {
      if (std::abs(coarse.cells.points[c].z() - kTop_m) < 0.001) support.cells.push_back(c);
    }
    Placed<Plate> plate;
    plate.X_FS = MakeTranslation(kCorner.x(), kCorner.y(), kTop_m);
    plate.shape.outline = {{0, 0}, {kSize_m.x(), 0}, kSize_m, {0, kSize_m.y()}};
    plate.shape.thickness_m = 0.02;
    return FormRegions(graph, coarse, pieces, {support}, {plate},
                       SightMap(graph.nodes(), kPitch_rad));
  }

  // The support of the only segment; -2 if there is none.
  std::int32_t SupportOfTheBox() const {
    const Regions regions = Form();
    EXPECT_EQ(regions.segments.size(), 1u);
    return regions.segments.empty() ? -2 : regions.segments[0].supported_by;
  }

 private:
  void Put(const Vector3& p, const Vector3& n, std::int32_t piece) {
    if (screen_ && screen_->Hides(p)) return;
    points_.points.push_back(p.cast<float>());
    points_.normals.push_back(n.cast<float>());
    points_.sigma_m.push_back(0.0015f);
    points_.normal_sigma_rad.push_back(0.02f);
    points_.cloud_index.push_back(static_cast<std::uint32_t>(piece_of_point_.size()));
    piece_of_point_.push_back(piece);
  }

  std::optional<Screen> screen_;
  OrientedPoints points_;
  std::vector<std::int32_t> piece_of_point_;
};

const Vector3 kBox_m(0.1, 0.1, 0.1);

TEST(FormRegions, ABoxOnTheTableStandsOnIt) {
  EXPECT_EQ(TableScene().AddBox({0.2, 0.2, 0.004}, kBox_m).SupportOfTheBox(), 0);
}

TEST(FormRegions, ABoxThatTheTableIsSeenBelowHangsInTheAir) {
  EXPECT_EQ(TableScene().AddBox({0.2, 0.2, 0.15}, kBox_m).SupportOfTheBox(), -1);
}

TEST(FormRegions, ABoxStandsWhereMostOfItIsOverTheTable) {
  // 3 cm beyond the border still count as the table: 58 and 38 of 100 mm lie within that.
  EXPECT_EQ(TableScene().AddBox({0.2, 0.572, 0.004}, kBox_m).SupportOfTheBox(), 0);
  EXPECT_EQ(TableScene().AddBox({0.2, 0.592, 0.004}, kBox_m).SupportOfTheBox(), -1);
}

TEST(FormRegions, AFootprintOfOneLeafIsTooSmallAndOneOfTwoIsNot) {
  // The footprints lie in one leaf of 1 cm of the table and in two leaves (kMinObjectArea_m2).
  EXPECT_EQ(TableScene().AddBox({0.201, 0.201, 0.004}, {0.008, 0.008, 0.1}).SupportOfTheBox(), -1);
  EXPECT_EQ(TableScene().AddBox({0.201, 0.201, 0.004}, {0.008, 0.018, 0.1}).SupportOfTheBox(), 0);
}

TEST(FormRegions, ABoxInTheShadowOfAnotherObjectStandsOnTheTable) {
  // Only the box's upper half is seen, and no table beside it: the shadow reaches beyond the
  // border.
  const Regions regions =
      TableScene(Screen{.distance_m = 0.2, .half_width_m = 0.2, .height_m = 0.3})
          .AddBox({0.4, 0.25, 0.004}, {0.1, 0.1, 0.28})
          .Form();
  ASSERT_EQ(regions.segments.size(), 2u);
  for (const Segment& segment : regions.segments) EXPECT_EQ(segment.supported_by, 0);
}

TEST(FormRegions, ABallOfWhichNoFootIsSeenStandsWhereItTouches) {
  constexpr double kRadius_m = 0.058, kFrom_rad = 0.35;
  EXPECT_EQ(TableScene().AddBall({0.3, 0.3}, kRadius_m, kFrom_rad, 0).SupportOfTheBox(), 0);
  EXPECT_EQ(TableScene().AddBall({0.3, 0.3}, kRadius_m, kFrom_rad, 0.05).SupportOfTheBox(), -1);
}

TEST(FormRegions, AnObjectThatReachesOutOfTheViewStandsOnTheTableUnlessItIsSeenBelow) {
  // 5 of 20 cm are above the visible part of the table. Nothing is measured where the foot and the
  // rest are.
  EXPECT_EQ(TableScene().AddBox({-0.15, 0.2, 0.1}, {0.2, 0.2, 0.2}).SupportOfTheBox(), 0);
  EXPECT_EQ(TableScene().AddBox({-0.15, 0.2, -0.4}, {0.2, 0.2, 0.6}).SupportOfTheBox(), -1);
}

TEST(FormRegions, EveryNodeIsOfASupportAnObjectOrRejected) {
  const Regions regions = TableScene().AddBox({0.2, 0.2, 0.004}, kBox_m).AddStray(20).Form();
  ASSERT_EQ(regions.segments.size(), 1u);  // 20 of 23 000 points: less than 0.5 %
  EXPECT_EQ(regions.rejected.size(), 20u);
}

TEST(FormRegions, KeepsStrayPointsBeyondHalfAPercentAsResiduals) {
  const Regions regions = TableScene().AddBox({0.2, 0.2, 0.004}, kBox_m).AddStray(200).Form();
  std::size_t kept = 0, all = 0;
  for (const Segment& segment : regions.segments) {
    all += segment.nodes.size();
    if (segment.supported_by < 0) kept += segment.nodes.size();
  }
  EXPECT_EQ(kept + regions.rejected.size(), 200u);
  EXPECT_GT(all - kept, 700u);  // the box: two faces of 20 x 20 cells
  EXPECT_GT(regions.rejected.size(), 100u);
  EXPECT_LT(regions.rejected.size(), 130u);  // 0.5 % of 24 000
}

}  // namespace
}  // namespace cwm::perception
