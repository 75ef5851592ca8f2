// A wall that faces the sensor, cut into pieces along its columns of pixels.
#include "perception/segmentation/even_pieces.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/perception/segmentation/drawn_image.h"

namespace cwm::perception {
namespace {

constexpr DrawnFormat kColumnsFormat{.width = 40, .height = 30, .focal_px = 525};
constexpr float kColumnsDepth_m = 0.8f;

class WallOfColumns {
 public:
  explicit WallOfColumns(std::int32_t support_count) {
    pieces_.support_count = pieces_.piece_count = support_count;
    pieces_.of_node.assign(measured_.oriented.size(), kNoIndex);
  }

  // Makes the columns from `first` to before `last` a piece.
  void Add(int first, int last) { Label(first, last, pieces_.piece_count++); }
  void Label(int first, int last, std::int32_t piece) {
    ForEach(first, last, [&](std::size_t i) { pieces_.of_node[i] = piece; });
  }
  // Makes a crease between this column and the next one, except in the first `even_rows` rows.
  void Crease(int column, int even_rows) {
    ForEach(column, column + 2,
            [&](std::size_t i) { crease_[i] = RowOf(measured_, i) >= even_rows; });
  }
  // Tilts the normals as if the columns were seen at 70 degrees.
  void Slant(int first, int last) {
    ForEach(first, last, [&](std::size_t i) {
      measured_.oriented.normals[i] = Eigen::Vector3f(0.94f, 0, -0.342f);
    });
  }

  Pieces Join(const Seeds& seeds = {}, const std::vector<Plane>& long_planes = {}) const {
    Pieces joined = pieces_;
    const SurfaceGraph graph = SurfaceGraph::OfImage(measured_, {});
    JoinEvenPieces(graph, crease_, seeds, long_planes, joined, {});
    return joined;
  }

  std::int32_t At(const Pieces& pieces, int column) const {
    return OfColumn(measured_, pieces.of_node, column);
  }

 private:
  template <class F>
  void ForEach(int first, int last, const F& f) const {
    for (std::size_t i = 0; i < measured_.oriented.size(); ++i) {
      if (const int column = ColumnOf(measured_, i); column >= first && column < last) f(i);
    }
  }

  MeasuredPoints measured_ = DrawnImage(kColumnsFormat, [](int, int) { return kColumnsDepth_m; });
  std::vector<char> crease_ = std::vector<char>(measured_.oriented.size(), 0);
  Pieces pieces_;
};

// Pieces of 600 nodes: a sufficient part of their outlines is 30 links, three for each row but the
// last.
TEST(JoinEvenPieces, JoinsWhatSharesAGoodPartOfItsOutlineWithoutACrease) {
  for (const int even_rows : {0, 5, 15, 30}) {
    WallOfColumns wall(0);
    wall.Add(0, 20);
    wall.Add(20, 40);
    wall.Crease(19, even_rows);
    const Pieces joined = wall.Join();
    EXPECT_EQ(joined.piece_count, even_rows >= 15 ? 1 : 2) << even_rows;
    EXPECT_EQ(wall.At(joined, 0), 0);
    EXPECT_EQ(wall.At(joined, 39), joined.piece_count - 1) << even_rows;
  }
}

TEST(JoinEvenPieces, LeavesSupportsAndGapsAndClosesUpTheNumbers) {
  WallOfColumns wall(1);
  wall.Label(0, 10, 0);
  wall.Add(10, 20);
  wall.Add(20, 28);  // joins the one before
  wall.Add(32, 40);  // beyond nodes that are in no piece
  const Pieces joined = wall.Join();
  EXPECT_EQ(joined.piece_count, 3);
  EXPECT_EQ(wall.At(joined, 5), 0);
  EXPECT_EQ(wall.At(joined, 15), 1);
  EXPECT_EQ(wall.At(joined, 25), 1);
  EXPECT_EQ(wall.At(joined, 30), kNoIndex);
  EXPECT_EQ(wall.At(joined, 35), 2);
}

// A piece of 150 nodes: 10 links with the piece on its left and 4 with the one on its right are not
// a sufficient part of its outline.
TEST(JoinEvenPieces, GivesWhatIsSeenAtAGrazingAngleToTheOneThatItSharesMostWith) {
  for (const bool is_grazing : {false, true}) {
    WallOfColumns wall(0);
    wall.Add(0, 20);
    wall.Add(20, 25);
    wall.Add(25, 40);
    wall.Crease(19, 4);
    wall.Crease(24, 2);
    if (is_grazing) wall.Slant(20, 25);
    const Pieces joined = wall.Join();
    EXPECT_EQ(joined.piece_count, is_grazing ? 2 : 3);
    EXPECT_EQ(wall.At(joined, 10) == wall.At(joined, 22), is_grazing);
    EXPECT_NE(wall.At(joined, 22), wall.At(joined, 30));
  }
}

// The larger piece belongs to a long plane that passes `off_m` behind the other piece. The warp
// allows 12 standard deviations of 1.5 mm: 18 mm.
TEST(JoinEvenPieces, JoinsNoPieceOfALongPlaneWithWhatLiesOffIt) {
  for (const double off_m : {0.01, 0.03}) {
    WallOfColumns wall(0);
    wall.Add(0, 25);
    wall.Add(25, 40);
    const Seeds seeds{.of_node = {}, .classes = {1, 0}};
    const Plane behind{-Vector3::UnitZ(), -(double{kColumnsDepth_m} + off_m)};
    EXPECT_EQ(wall.Join(seeds, {behind}).piece_count, off_m < 0.018 ? 1 : 2) << off_m;
  }
}

}  // namespace
}  // namespace cwm::perception
