// Images of a few faces, cut into pieces.
#include "perception/segmentation/pieces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <vector>

#include "perception/cloud/normals.h"
#include "perception/segmentation/creases.h"
#include "tests/perception/segmentation/drawn_image.h"

namespace cwm::perception {
namespace {

// A pixel is 3 mm wide at the table.
constexpr DrawnFormat kTableFormat{.width = 160, .height = 120, .focal_px = 262};
constexpr DrawnFormat kFacesFormat{.width = 100, .height = 80, .focal_px = 262};
constexpr float kTableDepth_m = 0.8f, kObjectDepth_m = 0.7f;

enum class HasTable { kNo, kYes };

// An image with estimated normals. The table, if any, is all that lies at kTableDepth_m and faces
// the sensor.
class CutImage {
 public:
  CutImage(const DrawnFormat& format, HasTable has_table,
           const std::function<float(int, int)>& depth_m)
      : measured_(DrawnImage(format, depth_m)) {
    measured_.oriented.normals.assign(measured_.oriented.size(), Eigen::Vector3f::Zero());
    EstimateImageNormals(measured_, {});
    const SurfaceGraph graph = SurfaceGraph::OfImage(measured_, {});
    const CoarseCloud coarse = MakeCoarseCloud(graph.nodes());
    std::vector<SupportPlane> supports;
    if (has_table == HasTable::kYes) {
      SupportPlane& table = supports.emplace_back();
      table.plane = {-Vector3::UnitZ(), -double{kTableDepth_m}};
      for (std::uint32_t c = 0; c < coarse.cells.size(); ++c) {
        if (std::abs(coarse.cells.points[c].z() - kTableDepth_m) < 0.001f) table.cells.push_back(c);
      }
    }
    pieces_ = CutIntoPieces(graph, FindConcaveCreases(graph, kConcave_rad, {}), coarse, supports,
                            nullptr, {});
  }

  const Pieces& pieces() const { return pieces_; }
  // The piece at a pixel; all pixels return.
  std::int32_t At(int row, int column) const {
    return pieces_.of_node[static_cast<std::size_t>(row * measured_.width + column)];
  }

 private:
  MeasuredPoints measured_;
  Pieces pieces_;
};

bool IsInSquare(int row, int column, int first, int last) {
  return row >= first && row < last && column >= first && column < last;
}

// A box 12 cm wide, and a patch of 25 pixels that is too small for a piece.
TEST(CutIntoPieces, GivesEachNodeToTheTableOrTheBoxOnItUnlessTooLittleHangsTogether) {
  const auto is_box = [](int v, int u) { return IsInSquare(v, u, 40, 80); };
  const auto is_speck = [](int v, int u) { return IsInSquare(v, u, 10, 15); };
  const CutImage cut(kTableFormat, HasTable::kYes, [&](int v, int u) {
    if (is_speck(v, u)) return 0.6f;
    return is_box(v, u) ? kObjectDepth_m : kTableDepth_m;
  });
  EXPECT_EQ(cut.pieces().support_count, 1);
  EXPECT_EQ(cut.pieces().piece_count, 2);
  EXPECT_TRUE(cut.pieces().patch_of.empty());
  for (int v = 0; v < kTableFormat.height; ++v) {
    for (int u = 0; u < kTableFormat.width; ++u) {
      const std::int32_t expected = is_speck(v, u) ? kNoIndex : is_box(v, u) ? 1 : 0;
      ASSERT_EQ(cut.At(v, u), expected) << v << " " << u;
    }
  }
}

// Two faces that rise or fall by 30 degrees from the middle column on.
TEST(CutIntoPieces, CutsFacesAlongAConcaveCreaseAndNotAlongAConvexEdge) {
  const float slope = std::tan(30 * std::numbers::pi_v<float> / 180);
  const int middle = kFacesFormat.width / 2;
  for (const bool is_concave : {false, true}) {
    const CutImage cut(kFacesFormat, HasTable::kNo, [&](int, int u) {
      const float away = static_cast<float>(std::abs(u - middle)) / kFacesFormat.focal_px;
      return 0.8f / (1 + (is_concave ? slope : -slope) * away);
    });
    ASSERT_EQ(cut.pieces().piece_count, is_concave ? 2 : 1);
    const std::int32_t left = cut.At(40, 10), right = cut.At(40, 90);
    EXPECT_EQ(left != right, is_concave);
    for (int v = 0; v < kFacesFormat.height; ++v) {
      for (int u = 0; u < kFacesFormat.width; ++u) {
        if (std::abs(u - middle) < 3) continue;  // where they meet
        ASSERT_EQ(cut.At(v, u), u < middle ? left : right) << v << " " << u;
      }
    }
  }
}

// A frame 18 cm wide; the table is seen through its opening of 9 cm.
TEST(CutIntoPieces, MakesAPatchOfWhatIsSplitFromTheRestOfItsSupport) {
  const auto is_inside = [](int v, int u) { return IsInSquare(v, u, 45, 75); };
  const CutImage cut(kTableFormat, HasTable::kYes, [&](int v, int u) {
    return IsInSquare(v, u, 30, 90) && !is_inside(v, u) ? kObjectDepth_m : kTableDepth_m;
  });
  ASSERT_EQ(cut.pieces().piece_count, 3);  // the table, the frame and the patch
  const std::int32_t patch = cut.At(60, 60);
  EXPECT_EQ(cut.pieces().patch_of, (std::map<std::int32_t, std::int32_t>{{patch, 0}}));
  for (int v = 45; v < 75; ++v) {
    for (int u = 45; u < 75; ++u) ASSERT_EQ(cut.At(v, u), patch) << v << " " << u;
  }
  EXPECT_EQ(cut.At(60, 20), 0);
  EXPECT_NE(cut.At(60, 35), patch);
}

// Every border node of a square of 100 nodes has three links across the border; a tenth of all
// links is 12.
TEST(PieceBorders, AreNodesBesideOtherPiecesAndContactsFromATenthOfTheOutlineOn) {
  const MeasuredPoints wall =
      DrawnImage({.width = 20, .height = 10, .focal_px = 262}, [](int, int) { return 0.8f; });
  const SurfaceGraph graph = SurfaceGraph::OfImage(wall, {});
  Pieces pieces{.of_node = {}, .support_count = 1, .piece_count = 3, .patch_of = {}};
  std::vector<std::uint32_t> expected;
  for (std::uint32_t i = 0; i < graph.size(); ++i) {
    const int column = ColumnOf(wall, i);
    pieces.of_node.push_back(column < 15 ? column / 5 : kNoIndex);
    if (column == 5 || column == 9 || column == 10) expected.push_back(i);
  }
  EXPECT_EQ(BorderNodes(graph, pieces, {}), expected);
  EXPECT_TRUE(IsContact(13, 100));
  EXPECT_FALSE(IsContact(11, 100));
}

}  // namespace
}  // namespace cwm::perception
