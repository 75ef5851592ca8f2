#include "perception/search/shape_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <type_traits>
#include <vector>

#include "perception/search/random_index.h"

namespace cwm::perception {
namespace {

// chosen: draws between two looks at the leader, each of which goes through all candidates.
constexpr int kDrawsPerLeaderCheck = 32;
// chosen: three times the draws that a cluster of 300 000 points without any shape of 60 points
// needs.
constexpr std::int64_t kMaxDraws = 60000;
// chosen: a draw that starts on a shape finds it if the cell has a good size for it (one level of
// three) and the sample's noise lets it pass its tests (assumed: half of them).
constexpr double kDrawSuccessProbability = 1.0 / 6;
// derived: a cell holds all points of a drawn sample.
constexpr std::uint32_t kMinCellPoints = std::tuple_size_v<decltype(DrawnSample::points)>;
// chosen: attempts to hit an available point of a cell; if half are available, 15 of 16 are hit.
constexpr int kMaxRedraws = 4;

// Returns a random cell around the point that holds a sample, each level equally likely.
std::uint32_t CellAround(const Octree& octree, std::uint32_t point, std::mt19937_64& random) {
  const std::span<const Octree::Node> nodes = octree.nodes();
  std::uint32_t cell = octree.LeafOf(point);
  while (nodes[cell].parent != Octree::kNone &&
         nodes[cell].end - nodes[cell].begin < kMinCellPoints) {
    cell = nodes[cell].parent;
  }
  std::size_t levels = 1;
  for (std::uint32_t up = nodes[cell].parent; up != Octree::kNone; up = nodes[up].parent) ++levels;
  for (std::size_t k = RandomIndex(random, levels); k > 0; --k) cell = nodes[cell].parent;
  return cell;
}

}  // namespace

std::optional<DrawnSample> DrawSample(const Octree& octree, const std::vector<char>& available,
                                      std::mt19937_64& random) {
  std::uint32_t first = 0;
  do {
    first = static_cast<std::uint32_t>(RandomIndex(random, available.size()));
  } while (!available[first]);
  DrawnSample sample{.points = {first, first, first, first},
                     .cell = CellAround(octree, first, random)};
  const Octree::Node& cell = octree.nodes()[sample.cell];
  auto& drawn = sample.points;
  for (std::size_t k = 1; k < drawn.size(); ++k) {
    bool found = false;
    for (int attempt = 0; attempt < kMaxRedraws && !found; ++attempt) {
      drawn[k] =
          cell.begin + static_cast<std::uint32_t>(RandomIndex(random, cell.end - cell.begin));
      found = available[drawn[k]] &&
              std::find(drawn.begin(), drawn.begin() + static_cast<std::ptrdiff_t>(k), drawn[k]) ==
                  drawn.begin() + static_cast<std::ptrdiff_t>(k);
    }
    if (!found) return std::nullopt;
  }
  return sample;
}

ShapeSearch::ShapeSearch(const ModelPoints& points, const Octree& octree, CandidateList& candidates,
                         const ModelerOptions& options, const Work& work)
    : points_(points),
      octree_(octree),
      candidates_(candidates),
      options_(options),
      work_(work),
      random_(options.seed),
      draws_left_(kMaxDraws) {}

std::optional<Candidate> ShapeSearch::Next() {
  const double enough = -std::log(options_.missed_shape_probability);
  const double min_points = options_.min_inliers / points_.weight;
  double expected_hits_per_point = 0;  // by the draws so far
  while (static_cast<double>(candidates_.available_count()) >= min_points) {
    work_.Poll();
    const Candidate* leader = candidates_.Leader();
    if (leader && static_cast<double>(leader->inliers.size()) < min_points) leader = nullptr;
    const double sought = leader ? static_cast<double>(leader->inliers.size()) : min_points;
    // P(missed) of a shape of `sought` points is at most exp(-expected hits).
    if (expected_hits_per_point * sought >= enough) {
      return leader ? std::optional<Candidate>(*leader) : std::nullopt;
    }
    if (draws_left_ < kDrawsPerLeaderCheck) {
      is_exhausted_ = true;
      return leader ? std::optional<Candidate>(*leader) : std::nullopt;
    }
    for (int k = 0; k < kDrawsPerLeaderCheck; ++k) Draw();
    draws_left_ -= kDrawsPerLeaderCheck;
    expected_hits_per_point += kDrawsPerLeaderCheck * kDrawSuccessProbability /
                               static_cast<double>(candidates_.available_count());
  }
  return std::nullopt;
}

void ShapeSearch::Draw() {
  // Next() draws only while points are available.
  const std::optional<DrawnSample> drawn = DrawSample(octree_, candidates_.available(), random_);
  if (!drawn) return;
  const std::span<const std::uint32_t> sample(drawn->points.data(), 3);
  const std::uint32_t tester = drawn->points[3];
  if (options_.search_planes) Propose<PlaneModel>(sample, tester);
  if (options_.search_spheres) Propose<SphereModel>(sample, tester);
  if (options_.search_cylinders) Propose<CylinderModel>(sample, tester);
  if (options_.search_cones) Propose<ConeModel>(sample, tester);
}

template <ShapeModel M>
void ShapeSearch::Propose(std::span<const std::uint32_t> sample, std::uint32_t tester) {
  typename M::Sample minimal;
  for (std::size_t k = 0; k < minimal.size(); ++k) {
    minimal[k] = {points_.p[sample[k]], points_.n[sample[k]]};
  }
  const std::optional<M> model = M::FromSample(minimal);
  if (!model) return;
  if constexpr (!std::is_same_v<M, PlaneModel>) {
    if (!(model->radius_m >= options_.min_radius_m && model->radius_m <= options_.max_radius_m)) {
      return;
    }
  }
  for (std::size_t k = 0; k < minimal.size(); ++k) {
    if (!IsInlier(*model, points_, sample[k])) return;
  }
  if (IsInlier(*model, points_, tester)) candidates_.Add(*model);
}

}  // namespace cwm::perception
