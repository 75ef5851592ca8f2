#include "perception/scene/pieces.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>
#include <tuple>

#include "perception/cloud/parallel_for.h"

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

constexpr float kDegree = std::numbers::pi_v<float> / 180;
constexpr float kConcave_rad =
    20 * kDegree;  // chosen: above what warp bends a face by, below a box's edge
// A support's nodes: max(15 degrees, 3 standard deviations of the normal).
constexpr float kSupportNormalGate_rad = 15 * kDegree;
constexpr float kNormalGate_sigma = 3;
constexpr float kWarp_sigma = 6;  // half of the largest: what rises more is a thing of its own
constexpr double kLargestPatch_m2 = 0.04;          // the floor of a pot of 22 cm
constexpr float kFlatShare = 0.9f;                 // the rest may be mixed pixels
constexpr std::uint32_t kSmallestSeed_nodes = 40;  // three independent ones fix a plane

// Angle by which the surface turns towards the viewer from a to b: positive is concave.
float Concavity_rad(const OrientedPoints& nodes, std::size_t a, std::size_t b) {
  const Vector3f d = (nodes.points[b] - nodes.points[a]).normalized();
  return std::asin(std::clamp(nodes.normals[a].dot(d), -1.0f, 1.0f)) -
         std::asin(std::clamp(nodes.normals[b].dot(d), -1.0f, 1.0f));
}

std::vector<char> ConcaveCreases(const SurfaceGraph& graph, const Work& work) {
  std::vector<char> crease(graph.size(), 0);
  const OrientedPoints& nodes = graph.nodes();
  ParallelFor(graph.size(), 4096, work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      graph.ForEachOppositePair(i, [&](std::size_t a, std::size_t b) {
        if (nodes.normals[a].isZero() || nodes.normals[b].isZero()) return;
        if (Concavity_rad(nodes, a, b) > kConcave_rad) crease[i] = 1;
      });
    }
  });
  return crease;
}

bool IsLevel(const OrientedPoints& nodes, std::size_t i, const Vector3f& up) {
  const float gate =
      std::max(kSupportNormalGate_rad, kNormalGate_sigma * nodes.normal_sigma_rad[i]);
  return std::abs(nodes.normals[i].dot(up)) >= std::cos(std::min(gate, 1.5f));
}

enum class Relation : char { kFree, kBand, kOn };  // to the nearest support

struct SupportRelation {
  std::vector<Relation> relation;
  std::vector<std::int32_t> support;  // for kBand and kOn
};

// Which support's plane each node lies on, looked up by its coarse cell.
SupportRelation RelateToSupports(const SurfaceGraph& graph, const CoarseCloud& coarse,
                                 const std::vector<SupportPlane>& supports) {
  SupportRelation out{std::vector<Relation>(graph.size(), Relation::kFree),
                      std::vector<std::int32_t>(graph.size(), kNoPiece)};
  const OrientedPoints& nodes = graph.nodes();
  std::vector<char> near(coarse.grid.size());
  for (std::size_t s = 0; s < supports.size(); ++s) {
    std::fill(near.begin(), near.end(), 0);
    for (std::uint32_t c : supports[s].cells) {
      for (int n = 0; n < 125; ++n) {
        const VoxelGrid::Cell d(n % 5 - 2, n / 5 % 5 - 2, n / 25 - 2);
        const std::int32_t other = coarse.grid.Find(coarse.grid.cell(c) + d);
        if (other >= 0) near[static_cast<std::size_t>(other)] = 1;
      }
    }
    const Vector3f up = supports[s].plane.normal.cast<float>();
    for (std::size_t i = 0; i < graph.size(); ++i) {
      if (!near[coarse.grid.CellOfPoint(i)] || out.relation[i] == Relation::kOn) continue;
      const double height = supports[s].plane.Height_m(nodes.points[i]);
      if (std::abs(height) > kPlaneGate_sigma * nodes.sigma_m[i]) continue;
      out.relation[i] = IsLevel(nodes, i, up) ? Relation::kOn : Relation::kBand;
      out.support[i] = static_cast<std::int32_t>(s);
    }
  }
  return out;
}

// A support seen by a real sensor is warped: level nodes that continue it evenly belong to it as
// far as kMostWarp_sigma, beyond its 3 sigma. Steps and slopes end it.
void FollowWarp(const SurfaceGraph& graph, const std::vector<SupportPlane>& supports,
                const std::vector<char>& crease, SupportRelation& to_support) {
  const OrientedPoints& nodes = graph.nodes();
  std::vector<std::size_t> front;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    if (to_support.relation[i] == Relation::kOn && !crease[i]) front.push_back(i);
  }
  for (std::size_t k = 0; k < front.size(); ++k) {
    const std::size_t i = front[k];
    const Plane& plane = supports[static_cast<std::size_t>(to_support.support[i])].plane;
    const double height = plane.Height_m(nodes.points[i]);
    graph.ForEachLinked(i, [&](std::size_t j) {
      if (to_support.relation[j] != Relation::kFree || crease[j]) return;
      const double other = plane.Height_m(nodes.points[j]);
      if (std::abs(other) > kMostWarp_sigma * nodes.sigma_m[j]) return;
      if (std::abs(other - height) > nodes.sigma_m[j]) return;
      if (!IsLevel(nodes, j, plane.normal.cast<float>())) return;
      to_support.relation[j] = Relation::kOn;
      to_support.support[j] = to_support.support[i];
      front.push_back(j);
    });
  }
}

// Connected nodes that may seed a piece get one label each; too small sets stay unlabelled.
void SeedPieces(const SurfaceGraph& graph, const std::vector<char>& may_seed, Pieces& pieces) {
  std::vector<char> visited(graph.size(), 0);
  std::vector<std::size_t> members;
  for (std::size_t start = 0; start < graph.size(); ++start) {
    if (visited[start] || !may_seed[start]) continue;
    members.assign(1, start);
    visited[start] = 1;
    std::uint64_t weight = 0;
    for (std::size_t k = 0; k < members.size(); ++k) {
      weight += graph.weight(members[k]);
      graph.ForEachLinked(members[k], [&](std::size_t other) {
        if (visited[other] || !may_seed[other]) return;
        visited[other] = 1;
        members.push_back(other);
      });
    }
    if (weight < kSmallestSeed_nodes) continue;
    for (std::size_t i : members) pieces.of_node[i] = pieces.piece_count;
    ++pieces.piece_count;
  }
}

// Patches of a support that hang together with none of its larger part: seen through a handle, or
// really the floor of a vessel that stands on it. They become pieces that remember their support.
void SeparatePatches(const SurfaceGraph& graph, Pieces& pieces) {
  std::vector<std::int32_t> patch(graph.size(), kNoPiece);
  std::vector<std::vector<std::uint32_t>> patches;
  for (std::size_t start = 0; start < graph.size(); ++start) {
    const std::int32_t support = pieces.of_node[start];
    if (support == kNoPiece || support >= pieces.support_count || patch[start] >= 0) continue;
    const auto id = static_cast<std::int32_t>(patches.size());
    std::vector<std::uint32_t> members{static_cast<std::uint32_t>(start)};
    patch[start] = id;
    for (std::size_t k = 0; k < members.size(); ++k) {
      graph.ForEachLinked(members[k], [&](std::size_t j) {
        if (patch[j] >= 0 || pieces.of_node[j] != support) return;
        patch[j] = id;
        members.push_back(static_cast<std::uint32_t>(j));
      });
    }
    patches.push_back(std::move(members));
  }
  for (const auto& members : patches) {
    double area = 0;
    for (std::uint32_t i : members) area += graph.area_m2(i);
    if (area > kLargestPatch_m2 || members.size() < kSmallestSeed_nodes) continue;
    const std::int32_t support = pieces.of_node[members[0]];
    for (std::uint32_t i : members) pieces.of_node[i] = pieces.piece_count;
    pieces.patch_of.emplace(pieces.piece_count++, support);
  }
}

struct Claim {
  float cost;  // distance of the node from the anchor's plane, in sigma
  std::uint32_t node, anchor;
  std::int32_t piece;
  bool operator>(const Claim& other) const {
    return std::tie(cost, node, piece) > std::tie(other.cost, other.node, other.piece);
  }
};

// Labelled nodes claim their unlabelled neighbours; the node goes to the piece whose surface,
// prolonged from where the claim started, passes nearest to it.
void GrowPieces(const SurfaceGraph& graph, const std::vector<SupportPlane>& supports,
                Pieces& pieces) {
  const OrientedPoints& nodes = graph.nodes();
  std::priority_queue<Claim, std::vector<Claim>, std::greater<>> claims;
  auto claim_around = [&](std::size_t from, std::uint32_t anchor, std::int32_t piece) {
    graph.ForEachLinked(from, [&](std::size_t to) {
      if (pieces.of_node[to] != kNoPiece) return;
      float distance;
      if (piece < pieces.support_count) {
        distance = static_cast<float>(
            supports[static_cast<std::size_t>(piece)].plane.Height_m(nodes.points[to]));
      } else {
        distance = nodes.normals[anchor].dot(nodes.points[to] - nodes.points[anchor]);
      }
      claims.push(
          {std::abs(distance) / nodes.sigma_m[to], static_cast<std::uint32_t>(to), anchor, piece});
    });
  };
  for (std::size_t i = 0; i < graph.size(); ++i) {
    if (pieces.of_node[i] == kNoPiece) continue;
    claim_around(i, static_cast<std::uint32_t>(i), pieces.of_node[i]);
  }
  while (!claims.empty()) {
    const Claim claim = claims.top();
    claims.pop();
    if (pieces.of_node[claim.node] != kNoPiece) continue;
    pieces.of_node[claim.node] = claim.piece;
    claim_around(claim.node, claim.anchor, claim.piece);
  }
}

// Pieces that nowhere rise (or sink) above what noise and warp of the sensor can make of a support
// are part of it; the numbers of the others close up.
void AbsorbFlatPieces(const SurfaceGraph& graph, const std::vector<SupportPlane>& supports,
                      Pieces& pieces) {
  const OrientedPoints& nodes = graph.nodes();
  std::vector<std::int32_t> carrier(static_cast<std::size_t>(pieces.piece_count), kNoPiece);
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const std::int32_t a = pieces.of_node[i];
    if (a < pieces.support_count) continue;
    graph.ForEachLinked(i, [&](std::size_t j) {
      const std::int32_t b = pieces.of_node[j];
      if (b != kNoPiece && b < pieces.support_count) carrier[static_cast<std::size_t>(a)] = b;
    });
  }
  std::vector<std::uint32_t> all(carrier.size(), 0), flat(carrier.size(), 0);
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const std::int32_t a = pieces.of_node[i];
    if (a < pieces.support_count) continue;
    const auto p = static_cast<std::size_t>(a);
    ++all[p];
    if (carrier[p] == kNoPiece) continue;
    const Plane& plane = supports[static_cast<std::size_t>(carrier[p])].plane;
    // Nothing stands below a support: there, all that warp can do is believed to be warp.
    const double height_sigma = plane.Height_m(nodes.points[i]) / nodes.sigma_m[i];
    flat[p] += height_sigma <= kWarp_sigma && height_sigma >= -kMostWarp_sigma;
  }
  std::vector<std::int32_t> renamed(carrier.size());
  std::int32_t next = pieces.support_count;
  for (std::size_t p = 0; p < renamed.size(); ++p) {
    const bool is_support = p < static_cast<std::size_t>(pieces.support_count);
    const bool absorbed = !is_support && flat[p] >= kFlatShare * all[p] && carrier[p] != kNoPiece;
    renamed[p] = is_support ? static_cast<std::int32_t>(p) : absorbed ? carrier[p] : next++;
  }
  for (std::int32_t& p : pieces.of_node) {
    if (p != kNoPiece) p = renamed[static_cast<std::size_t>(p)];
  }
  pieces.piece_count = next;
}

}  // namespace

Pieces CutIntoPieces(const SurfaceGraph& graph, const CoarseCloud& coarse,
                     const std::vector<SupportPlane>& supports, const Work& work) {
  Pieces pieces;
  pieces.of_node.assign(graph.size(), kNoPiece);
  pieces.support_count = static_cast<std::int32_t>(supports.size());
  pieces.piece_count = pieces.support_count;
  const std::vector<char> crease = ConcaveCreases(graph, work);
  SupportRelation to_support = RelateToSupports(graph, coarse, supports);
  FollowWarp(graph, supports, crease, to_support);
  std::vector<char> may_seed(graph.size(), 0);
  for (std::size_t i = 0; i < graph.size(); ++i) {
    if (crease[i]) continue;
    if (to_support.relation[i] == Relation::kOn) pieces.of_node[i] = to_support.support[i];
    may_seed[i] = to_support.relation[i] == Relation::kFree && !graph.nodes().normals[i].isZero();
  }
  SeedPieces(graph, may_seed, pieces);
  GrowPieces(graph, supports, pieces);
  AbsorbFlatPieces(graph, supports, pieces);
  SeparatePatches(graph, pieces);
  return pieces;
}

}  // namespace cwm::perception
