#include "collision/broadphase/bounds_tree.h"

#include <array>
#include <cmath>
#include <numeric>

namespace cwm::collision {
namespace {

// Boxes a leaf holds. Testing four boxes costs about as much as visiting one more node.
constexpr std::size_t kLeafSize = 2;

// Candidate planes of a split. More than eight gains nothing measurable (Wald 2007, "On fast
// construction of SAH-based bounding volume hierarchies").
constexpr int kBinCount = 8;

double HalfArea_m2(const Aabb& box) {
  if (box.isEmpty()) return 0;
  const Vector3 d = box.sizes();
  return d.x() * d.y() + d.y() * d.z() + d.z() * d.x();
}

struct Bin {
  Aabb bounds;
  std::size_t count = 0;
};

// Surface area heuristic over the bins: the number of bins that go to the left child.
int BestSplit(const std::array<Bin, kBinCount>& bins) {
  std::array<double, kBinCount> right_cost{};
  Bin right;
  for (int i = kBinCount - 1; i > 0; --i) {
    right.bounds.extend(bins[i].bounds);
    right.count += bins[i].count;
    right_cost[i] = HalfArea_m2(right.bounds) * static_cast<double>(right.count);
  }
  Bin left;
  int best = 0;
  double best_cost = std::numeric_limits<double>::infinity();
  std::size_t total = right.count + bins[0].count;
  for (int i = 1; i < kBinCount; ++i) {
    left.bounds.extend(bins[i - 1].bounds);
    left.count += bins[i - 1].count;
    if (left.count == 0 || left.count == total) continue;
    const double cost = HalfArea_m2(left.bounds) * static_cast<double>(left.count) + right_cost[i];
    if (cost < best_cost) {
      best_cost = cost;
      best = i;
    }
  }
  return best;
}

// Where [begin, end) of `order` is cut in two, after reordering; both parts hold at least one box.
std::size_t Partition(std::vector<std::uint32_t>& order, std::size_t begin, std::size_t end,
                      std::span<const Aabb> boxes) {
  Aabb centres;
  for (std::size_t i = begin; i < end; ++i) centres.extend(boxes[order[i]].center());
  int axis = 0;
  const double extent = centres.sizes().maxCoeff(&axis);
  const std::size_t middle = begin + (end - begin) / 2;
  if (!(extent > 0)) return middle;  // all centres coincide: any cut is as good

  const double low = centres.min()[axis];
  const auto bin_of = [&](std::uint32_t box) {
    const double t = (boxes[box].center()[axis] - low) / extent;
    return std::min(kBinCount - 1, static_cast<int>(t * kBinCount));
  };
  std::array<Bin, kBinCount> bins;
  for (std::size_t i = begin; i < end; ++i) {
    Bin& bin = bins[bin_of(order[i])];
    bin.bounds.extend(boxes[order[i]]);
    ++bin.count;
  }
  const int split = BestSplit(bins);
  const auto cut = std::stable_partition(order.begin() + begin, order.begin() + end,
                                         [&](std::uint32_t box) { return bin_of(box) < split; });
  const std::size_t at = cut - order.begin();
  return at > begin && at < end ? at : middle;
}

}  // namespace

double Distance_m(const Aabb& a, const Aabb& b) { return std::sqrt(SquaredDistance_m2(a, b)); }

SlabRay::SlabRay(const Vector3& origin, const Vector3& direction)
    : origin_(origin), inverse_(direction.cwiseInverse()) {}

double SlabRay::Entry_m(const Aabb& box) const {
  constexpr double kMiss = std::numeric_limits<double>::infinity();
  double enter = 0;
  double leave = kMiss;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::isinf(inverse_[axis])) {
      if (origin_[axis] < box.min()[axis] || origin_[axis] > box.max()[axis]) return kMiss;
      continue;
    }
    const double at_min = (box.min()[axis] - origin_[axis]) * inverse_[axis];
    const double at_max = (box.max()[axis] - origin_[axis]) * inverse_[axis];
    enter = std::max(enter, std::min(at_min, at_max));
    leave = std::min(leave, std::max(at_min, at_max));
  }
  return enter <= leave ? enter : kMiss;
}

BoundsTree::BoundsTree(std::span<const Aabb> boxes) : size_(boxes.size()) {
  std::vector<std::uint32_t> order;
  std::vector<std::uint32_t> unbounded;
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    if (boxes[i].isEmpty()) continue;
    const bool finite = boxes[i].min().allFinite() && boxes[i].max().allFinite();
    (finite ? order : unbounded).push_back(i);
  }
  bounded_count_ = order.size();
  nodes_.reserve(order.empty() ? 0 : 2 * order.size());
  if (!order.empty()) Build(order, 0, order.size(), boxes);
  order.insert(order.end(), unbounded.begin(), unbounded.end());
  leaf_boxes_.reserve(order.size());
  for (const std::uint32_t i : order) leaf_boxes_.push_back(boxes[i]);
  leaf_index_ = std::move(order);
}

std::uint32_t BoundsTree::Build(std::vector<std::uint32_t>& order, std::size_t begin,
                                std::size_t end, std::span<const Aabb> boxes) {
  const auto at = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  Aabb bounds;
  for (std::size_t i = begin; i < end; ++i) bounds.extend(boxes[order[i]]);
  nodes_[at].bounds = bounds;
  if (end - begin <= kLeafSize) {
    nodes_[at].second = static_cast<std::uint32_t>(begin);
    nodes_[at].count = static_cast<std::uint32_t>(end - begin);
    return at;
  }
  const std::size_t middle = Partition(order, begin, end, boxes);
  Build(order, begin, middle, boxes);
  const std::uint32_t second = Build(order, middle, end, boxes);
  nodes_[at].second = second;
  return at;
}

}  // namespace cwm::collision
