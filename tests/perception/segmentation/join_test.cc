// Pieces of one object are joined: pieces made by hand, seen from the origin of the level frame.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "perception/cloud/downsample.h"
#include "perception/cloud/tolerances.h"
#include "perception/segmentation/join_hidden.h"
#include "perception/segmentation/join_pieces.h"
#include "perception/segmentation/join_vessels.h"

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

constexpr double kStep_m = 0.004;  // between points, and the edge of the square each stands for
constexpr float kCell_m = 1.25f * kStep_m;    // wider than a step, so that no cell stays empty
constexpr float kPitch_rad = 1.5f * kStep_m;  // of the sight map: the nearest points are 0.8 m away
constexpr float kSigma_m = 0.0015f;

// A surface parametrised by u and v in [0, 1], sampled in steps of `kStep_m` along sides of these
// lengths.
struct Patch {
  double length_u_m, length_v_m;
  std::function<Vector3(double, double)> point, normal;
};

// The vertical rectangle x = `x_m`, facing the sensor.
Patch Face(double x_m, const Vector2& y_m, const Vector2& z_m) {
  return {y_m.y() - y_m.x(), z_m.y() - z_m.x(),
          [=](double u, double v) {
            return Vector3(x_m, y_m.x() + u * (y_m.y() - y_m.x()),
                           z_m.x() + v * (z_m.y() - z_m.x()));
          },
          [](double, double) { return Vector3(-Vector3::UnitX()); }};
}

// The level rectangle z = `z_m`, facing up.
Patch Top(double z_m, const Vector2& x_m, const Vector2& y_m) {
  return {x_m.y() - x_m.x(), y_m.y() - y_m.x(),
          [=](double u, double v) {
            return Vector3(x_m.x() + u * (x_m.y() - x_m.x()), y_m.x() + v * (y_m.y() - y_m.x()),
                           z_m);
          },
          [](double, double) { return Vector3(Vector3::UnitZ()); }};
}

// An upright wall around (1, 0). Angles are in degrees from the direction to the sensor; `outward`
// is 1 for an outside and -1 for an inside.
Patch Wall(double radius_m, const Vector2& angle_deg, const Vector2& z_m, double outward) {
  const auto direction = [=](double u) {
    const double angle = (angle_deg.x() + u * (angle_deg.y() - angle_deg.x())) * kDegree;
    return Vector3(-std::cos(angle), std::sin(angle), 0);
  };
  return {
      radius_m * (angle_deg.y() - angle_deg.x()) * kDegree, z_m.y() - z_m.x(),
      [=](double u, double v) {
        return Vector3(Vector3(1, 0, z_m.x() + v * (z_m.y() - z_m.x())) + radius_m * direction(u));
      },
      [=](double u, double) { return Vector3(outward * direction(u)); }};
}

Patch Disc(double radius_m, double z_m) {
  return {2 * radius_m, 2 * radius_m,
          [=](double u, double v) {
            // Squares mapped to discs; an even spread does not need more.
            const double a = 2 * u - 1, b = 2 * v - 1;
            return Vector3(1 + radius_m * a * std::sqrt(1 - b * b / 2),
                           radius_m * b * std::sqrt(1 - a * a / 2), z_m);
          },
          [](double, double) { return Vector3(Vector3::UnitZ()); }};
}

class Seen {
 public:
  // Adds a piece and returns its number. Joining looks at no more than kMaxSamples points of each
  // piece.
  std::size_t Add(const Patch& patch) {
    PieceSummary piece;
    const int columns = static_cast<int>(patch.length_u_m / kStep_m);
    const int rows = static_cast<int>(patch.length_v_m / kStep_m);
    for (int i = 0; i < columns; ++i) {
      for (int j = 0; j < rows; ++j) {
        const double u = (i + 0.5) / columns, v = (j + 0.5) / rows;
        piece.sample.push_back(AddPoint(patch.point(u, v), patch.normal(u, v)));
        piece.bounds.extend(patch.point(u, v));
        piece.area_m2 += kStep_m * kStep_m;
      }
    }
    piece.node_count = piece.sample.size();
    const std::size_t stride = (piece.sample.size() + kMaxSamples - 1) / kMaxSamples;
    std::vector<std::uint32_t> thinned;
    for (std::size_t k = 0; k < piece.sample.size(); k += stride) {
      thinned.push_back(piece.sample[k]);
    }
    piece.sample = thinned;
    piece.low_z_m = piece.bounds.min().z();
    piece.high_z_m = piece.bounds.max().z();
    views_.pieces.push_back(std::move(piece));
    return views_.pieces.size() - 1;
  }

  // Links two pieces as along a common side of about 8 cm.
  void Touch(std::size_t a, std::size_t b) { Link(a, b, 60); }

  void Link(std::size_t a, std::size_t b, int links) {
    const auto i = static_cast<std::int32_t>(a), j = static_cast<std::int32_t>(b);
    views_.borders[{i, j}].links = views_.borders[{j, i}].links = links;
  }

  void MakePatch(std::size_t piece) { views_.pieces[piece].is_patch = true; }

  bool OccludersJoin(std::size_t a, std::size_t b) const {
    DisjointSets objects(views_.pieces.size());
    JoinAcrossOccluders(nodes_, views_, SightMap(nodes_, kPitch_rad), objects);
    return objects.Root(a) == objects.Root(b);
  }

  bool VesselsJoin(std::size_t a, std::size_t b) const {
    DisjointSets objects(views_.pieces.size());
    JoinVessels(nodes_, views_, objects);
    return objects.Root(a) == objects.Root(b);
  }

 private:
  std::uint32_t AddPoint(const Vector3& p, const Vector3& n) {
    nodes_.points.push_back(p.cast<float>());
    nodes_.normals.push_back(n.cast<float>());
    nodes_.sigma_m.push_back(kSigma_m);
    return static_cast<std::uint32_t>(nodes_.size() - 1);
  }

  OrientedPoints nodes_;
  PieceSummaries views_;
};

const Vector2 kHeights(-0.6, -0.5);
const Vector2 kLeft(-0.15, -0.04), kRight(0.04, 0.15);

TEST(JoinAcrossOccluders, JoinsPartsOfOneFaceBehindAPole) {
  Seen seen;
  const std::size_t left = seen.Add(Face(1, kLeft, kHeights));
  const std::size_t right = seen.Add(Face(1, kRight, kHeights));
  const std::size_t pole = seen.Add(Face(0.7, {-0.03, 0.03}, {-0.5, -0.3}));
  EXPECT_TRUE(seen.OccludersJoin(left, right));
  EXPECT_FALSE(seen.OccludersJoin(left, pole));
}

TEST(JoinAcrossOccluders, JoinsNoPatchOfASupportWithWhatLiesOnItsPlane) {
  Seen seen;
  const std::size_t floor = seen.Add(Face(1, kLeft, kHeights));
  const std::size_t patch = seen.Add(Face(1, kRight, kHeights));
  seen.Add(Face(0.7, {-0.03, 0.03}, {-0.5, -0.3}));
  seen.MakePatch(patch);
  EXPECT_FALSE(seen.OccludersJoin(floor, patch));
}

TEST(JoinAcrossOccluders, KeepsFacesApartThatTheWallBehindIsSeenBetween) {
  Seen seen;
  const std::size_t left = seen.Add(Face(1, kLeft, kHeights));
  const std::size_t right = seen.Add(Face(1, kRight, kHeights));
  seen.Add(Face(1.5, {-0.3, 0.3}, {-1, -0.6}));
  EXPECT_FALSE(seen.OccludersJoin(left, right));
}

TEST(JoinAcrossOccluders, KeepsFacesApartThatNoPlaneExplains) {
  for (const double step_m : {0.0, 0.01}) {  // 1 cm is more than 6 sigma
    Seen seen;
    const std::size_t left = seen.Add(Face(1, kLeft, kHeights));
    const std::size_t right = seen.Add(Face(1 + step_m, kRight, kHeights));
    seen.Add(Face(0.7, {-0.03, 0.03}, {-0.5, -0.3}));
    EXPECT_EQ(seen.OccludersJoin(left, right), step_m == 0) << step_m;
  }
}

// As two objects, one of which stands out by one sigma: noise leaves a few links across the step.
TEST(JoinAcrossOccluders, JoinsPartsOfOneFaceThatTouchAlongTheirSidesAlone) {
  for (const int links : {4, 60}) {
    Seen seen;
    const std::size_t left = seen.Add(Face(1, {-0.1, 0}, kHeights));
    const std::size_t right = seen.Add(Face(1 + kSigma_m, {0, 0.1}, kHeights));
    seen.Link(left, right, links);
    EXPECT_EQ(seen.OccludersJoin(left, right), links == 60) << links;
  }
}

TEST(JoinAcrossOccluders, KeepsFacesApartThatAreFartherThanObjectsAreLarge) {
  for (const double gap_m : {0.3, 0.4}) {
    Seen seen;
    const std::size_t left = seen.Add(Face(1, {-0.5 * gap_m - 0.05, -0.5 * gap_m}, kHeights));
    const std::size_t right = seen.Add(Face(1, {0.5 * gap_m, 0.5 * gap_m + 0.05}, kHeights));
    seen.Add(Face(0.7, {-0.45 * gap_m, 0.45 * gap_m}, {-0.5, -0.3}));
    EXPECT_EQ(seen.OccludersJoin(left, right), gap_m < 0.35) << gap_m;
  }
}

// Boxes of one height: of low boxes, mostly the tops are seen.
TEST(JoinAcrossOccluders, KeepsLevelTopsApartThatTogetherAreLongerThanObjectsAre) {
  for (const double length_m : {0.15, 0.25}) {
    Seen seen;
    const std::size_t left = seen.Add(Top(-0.6, {0.9, 1}, {-0.04 - length_m, -0.04}));
    const std::size_t right = seen.Add(Top(-0.6, {0.9, 1}, {0.04, 0.04 + length_m}));
    seen.Add(Face(0.7, {-0.03, 0.03}, {-0.6, -0.3}));
    EXPECT_EQ(seen.OccludersJoin(left, right), length_m < 0.2) << length_m;
  }
}

// Boxes in a row.
TEST(JoinAcrossOccluders, KeepsFrontsApartThatTogetherAreLongerThanObjectsAre) {
  for (const double length_m : {0.15, 0.25}) {
    Seen seen;
    const std::size_t left = seen.Add(Face(1, {-0.04 - length_m, -0.04}, kHeights));
    const std::size_t right = seen.Add(Face(1, {0.04, 0.04 + length_m}, kHeights));
    seen.Add(Face(0.7, {-0.03, 0.03}, {-0.5, -0.3}));
    EXPECT_EQ(seen.OccludersJoin(left, right), length_m < 0.2) << length_m;
  }
}

TEST(JoinAcrossOccluders, JoinsPartsOfOneCanBehindAPole) {
  Seen seen;
  const std::size_t left = seen.Add(Wall(0.05, {-75, -20}, kHeights, 1));
  const std::size_t right = seen.Add(Wall(0.05, {20, 75}, kHeights, 1));
  seen.Add(Face(0.7, {-0.012, 0.012}, {-0.5, -0.3}));
  EXPECT_TRUE(seen.OccludersJoin(left, right));
}

TEST(JoinAcrossOccluders, KeepsCansOfDifferentRadiusApart) {
  Seen seen;
  const std::size_t left = seen.Add(Wall(0.05, {-75, -20}, kHeights, 1));
  const std::size_t right = seen.Add(Wall(0.08, {20, 75}, kHeights, 1));
  seen.Add(Face(0.7, {-0.012, 0.012}, {-0.5, -0.3}));
  EXPECT_FALSE(seen.OccludersJoin(left, right));
}

// A cup of 4 cm radius: its outside in front, its inside behind, its floor in between.
TEST(JoinVessels, JoinsTheWallsAndTheFloorOfACup) {
  Seen seen;
  const std::size_t outside = seen.Add(Wall(0.04, {-80, 80}, kHeights, 1));
  const std::size_t inside = seen.Add(Wall(0.037, {110, 250}, {-0.58, -0.5}, -1));
  const std::size_t floor = seen.Add(Disc(0.03, -0.59));
  const std::size_t beside = seen.Add(Face(1, {0.06, 0.12}, kHeights));
  EXPECT_TRUE(seen.VesselsJoin(outside, inside));
  EXPECT_TRUE(seen.VesselsJoin(outside, floor));
  EXPECT_FALSE(seen.VesselsJoin(outside, beside));
}

TEST(JoinVessels, LeavesWhatRisesOverTheRimToItself) {
  Seen seen;
  const std::size_t outside = seen.Add(Wall(0.04, {-80, 80}, kHeights, 1));
  seen.Add(Wall(0.037, {110, 250}, {-0.58, -0.5}, -1));
  const std::size_t spoon = seen.Add(Face(1, {-0.01, 0.01}, {-0.55, -0.4}));
  EXPECT_FALSE(seen.VesselsJoin(outside, spoon));
}

TEST(JoinVessels, LeavesTheLidOfACanThatShowsNoInsideToItself) {
  Seen seen;
  const std::size_t outside = seen.Add(Wall(0.04, {-80, 80}, kHeights, 1));
  const std::size_t lid = seen.Add(Disc(0.04, -0.5));
  EXPECT_FALSE(seen.VesselsJoin(outside, lid));
}

TEST(JoinVessels, JoinsOutsidesOfOneAxisOnlyWhereTheyTouch) {
  for (const bool touch : {false, true}) {
    Seen seen;
    const std::size_t below = seen.Add(Wall(0.04, {-80, 80}, {-0.6, -0.52}, 1));
    const std::size_t above = seen.Add(Wall(0.04, {-80, 80}, {-0.5, -0.42}, 1));
    if (touch) seen.Touch(below, above);
    EXPECT_EQ(seen.VesselsJoin(below, above), touch);
  }
}

// A support and pieces as cells of a grid, which JoinPieces needs for the borders between pieces.
class Cells {
 public:
  static constexpr std::int32_t kSupport = 0;

  // Adds a piece and returns its number; the first one is the support.
  std::int32_t Add(const Patch& patch) {
    const int columns = static_cast<int>(std::round(patch.length_u_m / kStep_m));
    const int rows = static_cast<int>(std::round(patch.length_v_m / kStep_m));
    for (int i = 0; i < columns; ++i) {
      for (int j = 0; j < rows; ++j) {
        const double u = (i + 0.5) / columns, v = (j + 0.5) / rows;
        points_.points.push_back(patch.point(u, v).cast<float>());
        points_.normals.push_back(patch.normal(u, v).cast<float>());
        points_.sigma_m.push_back(kSigma_m);
        points_.normal_sigma_rad.push_back(0.02f);
        points_.cloud_index.push_back(static_cast<std::uint32_t>(piece_of_point_.size()));
        piece_of_point_.push_back(count_);
      }
    }
    return count_++;
  }
  // Declares the piece a patch of the support.
  void IsPatch(std::int32_t piece) { patch_of_[piece] = kSupport; }

  // The object of each piece, in the order in which the pieces were added.
  std::vector<std::int32_t> Join(bool from_one_place = true) const {
    const VoxelGrid grid = VoxelGrid::Build(points_.points, kCell_m);
    const OrientedPoints nodes = Downsample(points_, grid, kSerialWork);
    const SurfaceGraph graph = SurfaceGraph::OfGrid(nodes, grid, kSerialWork);
    Pieces pieces;
    for (std::size_t c = 0; c < grid.size(); ++c) {
      pieces.of_node.push_back(piece_of_point_[grid.PointsOf(c)[0]]);
    }
    pieces.support_count = 1;
    pieces.piece_count = count_;
    pieces.patch_of = patch_of_;
    const SightMap sight(graph.nodes(), kPitch_rad);
    const Pieces joined = JoinPieces(graph, pieces, from_one_place ? &sight : nullptr);
    std::vector<std::int32_t> object_of(static_cast<std::size_t>(count_), -1);
    for (std::size_t c = 0; c < grid.size(); ++c) {
      object_of[static_cast<std::size_t>(pieces.of_node[c])] = joined.of_node[c];
    }
    return object_of;
  }

 private:
  OrientedPoints points_;
  std::vector<std::int32_t> piece_of_point_;
  std::map<std::int32_t, std::int32_t> patch_of_;
  std::int32_t count_ = 0;
};

// The front of a box of 12 cm, 8 cm above a support that does not touch it.
Cells BoxOverSupport() {
  Cells cells;
  cells.Add(Top(-0.7, {0.7, 0.9}, {-0.1, 0.1}));
  cells.Add(Face(1, {-0.06, 0.06}, {-0.62, -0.5}));
  return cells;
}

TEST(JoinPieces, GivesASmallPartOnItsSideToABox) {
  Cells cells = BoxOverSupport();
  const auto knob = cells.Add(Face(0.996, {-0.02, 0.02}, {-0.58, -0.54}));
  const auto object_of = cells.Join();
  EXPECT_EQ(object_of[static_cast<std::size_t>(knob)], object_of[1]);
  EXPECT_NE(object_of[1], object_of[Cells::kSupport]);
}

TEST(JoinPieces, KeepsALargePartOnItsSideApart) {
  Cells cells = BoxOverSupport();
  const auto large = cells.Add(Face(0.996, {-0.03, 0.03}, {-0.59, -0.53}));  // a quarter of it
  const auto object_of = cells.Join();
  EXPECT_NE(object_of[static_cast<std::size_t>(large)], object_of[1]);
}

TEST(JoinPieces, LeavesASmallBoxOnTopOfALargeOneToItself) {
  Cells cells = BoxOverSupport();
  const auto top = cells.Add(Top(-0.5, {1, 1.12}, {-0.06, 0.06}));
  const auto small = cells.Add(Face(1.06, {-0.02, 0.02}, {-0.5, -0.464}));
  const auto object_of = cells.Join();
  EXPECT_NE(object_of[static_cast<std::size_t>(small)], object_of[static_cast<std::size_t>(top)]);
  EXPECT_NE(object_of[static_cast<std::size_t>(small)], object_of[1]);
}

// Rays of merged views do not tell what is hidden.
TEST(JoinPieces, JoinsAcrossAnOccluderOnlyWhatWasSeenFromOnePlace) {
  for (const bool from_one_place : {true, false}) {
    Cells cells;
    cells.Add(Top(-0.7, {0.7, 0.9}, {-0.1, 0.1}));
    const auto left = static_cast<std::size_t>(cells.Add(Face(1, kLeft, kHeights)));
    const auto right = static_cast<std::size_t>(cells.Add(Face(1, kRight, kHeights)));
    cells.Add(Face(0.7, {-0.03, 0.03}, {-0.5, -0.3}));
    const auto object_of = cells.Join(from_one_place);
    EXPECT_EQ(object_of[left] == object_of[right], from_one_place);
  }
}

TEST(JoinPieces, GivesAScrapToItsLongestBorder) {
  Cells cells = BoxOverSupport();
  const auto scrap = cells.Add(Top(-0.5, {1, 1.012}, {-0.006, 0.006}));
  const auto object_of = cells.Join();
  EXPECT_EQ(object_of[static_cast<std::size_t>(scrap)], object_of[1]);
}

TEST(JoinPieces, GivesPatchesThatNothingClaimsBackToTheirSupport) {
  for (const bool is_patch : {false, true}) {
    Cells cells = BoxOverSupport();
    const auto patch = cells.Add(Top(-0.7, {0.96, 1.08}, {-0.1, 0.1}));
    if (is_patch) cells.IsPatch(patch);
    const auto object_of = cells.Join();
    EXPECT_EQ(object_of[static_cast<std::size_t>(patch)] == object_of[Cells::kSupport], is_patch);
    EXPECT_NE(object_of[static_cast<std::size_t>(patch)], object_of[1]);
  }
}

}  // namespace
}  // namespace cwm::perception
