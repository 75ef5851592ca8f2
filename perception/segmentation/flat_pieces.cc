#include "perception/segmentation/flat_pieces.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <set>
#include <utility>

#include "collision/geometry/pose.h"
#include "perception/cloud/tolerances.h"
#include "perception/segmentation/support_gaps.h"

namespace cwm::perception {
namespace {

// The places on a support's plane that its cells occupy, as sets of squares. A point belongs to the
// support's surface if it is within two cells of it or, where noise scatters the points, within
// that scatter. The scatter grows by a factor of a hundred from here to the end of a hall, so there
// is one set for each size of square, from two cells on, each twice as large as the one before and
// made of that one when it is first needed.
class Surroundings {
 public:
  Surroundings(const CoarseCloud& coarse, const SupportPlane& support)
      : across_(BasisFromZ(support.plane.normal).leftCols<2>().transpose().cast<float>()),
        edge_m_(2 * double{coarse.grid.edge_m()}) {
    Squares& finest = sizes_.emplace_back();
    for (std::uint32_t c : support.cells) finest.insert(SquareOf(coarse.cells.points[c]));
  }

  // True if the support has a place within `gap_m`. Squares are coarse: a place up to four times as
  // far along an axis, or within two of the finest squares, counts too.
  bool Has(const Eigen::Vector3f& point, double gap_m) {
    std::size_t size = 0;
    Square square = SquareOf(point);
    for (double edge_m = edge_m_; edge_m < gap_m; edge_m *= 2) {
      if (++size == sizes_.size()) MakeNext();
      square = Parent(square);
    }
    for (int du = -1; du <= 1; ++du) {
      for (int dv = -1; dv <= 1; ++dv) {
        if (sizes_[size].contains({square.first + du, square.second + dv})) return true;
      }
    }
    return false;
  }

  void Add(const Eigen::Vector3f& point) {
    Square square = SquareOf(point);
    for (Squares& squares : sizes_) {
      squares.insert(square);
      square = Parent(square);
    }
  }

 private:
  using Square = std::pair<std::int64_t, std::int64_t>;
  using Squares = std::set<Square>;

  Square SquareOf(const Eigen::Vector3f& point) const {
    const Eigen::Vector2d at = (across_ * point).cast<double>() / edge_m_;
    return {static_cast<std::int64_t>(std::floor(at.x())),
            static_cast<std::int64_t>(std::floor(at.y()))};
  }

  static Square Parent(const Square& square) { return {square.first >> 1, square.second >> 1}; }

  void MakeNext() {
    Squares next;
    for (const Square& square : sizes_.back()) next.insert(Parent(square));
    sizes_.push_back(std::move(next));
  }

  Eigen::Matrix<float, 2, 3> across_;
  double edge_m_;
  std::vector<Squares> sizes_;  // each with twice the edge of the one before
};

// Per piece, the support that it is linked to, or kNoIndex.
std::vector<std::int32_t> LinkedSupports(const SurfaceGraph& graph, const Pieces& pieces,
                                         const Work& work) {
  std::vector<std::int32_t> support(static_cast<std::size_t>(pieces.piece_count), kNoIndex);
  for (std::uint32_t i : BorderNodes(graph, pieces, work)) {
    const std::int32_t a = pieces.of_node[i];
    graph.ForEachLinked(i, [&](std::size_t j) {
      const std::int32_t b = pieces.of_node[j];
      if (b != kNoIndex && b < pieces.support_count) support[static_cast<std::size_t>(a)] = b;
    });
  }
  return support;
}

// True if the node is within the warp of the support. Nothing stands below a support, so below it
// the tolerance is the largest warp, above it the usual one.
bool IsFlat(const Plane& plane, const OrientedPoints& nodes, std::size_t i) {
  const double height_m = plane.Height_m(nodes.points[i]);
  return height_m <= nodes.UsualPlaneTolerance_m(i) && height_m >= -nodes.WidePlaneTolerance_m(i);
}

bool IsWithinNoise(const Plane& plane, const OrientedPoints& nodes, std::size_t i) {
  return std::abs(plane.Height_m(nodes.points[i])) <= kGate_sigma * nodes.sigma_m[i];
}

// Decides which pieces and unassigned nodes a support absorbs.
class Absorption {
 public:
  Absorption(const SurfaceGraph& graph, const CoarseCloud& coarse,
             const std::vector<SupportPlane>& supports, const SightMap* sight, const Pieces& pieces,
             const Work& work)
      : nodes_(graph.nodes()),
        coarse_(coarse),
        supports_(supports),
        sight_(sight),
        surroundings_(supports.size()) {
    const std::vector<std::int32_t> linked = LinkedSupports(graph, pieces, work);
    std::vector<Members> members(linked.size());
    for (std::uint32_t i = 0; i < graph.size(); ++i) {
      const std::int32_t p = pieces.of_node[i];
      if (p == kNoIndex) {
        parts_.push_back({.members = {i}, .range_m = graph.range_m(i)});
      } else if (p >= pieces.support_count) {
        members[static_cast<std::size_t>(p)].push_back(i);
      }
    }
    for (std::size_t p = 0; p < members.size(); ++p) {
      if (members[p].empty()) continue;
      const float range_m = graph.range_m(members[p].front());
      parts_.push_back({std::move(members[p]), range_m, linked[p]});
    }
    // Nearest first: a support grows away from the sensor, and farther parts lie beside nearer
    // ones.
    std::ranges::stable_sort(parts_, {}, &Part::range_m);
  }

  void Absorb(Pieces& pieces) {
    for (std::size_t left = parts_.size() + 1; parts_.size() < left;) {
      left = parts_.size();
      std::erase_if(parts_, [&](const Part& part) {
        const std::int32_t support = SupportOf(part);
        if (support == kNoIndex) return false;
        for (std::uint32_t i : part.members) pieces.of_node[i] = support;
        if (auto& around = surroundings_[static_cast<std::size_t>(support)]) {
          for (std::uint32_t i : part.members) around->Add(nodes_.points[i]);
        }
        return true;
      });
    }
  }

 private:
  using Members = std::vector<std::uint32_t>;

  struct Part {
    Members members;
    float range_m = 0;
    std::int32_t linked = kNoIndex;  // a support
  };

  // The support that absorbs the part, or kNoIndex.
  std::int32_t SupportOf(const Part& part) {
    if (part.linked != kNoIndex) {
      const Plane& plane = supports_[static_cast<std::size_t>(part.linked)].plane;
      const bool flat = IsMostly(part, [&](auto i) { return IsFlat(plane, nodes_, i); });
      return flat ? part.linked : kNoIndex;
    }
    for (std::size_t s = 0; s < supports_.size(); ++s) {
      const Plane& plane = supports_[s].plane;
      if (IsMostly(part, [&](auto i) { return IsWithinNoise(plane, nodes_, i); }) &&
          (std::ranges::any_of(part.members, [&](auto i) { return IsBeside(s, i); }) ||
           IsBehindHidden(s, part))) {
        return static_cast<std::int32_t>(s);
      }
    }
    return kNoIndex;
  }

  template <class Asked>
  static bool IsMostly(const Part& part, const Asked& asked) {
    return static_cast<double>(std::ranges::count_if(part.members, asked)) >=
           kNearlyAll * static_cast<double>(part.members.size());
  }

  bool IsBeside(std::size_t support, std::size_t node) {
    std::optional<Surroundings>& around = surroundings_[support];
    if (!around) around.emplace(coarse_, supports_[support]);
    return around->Has(nodes_.points[node], nodes_.UsualPlaneTolerance_m(node));
  }

  // True if the part is a piece and nearer objects hide the gap between it and the support.
  bool IsBehindHidden(std::size_t support, const Part& part) const {
    if (sight_ == nullptr || part.members.size() < kTwoSamples) return false;
    std::vector<std::uint32_t> cells;
    for (std::uint32_t i : part.members) cells.push_back(coarse_.grid.CellOfPoint(i));
    const SupportPlane& plane = supports_[support];
    return IsGapClosed(plane.plane, coarse_.cells, plane.cells, cells, sight_);
  }

  const OrientedPoints& nodes_;
  const CoarseCloud& coarse_;
  const std::vector<SupportPlane>& supports_;
  const SightMap* sight_;                                  // or null
  std::vector<Part> parts_;                                // parts that no support has absorbed yet
  std::vector<std::optional<Surroundings>> surroundings_;  // made on first use
};

// Renumbers the remaining pieces without gaps, in their order.
void CloseUp(Pieces& pieces) {
  std::vector<std::int32_t> renamed(static_cast<std::size_t>(pieces.piece_count), kNoIndex);
  for (std::int32_t p : pieces.of_node) {
    if (p != kNoIndex) renamed[static_cast<std::size_t>(p)] = p;
  }
  std::int32_t next = 0;
  for (std::int32_t p = 0; p < pieces.piece_count; ++p) {
    std::int32_t& name = renamed[static_cast<std::size_t>(p)];
    if (p < pieces.support_count || name != kNoIndex) name = next++;
  }
  for (std::int32_t& p : pieces.of_node) {
    if (p != kNoIndex) p = renamed[static_cast<std::size_t>(p)];
  }
  pieces.piece_count = next;
}

}  // namespace

void AbsorbFlatPieces(const SurfaceGraph& graph, const CoarseCloud& coarse,
                      const std::vector<SupportPlane>& supports, const SightMap* sight,
                      Pieces& pieces, const Work& work) {
  if (supports.empty()) return;
  Absorption(graph, coarse, supports, sight, pieces, work).Absorb(pieces);
  CloseUp(pieces);
}

}  // namespace cwm::perception
