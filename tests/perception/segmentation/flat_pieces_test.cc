// A support that faces the sensor, and the pieces beside it in the view.
#include "perception/segmentation/flat_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "tests/perception/segmentation/drawn_image.h"

namespace cwm::perception {
namespace {

constexpr DrawnFormat kBesideFormat{.width = 100, .height = 80, .focal_px = 262};
constexpr float kSupportDepth_m = 0.8f;      // a pixel is 3 mm wide there, sigma is 1.5 mm
constexpr int kFirstBeside = 50;             // the first column beside the support
constexpr float kBesidePitch_rad = 0.0076f;  // of the sight map: two pixels

struct DrawnColumn {
  float depth_m = std::nanf("");
  std::int32_t piece = kNoIndex;
};

// All columns before kFirstBeside belong to the support, piece 0; `column` gives the others.
class BesideASupport {
 public:
  explicit BesideASupport(const std::function<DrawnColumn(int)>& column) {
    const auto drawn = [&](int u) {
      return u < kFirstBeside ? DrawnColumn{kSupportDepth_m, 0} : column(u);
    };
    measured_ = DrawnImage(kBesideFormat, [&](int, int u) { return drawn(u).depth_m; });
    pieces_.support_count = pieces_.piece_count = 1;
    for (std::size_t i = 0; i < measured_.oriented.size(); ++i) {
      pieces_.of_node.push_back(drawn(ColumnOf(measured_, i)).piece);
      pieces_.piece_count = std::max(pieces_.piece_count, pieces_.of_node.back() + 1);
    }
  }

  enum class Sensor { kUnknown, kKnown };

  Pieces Absorb(Sensor sensor = Sensor::kUnknown) const {
    const SurfaceGraph graph = SurfaceGraph::OfImage(measured_, {});
    const CoarseCloud coarse = MakeCoarseCloud(graph.nodes());
    SupportPlane support;
    support.plane = {-Vector3::UnitZ(), -double{kSupportDepth_m}};
    for (std::size_t i = 0; i < graph.size(); ++i) {
      if (pieces_.of_node[i] == 0) support.cells.push_back(coarse.grid.CellOfPoint(i));
    }
    std::sort(support.cells.begin(), support.cells.end());
    support.cells.erase(std::unique(support.cells.begin(), support.cells.end()),
                        support.cells.end());
    const SightMap sight(graph.nodes(), kBesidePitch_rad);
    Pieces pieces = pieces_;
    AbsorbFlatPieces(graph, coarse, {support}, sensor == Sensor::kKnown ? &sight : nullptr, pieces,
                     {});
    return pieces;
  }

  std::int32_t At(const Pieces& pieces, int column) const {
    return OfColumn(measured_, pieces.of_node, column);
  }

 private:
  MeasuredPoints measured_;
  Pieces pieces_;
};

// A slope that ends `end_m` above the support. Up to 6 standard deviations above it (9 mm) are
// usual; below it, up to 12.
TEST(AbsorbFlatPieces, TakesWhatIsLinkedUnlessItRisesOrSinksMoreThanWarp) {
  for (const float end_m : {0.008f, 0.03f, -0.015f, -0.04f}) {
    const BesideASupport scene([&](int u) {
      const float share = static_cast<float>(u - kFirstBeside) / 49;
      return DrawnColumn{kSupportDepth_m - share * end_m, 1};
    });
    const Pieces pieces = scene.Absorb();
    const bool is_flat = end_m < 0.009f && end_m > -0.018f;
    EXPECT_EQ(scene.At(pieces, 99), is_flat ? 0 : 1) << end_m;
    EXPECT_EQ(pieces.piece_count, is_flat ? 1 : 2) << end_m;
  }
}

// A strip of ten columns across a gap of 9 mm, less than two cells of 15 mm, or across a gap of 12
// cm.
TEST(AbsorbFlatPieces, TakesWhatIsNotLinkedOnlyOnThePlaneAndBesideTheSupport) {
  struct Strip {
    int first;
    float depth_m;
    std::int32_t piece;
    bool is_taken;
  };
  for (const Strip& strip : {Strip{53, kSupportDepth_m, 1, true},
                             {53, kSupportDepth_m, kNoIndex, true},
                             {53, kSupportDepth_m - 0.01f, 1, false},
                             {90, kSupportDepth_m, 1, false},
                             {90, kSupportDepth_m, kNoIndex, false}}) {
    const BesideASupport scene([&](int u) {
      if (u < strip.first || u >= strip.first + 10) return DrawnColumn{};
      return DrawnColumn{strip.depth_m, strip.piece};
    });
    const Pieces pieces = scene.Absorb();
    EXPECT_EQ(scene.At(pieces, strip.first), strip.is_taken ? 0 : strip.piece) << strip.first;
    EXPECT_EQ(scene.At(pieces, strip.first + 9), strip.is_taken ? 0 : strip.piece) << strip.first;
  }
}

// As a table behind a box: 12 cm farther on the support's plane, with something in front of that
// plane or behind it in between.
TEST(AbsorbFlatPieces, TakesWhatLiesBehindHiddenPlacesAndClosesUpTheNumbers) {
  using Sensor = BesideASupport::Sensor;
  for (const float between_m : {0.5f, 1.5f}) {
    const BesideASupport scene([&](int u) {
      return u < 90 ? DrawnColumn{between_m, 2} : DrawnColumn{kSupportDepth_m, 1};
    });
    const bool is_hidden = between_m < kSupportDepth_m;
    const Pieces pieces = scene.Absorb(Sensor::kKnown);
    EXPECT_EQ(scene.At(pieces, 95), is_hidden ? 0 : 1) << between_m;
    EXPECT_EQ(scene.At(pieces, 70), is_hidden ? 1 : 2) << between_m;
    EXPECT_EQ(pieces.piece_count, is_hidden ? 2 : 3) << between_m;
    EXPECT_EQ(scene.At(scene.Absorb(Sensor::kUnknown), 95), 1) << between_m;
  }
}

}  // namespace
}  // namespace cwm::perception
