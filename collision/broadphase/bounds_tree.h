// A persistent tree over axis-aligned boxes: who may be within a distance of a box, or on a ray.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "absl/container/inlined_vector.h"
#include "collision/broadphase/place_key.h"
#include "collision/broadphase/slab_ray.h"
#include "collision/geometry/aabb.h"

namespace cwm::collision {

// Square of the distance of two boxes, 0 when they overlap. Meaningless for empty boxes.
inline double SquaredDistance_m2(const Aabb& a, const Aabb& b) {
  const Eigen::Array3d gap = (a.min() - b.max()).array().max((b.min() - a.max()).array()).max(0.0);
  return gap.square().sum();
}

// Distance of two boxes, 0 when they overlap. Meaningless for empty boxes.
inline double Distance_m(const Aabb& a, const Aabb& b) {
  return std::sqrt(SquaredDistance_m2(a, b));
}

// Immutable: With and Without make a tree that shares all nodes but those on one path, which are as
// many as the logarithm of the count where boxes are spread. A binary trie over PlaceKey: its shape
// is told by what is in it alone, whatever the order of insertion. Unbounded boxes (half-spaces)
// are allowed and kept beside it; empty boxes are never found.
//
// The tree refers to items that somebody else keeps alive and unchanged. Of an item it knows
//   const Aabb& BoundsOf(const Item&)           its box
//   bool Precedes(const Item&, const Item&)     a total order, which decides among equally near
//   ones std::uint64_t SaltOf(const Item&)           a hash, which tells items of one centre apart
template <class Item>
class BoundsTree {
 public:
  BoundsTree() = default;
  explicit BoundsTree(std::span<const Item* const> items);

  // `item` must not be in the tree yet, or be in it, respectively.
  BoundsTree With(const Item& item) const;
  BoundsTree Without(const Item& item) const;

  // Calls visit(item) for each whose box is within `distance_m` of `box` (touching counts), in an
  // order that follows from the items alone. A visitor that returns bool ends the walk by returning
  // false.
  template <class Visit>
  void ForEachWithin(const Aabb& box, double distance_m, Visit&& visit) const;

  // Nearest first, equally near ones by Precedes: visit(item, lower_bound_m) returns the distance
  // beyond which nothing matters any more (its best answer so far); boxes farther away are skipped.
  template <class Visit>
  void ForEachNearest(const Aabb& box, double max_distance_m, Visit&& visit) const;

  // Boxes hit by a ray, nearest entry first; visit(item, entry_m) returns the length that still
  // matters. The direction need not be unit; lengths are in its units.
  template <class Visit>
  void ForEachOnRay(const Vector3& origin, const Vector3& direction, double max_distance_m,
                    Visit&& visit) const;

  // Nodes that this tree has and `other` does not share: what the difference costs.
  std::size_t CountOwnNodes(const BoundsTree& other) const;

 private:
  // Boxes a leaf holds. Testing four boxes costs about as much as visiting one more node.
  static constexpr std::size_t kLeafSize = 4;

  struct Entry {
    Aabb box;
    const Item* item;
  };
  using Entries = absl::InlinedVector<Entry, kLeafSize>;

  struct Node {
    Aabb bounds;
    std::size_t count = 0;
    int bit = -1;  // in which the two halves differ first; -1: a leaf
  };
  using NodePtr = std::shared_ptr<const Node>;
  struct Inner : Node {
    PlaceKey key;  // all in it agree with this one before `bit`
    NodePtr low, high;
  };
  struct Leaf : Node {
    Entries entries;
  };
  static const Inner& AsInner(const Node& node) { return static_cast<const Inner&>(node); }
  static const Leaf& AsLeaf(const Node& node) { return static_cast<const Leaf&>(node); }

  // A node or an item (where `node` is null) that waits in the queue of a best-first walk.
  struct Waiting {
    double key;
    const Node* node;
    const Item* item;

    // The later one in a walk. Nodes go before items of the same key, so that equally near items
    // are known before the first of them is visited.
    friend bool operator<(const Waiting& a, const Waiting& b) {
      if (a.key != b.key) return a.key > b.key;
      if (a.node != nullptr || b.node != nullptr) return a.node == nullptr && b.node != nullptr;
      return Precedes(*b.item, *a.item);
    }
  };

  static PlaceKey KeyOf(const Entry& entry) {
    return collision::KeyOf(entry.box, SaltOf(*entry.item));
  }
  static bool IsBounded(const Aabb& box) { return box.min().allFinite() && box.max().allFinite(); }
  static NodePtr MakeLeaf(Entries entries);
  static NodePtr MakeInner(int bit, const PlaceKey& key, NodePtr low, NodePtr high);
  static NodePtr Build(std::span<Entry> entries);
  static NodePtr Insert(const NodePtr& node, const Entry& entry, const PlaceKey& key);
  static NodePtr Remove(const NodePtr& node, const Item& item, const PlaceKey& key);
  static void Collect(const Node& node, Entries& entries);
  static void Drop(const Item& item, Entries& entries) {
    entries.erase(std::find_if(entries.begin(), entries.end(),
                               [&](const Entry& entry) { return entry.item == &item; }));
  }

  // `key(bounds)` is the quantity that grows along the walk; it may not shrink from a node to what
  // is in it.
  template <class Key, class Visit>
  void BestFirst(double limit, const Key& key, Visit&& visit) const;

  NodePtr root_;
  // Few: one half-space bounds a room. Ordered by Precedes; null when there are none.
  std::shared_ptr<const std::vector<Entry>> unbounded_;
};

template <class Item>
BoundsTree<Item>::BoundsTree(std::span<const Item* const> items) {
  std::vector<Entry> entries;
  for (const Item* item : items) {
    const Aabb& box = BoundsOf(*item);
    if (box.isEmpty()) continue;
    if (IsBounded(box)) {
      entries.push_back({box, item});
    } else {
      *this = With(*item);
    }
  }
  if (!entries.empty()) root_ = Build(entries);
}

template <class Item>
BoundsTree<Item> BoundsTree<Item>::With(const Item& item) const {
  const Entry entry{BoundsOf(item), &item};
  BoundsTree next = *this;
  if (entry.box.isEmpty()) return next;
  if (IsBounded(entry.box)) {
    next.root_ = root_ == nullptr ? MakeLeaf({entry}) : Insert(root_, entry, KeyOf(entry));
    return next;
  }
  auto unbounded = unbounded_ == nullptr ? std::make_shared<std::vector<Entry>>()
                                         : std::make_shared<std::vector<Entry>>(*unbounded_);
  const auto at = std::find_if(unbounded->begin(), unbounded->end(),
                               [&](const Entry& other) { return Precedes(item, *other.item); });
  unbounded->insert(at, entry);
  next.unbounded_ = std::move(unbounded);
  return next;
}

template <class Item>
BoundsTree<Item> BoundsTree<Item>::Without(const Item& item) const {
  const Entry entry{BoundsOf(item), &item};
  BoundsTree next = *this;
  if (entry.box.isEmpty()) return next;
  if (IsBounded(entry.box)) {
    next.root_ = Remove(root_, item, KeyOf(entry));
    return next;
  }
  auto unbounded = std::make_shared<std::vector<Entry>>(*unbounded_);
  std::erase_if(*unbounded, [&](const Entry& other) { return other.item == &item; });
  next.unbounded_ = std::move(unbounded);
  return next;
}

template <class Item>
auto BoundsTree<Item>::MakeLeaf(Entries entries) -> NodePtr {
  auto leaf = std::make_shared<Leaf>();
  std::sort(entries.begin(), entries.end(),
            [](const Entry& a, const Entry& b) { return Precedes(*a.item, *b.item); });
  for (const Entry& entry : entries) leaf->bounds.extend(entry.box);
  leaf->count = entries.size();
  leaf->entries = std::move(entries);
  return leaf;
}

template <class Item>
auto BoundsTree<Item>::MakeInner(int bit, const PlaceKey& key, NodePtr low, NodePtr high)
    -> NodePtr {
  auto inner = std::make_shared<Inner>();
  inner->bounds = low->bounds.merged(high->bounds);
  inner->count = low->count + high->count;
  inner->bit = bit;
  inner->key = key;
  inner->low = std::move(low);
  inner->high = std::move(high);
  return inner;
}

template <class Item>
auto BoundsTree<Item>::Build(std::span<Entry> entries) -> NodePtr {
  const PlaceKey key = KeyOf(entries.front());
  int bit = -1;
  if (entries.size() > kLeafSize) {
    for (const Entry& entry : entries) bit = std::max(bit, FirstDifference(key, KeyOf(entry)));
  }
  if (bit < 0) return MakeLeaf({entries.begin(), entries.end()});
  const auto middle = std::partition(entries.begin(), entries.end(),
                                     [&](const Entry& entry) { return !BitAt(KeyOf(entry), bit); });
  return MakeInner(bit, key, Build({entries.begin(), middle}), Build({middle, entries.end()}));
}

template <class Item>
auto BoundsTree<Item>::Insert(const NodePtr& node, const Entry& entry, const PlaceKey& key)
    -> NodePtr {
  if (node->bit < 0) {
    Entries entries = AsLeaf(*node).entries;
    entries.push_back(entry);
    return Build({entries.data(), entries.size()});
  }
  const Inner& inner = AsInner(*node);
  const int bit = FirstDifference(key, inner.key);
  if (bit > inner.bit) {  // beside all that is in the node
    NodePtr leaf = MakeLeaf({entry});
    return BitAt(key, bit) ? MakeInner(bit, key, node, std::move(leaf))
                           : MakeInner(bit, key, std::move(leaf), node);
  }
  return BitAt(key, inner.bit)
             ? MakeInner(inner.bit, inner.key, inner.low, Insert(inner.high, entry, key))
             : MakeInner(inner.bit, inner.key, Insert(inner.low, entry, key), inner.high);
}

template <class Item>
auto BoundsTree<Item>::Remove(const NodePtr& node, const Item& item, const PlaceKey& key)
    -> NodePtr {
  if (node->count <= kLeafSize + 1) {  // what stays is one leaf, unless it holds equal keys already
    Entries entries;
    Collect(*node, entries);
    Drop(item, entries);
    return entries.empty() ? nullptr : Build({entries.data(), entries.size()});
  }
  if (node->bit < 0) {
    Entries entries = AsLeaf(*node).entries;
    Drop(item, entries);
    return MakeLeaf(std::move(entries));
  }
  const Inner& inner = AsInner(*node);
  const bool is_high = BitAt(key, inner.bit);
  NodePtr rest = Remove(is_high ? inner.high : inner.low, item, key);
  if (rest == nullptr) return is_high ? inner.low : inner.high;
  return is_high ? MakeInner(inner.bit, inner.key, inner.low, std::move(rest))
                 : MakeInner(inner.bit, inner.key, std::move(rest), inner.high);
}

template <class Item>
void BoundsTree<Item>::Collect(const Node& node, Entries& entries) {
  if (node.bit < 0) {
    const Entries& own = AsLeaf(node).entries;
    entries.insert(entries.end(), own.begin(), own.end());
    return;
  }
  Collect(*AsInner(node).low, entries);
  Collect(*AsInner(node).high, entries);
}

template <class Item>
template <class Visit>
void BoundsTree<Item>::ForEachWithin(const Aabb& box, double distance_m, Visit&& visit) const {
  const double limit_m2 = distance_m < 0 ? -1 : distance_m * distance_m;
  const auto call = [&](const Entry& entry) {
    if (SquaredDistance_m2(box, entry.box) > limit_m2) return true;
    if constexpr (std::is_same_v<decltype(visit(*entry.item)), bool>) {
      return visit(*entry.item);
    } else {
      visit(*entry.item);
      return true;
    }
  };
  if (unbounded_ != nullptr && !std::all_of(unbounded_->begin(), unbounded_->end(), call)) return;
  if (root_ == nullptr) return;
  absl::InlinedVector<const Node*, 64> stack = {root_.get()};
  while (!stack.empty()) {
    const Node& node = *stack.back();
    stack.pop_back();
    if (SquaredDistance_m2(box, node.bounds) > limit_m2) continue;
    if (node.bit >= 0) {
      stack.push_back(AsInner(node).high.get());
      stack.push_back(AsInner(node).low.get());
      continue;
    }
    const Entries& entries = AsLeaf(node).entries;
    if (!std::all_of(entries.begin(), entries.end(), call)) return;
  }
}

template <class Item>
template <class Key, class Visit>
void BoundsTree<Item>::BestFirst(double limit, const Key& key, Visit&& visit) const {
  // Room for the walks of a few hundred boxes without a heap allocation.
  absl::InlinedVector<Waiting, 96> queue;
  const auto push = [&](double k, const Node* node, const Item* item) {
    if (!(k <= limit)) return;
    queue.push_back({k, node, item});
    std::push_heap(queue.begin(), queue.end());
  };
  if (unbounded_ != nullptr) {
    for (const Entry& entry : *unbounded_) push(key(entry.box), nullptr, entry.item);
  }
  if (root_ != nullptr) push(key(root_->bounds), root_.get(), nullptr);
  while (!queue.empty()) {
    std::pop_heap(queue.begin(), queue.end());
    const Waiting next = queue.back();
    queue.pop_back();
    if (next.key > limit) return;  // all that waits is at least as far
    if (next.node == nullptr) {
      limit = std::min<double>(limit, visit(*next.item, next.key));
      continue;
    }
    if (next.node->bit < 0) {
      for (const Entry& entry : AsLeaf(*next.node).entries)
        push(key(entry.box), nullptr, entry.item);
      continue;
    }
    const Inner& inner = AsInner(*next.node);
    push(key(inner.low->bounds), inner.low.get(), nullptr);
    push(key(inner.high->bounds), inner.high.get(), nullptr);
  }
}

template <class Item>
template <class Visit>
void BoundsTree<Item>::ForEachNearest(const Aabb& box, double max_distance_m, Visit&& visit) const {
  BestFirst(
      max_distance_m, [&](const Aabb& other) { return std::sqrt(SquaredDistance_m2(box, other)); },
      visit);
}

template <class Item>
template <class Visit>
void BoundsTree<Item>::ForEachOnRay(const Vector3& origin, const Vector3& direction,
                                    double max_distance_m, Visit&& visit) const {
  const SlabRay ray(origin, direction);
  // A miss is infinite; a limit that is infinite too must not let it in.
  const double limit_m = std::min(max_distance_m, std::numeric_limits<double>::max());
  BestFirst(
      limit_m, [&](const Aabb& box) { return ray.Entry_m(box); }, visit);
}

template <class Item>
std::size_t BoundsTree<Item>::CountOwnNodes(const BoundsTree& other) const {
  std::vector<const Node*> theirs, stack;
  const auto all_of = [&](const BoundsTree& tree, const auto& visit) {
    if (tree.root_ != nullptr) stack.push_back(tree.root_.get());
    while (!stack.empty()) {
      const Node& node = *stack.back();
      stack.pop_back();
      visit(node);
      if (node.bit < 0) continue;
      stack.push_back(AsInner(node).low.get());
      stack.push_back(AsInner(node).high.get());
    }
  };
  all_of(other, [&](const Node& node) { theirs.push_back(&node); });
  std::sort(theirs.begin(), theirs.end());
  std::size_t own = 0;
  all_of(*this, [&](const Node& node) {
    own += std::binary_search(theirs.begin(), theirs.end(), &node) ? 0 : 1;
  });
  return own;
}

}  // namespace cwm::collision
