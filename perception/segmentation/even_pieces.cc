#include "perception/segmentation/even_pieces.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>

#include "perception/cloud/tolerances.h"
#include "perception/segmentation/disjoint_sets.h"
#include "perception/segmentation/long_planes.h"

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

using Links = std::map<std::pair<std::int32_t, std::int32_t>, int>;

// The number of links between pieces outside creases, in both directions.
Links EvenLinks(const SurfaceGraph& graph, const std::vector<char>& crease, const Pieces& pieces,
                const Work& work) {
  Links links;
  for (std::uint32_t i : BorderNodes(graph, pieces, work)) {
    if (crease[i]) continue;
    const std::int32_t a = pieces.of_node[i];
    graph.ForEachLinked(i, [&](std::size_t j) {
      const std::int32_t b = pieces.of_node[j];
      if (a != b && b >= pieces.support_count && !crease[j]) ++links[{a, b}];
    });
  }
  return links;
}

// Drops the links between the pieces of a long plane and a piece of another class that does not lie
// on that plane to within the sensor's warp: the plane ends there.
void DropLinksOffPlanes(const SurfaceGraph& graph, const Pieces& pieces, const Seeds& seeds,
                        const std::vector<Plane>& long_planes, Links& links) {
  if (long_planes.empty()) return;
  struct Share {
    std::size_t on = 0, all = 0;
  };
  const auto class_of = [&](std::int32_t piece) {
    const std::int32_t seed = piece - pieces.support_count;
    return seed < 0 ? 0 : seeds.classes[static_cast<std::size_t>(seed)];
  };
  // Per piece, by the class of the neighbour's long plane.
  std::vector<std::map<std::int32_t, Share>> on_planes(
      static_cast<std::size_t>(pieces.piece_count));
  const auto ask = [&](std::int32_t piece, std::int32_t of_plane) {
    if (of_plane == 0 || class_of(piece) == of_plane) return;
    on_planes[static_cast<std::size_t>(piece)][of_plane];
  };
  for (const auto& [pair, count] : links) {
    ask(pair.first, class_of(pair.second));
    ask(pair.second, class_of(pair.first));
  }
  for (std::size_t i = 0; i < graph.size(); ++i) {
    if (pieces.of_node[i] == kNoIndex) continue;
    for (auto& [of_plane, share] : on_planes[static_cast<std::size_t>(pieces.of_node[i])]) {
      const Plane& plane = long_planes[static_cast<std::size_t>(of_plane) - 1];
      ++share.all;
      share.on += IsOnPlane(plane, graph.nodes(), i, PlaneTolerance::kWide);
    }
  }
  const auto is_off = [&](std::int32_t piece, std::int32_t of_plane) {
    if (of_plane == 0 || class_of(piece) == of_plane) return false;
    const Share& share = on_planes[static_cast<std::size_t>(piece)].at(of_plane);
    return static_cast<double>(share.on) < kNearlyAll * static_cast<double>(share.all);
  };
  std::erase_if(links, [&](const auto& link) {
    const auto& [a, b] = link.first;
    return is_off(a, class_of(b)) || is_off(b, class_of(a));
  });
}

struct PieceSize {
  std::size_t nodes = 0, grazing = 0;  // `grazing`: nodes seen at a grazing angle
};

std::vector<PieceSize> SizesOf(const SurfaceGraph& graph, const Pieces& pieces) {
  std::vector<PieceSize> sizes(static_cast<std::size_t>(pieces.piece_count));
  const OrientedPoints& nodes = graph.nodes();
  const Vector3f viewpoint = nodes.viewpoint.cast<float>();
  for (std::size_t i = 0; i < graph.size(); ++i) {
    if (pieces.of_node[i] < pieces.support_count) continue;  // kNoIndex included
    PieceSize& size = sizes[static_cast<std::size_t>(pieces.of_node[i])];
    ++size.nodes;
    const float along = std::abs(nodes.normals[i].dot(nodes.points[i] - viewpoint));
    size.grazing += along < kSteepIncidence_cos * graph.range_m(i);
  }
  return sizes;
}

void Renumber(DisjointSets& sets, Pieces& pieces) {
  std::vector<std::int32_t> renamed(static_cast<std::size_t>(pieces.piece_count));
  std::int32_t next = 0;
  for (std::size_t p = 0; p < renamed.size(); ++p) {
    renamed[p] = sets.Root(p) == p ? next++ : renamed[sets.Root(p)];
  }
  for (std::int32_t& p : pieces.of_node) {
    if (p != kNoIndex) p = renamed[static_cast<std::size_t>(p)];
  }
  pieces.piece_count = next;
}

}  // namespace

void JoinEvenPieces(const SurfaceGraph& graph, const std::vector<char>& crease, const Seeds& seeds,
                    const std::vector<Plane>& long_planes, Pieces& pieces, const Work& work) {
  Links even_links = EvenLinks(graph, crease, pieces, work);
  DropLinksOffPlanes(graph, pieces, seeds, long_planes, even_links);
  if (even_links.empty()) return;
  const std::vector<PieceSize> nodes = SizesOf(graph, pieces);
  DisjointSets sets(nodes.size());
  std::map<std::size_t, std::pair<int, std::size_t>> best;  // grazing piece: best neighbour
  for (const auto& [pair, links] : even_links) {
    const auto a = static_cast<std::size_t>(pair.first), b = static_cast<std::size_t>(pair.second);
    if (IsContact(links, std::min(nodes[a].nodes, nodes[b].nodes))) sets.Join(a, b);
    if (2 * nodes[a].grazing >= nodes[a].nodes) best[a] = std::max(best[a], {links, b});
  }
  for (const auto& [piece, other] : best) sets.Join(piece, other.second);
  Renumber(sets, pieces);
}

}  // namespace cwm::perception
