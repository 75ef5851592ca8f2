#include "perception/segmentation/pieces.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <queue>
#include <tuple>

#include "perception/cloud/parallel_for.h"
#include "perception/cloud/tolerances.h"
#include "perception/segmentation/connected_sets.h"
#include "perception/segmentation/even_pieces.h"
#include "perception/segmentation/flat_pieces.h"
#include "perception/segmentation/long_planes.h"
#include "perception/segmentation/seeds.h"

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

using namespace std::chrono_literals;

// chosen: the floor of a pan of 30 cm.
constexpr double kMaxPatch_m2 = 0.07;
constexpr std::size_t kNodesPerPiece = ItemsPerChunk(20ns);
// derived: the least number of links of a contact per square root of nodes: a tenth of the outline
// of a compact piece, whose border nodes have three links across each.
constexpr double kMinContact = 1.2;

// True if the normal is within max(kSameNormal_rad, 3 standard deviations of the normal) of up, as
// of a support's nodes.
bool IsLevel(const OrientedPoints& nodes, std::size_t i, const Vector3f& up) {
  static const auto min_gate_cos = static_cast<float>(std::cos(kSameNormal_rad));
  const float cosine = std::abs(nodes.normals[i].dot(up));
  if (cosine >= min_gate_cos) return true;
  const double gate = kGate_sigma * nodes.normal_sigma_rad[i];
  return gate > kSameNormal_rad && cosine >= std::cos(std::min(gate, 1.5));
}

enum class Relation : char { kFree, kBand, kOn };  // to the nearest support

struct SupportRelation {
  std::vector<Relation> relation;
  std::vector<std::int32_t> support;  // for kBand and kOn
};

// The cells of a support, and cells within two cells of them that may hold points of its plane.
std::vector<std::uint32_t> CellsAround(const CoarseCloud& coarse, const SupportPlane& support) {
  std::vector<char> on_support(coarse.grid.size(), 0);
  for (std::uint32_t c : support.cells) on_support[c] = 1;
  const auto beside = [&](std::uint32_t c) {
    return coarse.grid.AnyWithin(2, coarse.grid.cell(c),
                                 [&](std::size_t other) { return on_support[other] != 0; });
  };
  std::vector<std::uint32_t> around;
  for (std::uint32_t c = 0; c < coarse.grid.size(); ++c) {
    // A cell's points lie within half its diagonal of its middle; noise hardly differs within a
    // cell.
    const double reach_m = 0.9 * coarse.grid.edge_m() + 1.5 * kGate_sigma * coarse.cells.sigma_m[c];
    if (std::abs(support.plane.Height_m(coarse.grid.Center(c))) > reach_m) continue;
    if (on_support[c] || beside(c)) around.push_back(c);
  }
  return around;
}

// The support's plane that each node lies on, looked up by its coarse cell.
SupportRelation RelateToSupports(const SurfaceGraph& graph, const CoarseCloud& coarse,
                                 const std::vector<SupportPlane>& supports, const Work& work) {
  SupportRelation out{std::vector<Relation>(graph.size(), Relation::kFree),
                      std::vector<std::int32_t>(graph.size(), kNoIndex)};
  const OrientedPoints& nodes = graph.nodes();
  for (std::size_t s = 0; s < supports.size(); ++s) {
    const Plane& plane = supports[s].plane;
    const Vector3f up = plane.normal.cast<float>();
    const auto relate = [&](std::uint32_t i) {
      if (out.relation[i] == Relation::kOn) return;
      const double height = plane.Height_m(nodes.points[i]);
      if (std::abs(height) > kGate_sigma * nodes.sigma_m[i]) return;
      out.relation[i] = IsLevel(nodes, i, up) ? Relation::kOn : Relation::kBand;
      out.support[i] = static_cast<std::int32_t>(s);
    };
    const std::vector<std::uint32_t> cells = CellsAround(coarse, supports[s]);
    ParallelFor(cells.size(), ItemsPerChunk(2us), work, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        for (std::uint32_t i : coarse.grid.PointsOf(cells[k])) relate(i);
      }
    });
  }
  return out;
}

// f(i) for each node, in parallel.
template <class F>
void ForEachNode(std::size_t count, const Work& work, const F& f) {
  ParallelFor(count, kNodesPerPiece, work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) f(i);
  });
}

// Nodes of a range for which `wanted` is true, in their order; evaluated in parallel.
template <class Wanted>
std::vector<std::uint32_t> NodesWhere(std::size_t count, const Work& work, const Wanted& wanted) {
  std::vector<std::vector<std::uint32_t>> found(count / kNodesPerPiece + 1);
  ParallelFor(count, kNodesPerPiece, work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (wanted(i)) found[begin / kNodesPerPiece].push_back(static_cast<std::uint32_t>(i));
    }
  });
  std::vector<std::uint32_t> all;
  for (const auto& some : found) all.insert(all.end(), some.begin(), some.end());
  return all;
}

// Extends supports over the warp of a real sensor: level nodes that continue a support evenly
// belong to it up to WidePlaneTolerance_m, beyond its 3 sigma. Steps and slopes end it.
void FollowWarp(const SurfaceGraph& graph, const std::vector<SupportPlane>& supports,
                const std::vector<char>& crease, SupportRelation& to_support, const Work& work) {
  const OrientedPoints& nodes = graph.nodes();
  std::vector<char> open(graph.size());
  ForEachNode(graph.size(), work, [&](std::size_t i) {
    open[i] = to_support.relation[i] == Relation::kFree && !crease[i];
  });
  std::vector<std::uint32_t> front = NodesWhere(graph.size(), work, [&](std::size_t i) {
    if (to_support.relation[i] != Relation::kOn || crease[i]) return false;
    bool beside_open = false;
    graph.ForEachLinked(i, [&](std::size_t j) { beside_open |= open[j] != 0; });
    return beside_open;
  });
  for (std::size_t k = 0; k < front.size(); ++k) {
    const std::size_t i = front[k];
    const Plane& plane = supports[static_cast<std::size_t>(to_support.support[i])].plane;
    const Vector3f up = plane.normal.cast<float>();
    const double height = plane.Height_m(nodes.points[i]);
    graph.ForEachLinked(i, [&](std::size_t j) {
      if (!open[j]) return;
      const double other = plane.Height_m(nodes.points[j]);
      if (std::abs(other) > nodes.WidePlaneTolerance_m(j)) return;
      if (std::abs(other - height) > nodes.sigma_m[j]) return;
      if (!IsLevel(nodes, j, up)) return;
      open[j] = 0;
      to_support.relation[j] = Relation::kOn;
      to_support.support[j] = to_support.support[i];
      front.push_back(static_cast<std::uint32_t>(j));
    });
  }
}

// Makes each seed a piece, in the order of the seeds, after the supports.
void StartPieces(const Seeds& seeds, Pieces& pieces, const Work& work) {
  ForEachNode(seeds.of_node.size(), work, [&](std::size_t i) {
    if (seeds.of_node[i] >= 0) pieces.of_node[i] = pieces.support_count + seeds.of_node[i];
  });
  pieces.piece_count = pieces.support_count + static_cast<std::int32_t>(seeds.count());
}

// Per node its support if all of its neighbours belong to the same support, else kNoIndex. The rim
// of a pan is a line of pixels: across it, the pan's floor and the counter are linked at its
// corners and where noise breaks it.
std::vector<std::int32_t> InsidesOfSupports(const SurfaceGraph& graph, const Pieces& pieces,
                                            const Work& work) {
  std::vector<std::int32_t> inside(graph.size(), kNoIndex);
  ForEachNode(graph.size(), work, [&](std::size_t i) {
    const std::int32_t support = pieces.of_node[i];
    if (support >= pieces.support_count || graph.IsAtEdge(i)) return;
    bool is_inside = true;
    graph.ForEachLinked(i, [&](std::size_t j) { is_inside &= pieces.of_node[j] == support; });
    if (is_inside) inside[i] = support;
  });
  return inside;
}

// Makes small patches of a support that are not connected to its larger part pieces that remember
// their support. They are seen through a handle, or are really the floor of a vessel that stands on
// it.
void SeparatePatches(const SurfaceGraph& graph, Pieces& pieces, const Work& work) {
  const std::vector<std::int32_t> inside = InsidesOfSupports(graph, pieces, work);
  const ConnectedSets sets = FindConnectedSets(graph, inside, work);
  std::vector<double> area_m2(sets.count(), 0);  // summed up to kMaxPatch_m2 only
  std::vector<std::uint32_t> nodes(sets.count(), 0);
  for (std::size_t i = 0; i < graph.size(); ++i) {
    if (inside[i] < 0) continue;
    const auto s = static_cast<std::size_t>(sets.of_node[i]);
    ++nodes[s];
    if (area_m2[s] <= kMaxPatch_m2) area_m2[s] += graph.area_m2(i);
  }
  std::vector<std::int32_t> piece(sets.count(), kNoIndex);
  for (std::size_t s = 0; s < sets.count(); ++s) {
    if (area_m2[s] > kMaxPatch_m2 || nodes[s] < kMinSeed_nodes) continue;
    piece[s] = pieces.piece_count++;
    pieces.patch_of.emplace(piece[s], inside[sets.first_nodes[s]]);
  }
  // Nodes beside something else join the patch of a neighbour inside the support.
  const auto patch_at = [&](std::size_t i) {
    return inside[i] < 0 ? kNoIndex : piece[static_cast<std::size_t>(sets.of_node[i])];
  };
  ForEachNode(graph.size(), work, [&](std::size_t i) {
    const std::int32_t support = pieces.of_node[i];
    if (support < 0 || support >= pieces.support_count) return;
    std::int32_t patch = patch_at(i);
    if (inside[i] < 0) {
      graph.ForEachLinked(i, [&](std::size_t j) {
        if (inside[j] == support) patch = std::max(patch, patch_at(j));
      });
    }
    if (patch != kNoIndex) pieces.of_node[i] = patch;
  });
}

// Grows pieces: labelled nodes claim their unlabelled neighbours. A node goes to the piece whose
// surface, extended from where the claim started, passes nearest to it.
class PieceGrower {
 public:
  PieceGrower(const SurfaceGraph& graph, const std::vector<SupportPlane>& supports, Pieces& pieces,
              const Work& work)
      : graph_(graph), supports_(supports), pieces_(pieces), work_(work), targets_(graph.size()) {
    const OrientedPoints& nodes = graph.nodes();
    ForEachNode(graph.size(), work, [&](std::size_t i) {
      Target& target = targets_[i];
      target.p = nodes.points[i];
      target.sigma_m = nodes.sigma_m[i];
      if (pieces.of_node[i] != kNoIndex) target.min_cost = kTakenCost;
    });
  }

  void Grow() {
    const auto claim = [&](std::size_t i) {
      if (IsTaken(i)) return false;
      bool is_claimed = false;
      graph_.ForEachLinked(i, [&](std::size_t j) {
        const std::int32_t piece = pieces_.of_node[j];
        if (piece == kNoIndex) return;
        is_claimed |= Improve(targets_[i], {static_cast<std::uint32_t>(j), piece});
      });
      return is_claimed;
    };
    std::vector<Key> first;
    for (std::uint32_t i : NodesWhere(graph_.size(), work_, claim)) first.push_back(KeyOf(i));
    claims_ = Queue(std::greater<>(), std::move(first));
    while (!claims_.empty()) {
      const auto node = static_cast<std::uint32_t>(claims_.top());
      claims_.pop();
      if (!IsTaken(node)) Take(node);
    }
  }

 private:
  // Ordered by cost, whose bits compare like the number as it is not negative, and then by the
  // claimed node. The claim itself is stored at the node: an outdated key in the queue finds the
  // node taken.
  using Key = std::uint64_t;
  using Queue = std::priority_queue<Key, std::vector<Key>, std::greater<>>;

  struct Anchor {
    std::uint32_t node = 0;
    std::int32_t piece = 0;
  };

  // The data of a claimed node in one place, because nodes are accessed in random order.
  struct Target {
    Vector3f p = Vector3f::Zero();
    float sigma_m = 0;
    // The best claim on it so far: the distance from the anchor's plane, in sigma.
    float min_cost = std::numeric_limits<float>::infinity();
    Anchor anchor;
  };
  // The cost of a node that has its piece.
  static constexpr float kTakenCost = -std::numeric_limits<float>::infinity();

  bool IsTaken(std::size_t node) const { return targets_[node].min_cost == kTakenCost; }

  Key KeyOf(std::uint32_t node) const {
    return Key{std::bit_cast<std::uint32_t>(targets_[node].min_cost)} << 32 | node;
  }

  // True if this claim on the target is the best so far.
  bool Improve(Target& target, const Anchor& anchor) const {
    float distance;
    if (anchor.piece < pieces_.support_count) {
      distance = static_cast<float>(
          supports_[static_cast<std::size_t>(anchor.piece)].plane.Height_m(target.p));
    } else {
      const Vector3f& normal = graph_.nodes().normals[anchor.node];
      distance = normal.dot(target.p - targets_[anchor.node].p);
    }
    const float cost = std::abs(distance) / target.sigma_m;
    if (std::tie(cost, anchor.piece) >= std::tie(target.min_cost, target.anchor.piece)) {
      return false;
    }
    target.min_cost = cost;
    target.anchor = anchor;
    return true;
  }

  void Take(std::uint32_t node) {
    const Anchor anchor = targets_[node].anchor;
    pieces_.of_node[node] = anchor.piece;
    targets_[node].min_cost = kTakenCost;
    graph_.ForEachLinked(node, [&](std::size_t to) {
      if (IsTaken(to) || !Improve(targets_[to], anchor)) return;
      claims_.push(KeyOf(static_cast<std::uint32_t>(to)));
    });
  }

  const SurfaceGraph& graph_;
  const std::vector<SupportPlane>& supports_;
  Pieces& pieces_;
  const Work& work_;
  std::vector<Target> targets_;
  Queue claims_;
};

}  // namespace

bool IsContact(int links, std::size_t nodes) {
  return links >= kMinContact * std::sqrt(static_cast<double>(nodes));
}

std::vector<std::uint32_t> BorderNodes(const SurfaceGraph& graph, const Pieces& pieces,
                                       const Work& work) {
  return NodesWhere(graph.size(), work, [&](std::size_t i) {
    const std::int32_t a = pieces.of_node[i];
    if (a < pieces.support_count) return false;  // kNoIndex included
    bool at_border = false;
    graph.ForEachLinked(i, [&](std::size_t j) {
      at_border |= pieces.of_node[j] != a && pieces.of_node[j] != kNoIndex;
    });
    return at_border;
  });
}

Pieces CutIntoPieces(const SurfaceGraph& graph, const std::vector<char>& crease,
                     const CoarseCloud& coarse, const std::vector<SupportPlane>& supports,
                     const SightMap* sight, const Work& work) {
  Pieces pieces;
  pieces.of_node.assign(graph.size(), kNoIndex);
  pieces.support_count = static_cast<std::int32_t>(supports.size());
  pieces.piece_count = pieces.support_count;
  SupportRelation to_support = RelateToSupports(graph, coarse, supports, work);
  FollowWarp(graph, supports, crease, to_support, work);
  std::vector<std::int32_t> may_seed(graph.size(), kNoIndex);
  ForEachNode(graph.size(), work, [&](std::size_t i) {
    if (crease[i]) return;
    if (to_support.relation[i] == Relation::kOn) pieces.of_node[i] = to_support.support[i];
    const bool is_free = to_support.relation[i] == Relation::kFree;
    if (is_free && !graph.nodes().normals[i].isZero() && !graph.IsAtStep(i)) may_seed[i] = 0;
  });
  const std::vector<Plane> long_planes = LabelLongPlanes(graph, may_seed, work);
  const Seeds seeds = FindSeeds(graph, crease, may_seed, work);
  StartPieces(seeds, pieces, work);
  PieceGrower(graph, supports, pieces, work).Grow();
  JoinEvenPieces(graph, crease, seeds, long_planes, pieces, work);
  AbsorbFlatPieces(graph, coarse, supports, sight, pieces, work);
  SeparatePatches(graph, pieces, work);
  return pieces;
}

}  // namespace cwm::perception
