// A persistent tree over axis-aligned boxes: finds the boxes within a distance of a box, or on a
// ray.
#pragma once

#include <algorithm>
#include <atomic>
#include <boost/smart_ptr/intrusive_ptr.hpp>
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
#include "collision/broadphase/morton_code.h"
#include "collision/broadphase/outer_box.h"
#include "collision/broadphase/slab_ray.h"
#include "collision/geometry/aabb.h"

namespace cwm::collision {

// The squared distance of two boxes, 0 if they overlap. Undefined for empty boxes.
inline double SquaredDistance_m2(const Aabb& a, const Aabb& b) {
  const Eigen::Array3d gap = (a.min() - b.max()).array().max((b.min() - a.max()).array()).max(0.0);
  return gap.square().sum();
}

// The distance of two boxes, 0 if they overlap. Undefined for empty boxes.
inline double Distance_m(const Aabb& a, const Aabb& b) {
  return std::sqrt(SquaredDistance_m2(a, b));
}

// Immutable. With and Without return a tree that shares all nodes except those on one path; the
// path's length grows with the logarithm of the count if the boxes are spread out. The tree is a
// binary trie over MortonCode, so its shape depends on its contents alone, not on the order of
// insertion. Unbounded boxes (half-spaces) are allowed and kept beside the trie; empty boxes are
// never found.
//
// The tree refers to items that its owner keeps alive and unchanged. Three functions describe an
// item:
//   const Aabb& BoundsOf(const Item&)          its box
//   bool Precedes(const Item&, const Item&)    a total order, which breaks ties in distance
//   std::uint64_t SaltOf(const Item&)          a hash, which separates items with equal centres
template <class Item>
class BoundsTree {
 public:
  BoundsTree() = default;
  explicit BoundsTree(std::span<const Item* const> items);

  // `item` must not be in the tree before With, and must be in it before Without.
  BoundsTree With(const Item& item) const;
  BoundsTree Without(const Item& item) const;

  // Calls visit(item) for each item whose box is within `distance_m` of `box` (touching counts), in
  // an order that depends on the items alone. A visitor that returns bool ends the walk by
  // returning false.
  template <class Visit>
  void ForEachWithin(const Aabb& box, double distance_m, Visit&& visit) const;

  // Visits the nearest item first; Precedes breaks ties. visit(item, lower_bound_m) returns the
  // distance beyond which items are of no interest (its best answer so far); boxes farther away are
  // skipped.
  template <class Visit>
  void ForEachNearest(const Aabb& box, double max_distance_m, Visit&& visit) const;

  // Visits the boxes that a ray hits, nearest entry first. visit(item, entry_m) returns the length
  // of the ray that is still of interest. `direction` need not be a unit vector; lengths are
  // multiples of its norm.
  template <class Visit>
  void ForEachOnRay(const Vector3& origin, const Vector3& direction, double max_distance_m,
                    Visit&& visit) const;

  // The number of nodes that this tree does not share with `other`: the cost of their difference.
  std::size_t CountUnsharedNodes(const BoundsTree& other) const;

 private:
  // Boxes per leaf. Testing four boxes costs about as much as visiting one more node.
  static constexpr std::size_t kLeafSize = 4;

  struct Inner;
  struct Leaf;
  struct Entry {
    explicit Entry(const Item& it) : outer(BoundsOf(it)), item(&it) {}
    const Aabb& box() const { return BoundsOf(*item); }
    OuterBox outer;  // rejects most distant items without reading them
    const Item* item;
  };
  using Entries = absl::InlinedVector<Entry, kLeafSize>;

  // Nodes are small because every kept revision of the world owns the two paths that its change
  // copied. A node therefore holds its own reference count, shows its kind by `bit`, and has bounds
  // of floats.
  struct Node {
    mutable std::atomic<std::uint32_t> references = 0;
    std::uint32_t count = 0;  // number of boxes below
    OuterBox bounds;
    int bit = -1;  // the highest bit in which the keys of the two halves differ; -1 for a leaf

    friend void intrusive_ptr_add_ref(const Node* node) {
      node->references.fetch_add(1, std::memory_order_relaxed);
    }
    friend void intrusive_ptr_release(const Node* node) {
      if (node->references.fetch_sub(1, std::memory_order_acq_rel) != 1) return;
      if (node->bit < 0) {
        delete static_cast<const Leaf*>(node);
      } else {
        delete static_cast<const Inner*>(node);
      }
    }
  };
  using NodePtr = boost::intrusive_ptr<const Node>;
  struct Inner : Node {
    NodePtr low, high;
  };
  struct Leaf : Node {
    Entries entries;
  };
  static const Inner& AsInner(const Node& node) { return static_cast<const Inner&>(node); }
  static const Leaf& AsLeaf(const Node& node) { return static_cast<const Leaf&>(node); }

  // A node, or an item if `node` is null, in the queue of a best-first walk.
  struct QueueEntry {
    double key;
    const Node* node;
    const Item* item;

    // True if `a` comes later in the walk. Nodes go before items of the same key, so that all
    // equally near items are in the queue before the first of them is visited.
    friend bool operator<(const QueueEntry& a, const QueueEntry& b) {
      if (a.key != b.key) return a.key > b.key;
      if (a.node != nullptr || b.node != nullptr) return a.node == nullptr && b.node != nullptr;
      return Precedes(*b.item, *a.item);
    }
  };

  static MortonCode KeyOf(const Entry& entry) {
    return collision::KeyOf(entry.box(), SaltOf(*entry.item));
  }
  static bool IsBounded(const Aabb& box) { return box.min().allFinite() && box.max().allFinite(); }
  static NodePtr MakeLeaf(Entries entries);
  static NodePtr MakeInner(int bit, NodePtr low, NodePtr high);
  static NodePtr Build(std::span<Entry> entries);
  static NodePtr Insert(const NodePtr& node, const Entry& entry);
  static NodePtr InsertAt(int bit, const NodePtr& node, const Entry& entry, const MortonCode& key);
  static NodePtr Remove(const NodePtr& node, const Item& item, const MortonCode& key);
  static void Collect(const Node& node, Entries& entries);
  static void Drop(const Item& item, Entries& entries) {
    entries.erase(std::find_if(entries.begin(), entries.end(),
                               [&](const Entry& entry) { return entry.item == &item; }));
  }

  // Visits items in increasing order of `key(bounds)`. The key of a node must not be larger than
  // the keys of its contents.
  template <class Key, class Visit>
  void BestFirst(double limit, const Key& key, Visit&& visit) const;

  NodePtr root_;
  // The unbounded items, ordered by Precedes; null if there are none. A world has few: one
  // half-space bounds a room.
  std::shared_ptr<const std::vector<const Item*>> unbounded_;
};

template <class Item>
BoundsTree<Item>::BoundsTree(std::span<const Item* const> items) {
  std::vector<Entry> entries;
  for (const Item* item : items) {
    const Aabb& box = BoundsOf(*item);
    if (box.isEmpty()) continue;
    if (IsBounded(box)) {
      entries.emplace_back(*item);
    } else {
      *this = With(*item);
    }
  }
  if (!entries.empty()) root_ = Build(entries);
}

template <class Item>
BoundsTree<Item> BoundsTree<Item>::With(const Item& item) const {
  BoundsTree next = *this;
  if (BoundsOf(item).isEmpty()) return next;
  if (IsBounded(BoundsOf(item))) {
    const Entry entry(item);
    next.root_ = root_ == nullptr ? MakeLeaf({entry}) : Insert(root_, entry);
    return next;
  }
  auto unbounded = unbounded_ == nullptr ? std::make_shared<std::vector<const Item*>>()
                                         : std::make_shared<std::vector<const Item*>>(*unbounded_);
  const auto at = std::find_if(unbounded->begin(), unbounded->end(),
                               [&](const Item* other) { return Precedes(item, *other); });
  unbounded->insert(at, &item);
  next.unbounded_ = std::move(unbounded);
  return next;
}

template <class Item>
BoundsTree<Item> BoundsTree<Item>::Without(const Item& item) const {
  BoundsTree next = *this;
  if (BoundsOf(item).isEmpty()) return next;
  if (IsBounded(BoundsOf(item))) {
    next.root_ = Remove(root_, item, KeyOf(Entry(item)));
    return next;
  }
  auto unbounded = std::make_shared<std::vector<const Item*>>(*unbounded_);
  std::erase(*unbounded, &item);
  next.unbounded_ = std::move(unbounded);
  return next;
}

template <class Item>
auto BoundsTree<Item>::MakeLeaf(Entries entries) -> NodePtr {
  boost::intrusive_ptr<Leaf> leaf(new Leaf);
  std::sort(entries.begin(), entries.end(),
            [](const Entry& a, const Entry& b) { return Precedes(*a.item, *b.item); });
  for (const Entry& entry : entries) leaf->bounds = OuterBox::Merged(leaf->bounds, entry.outer);
  leaf->count = static_cast<std::uint32_t>(entries.size());
  leaf->entries = std::move(entries);
  return leaf;
}

template <class Item>
auto BoundsTree<Item>::MakeInner(int bit, NodePtr low, NodePtr high) -> NodePtr {
  boost::intrusive_ptr<Inner> inner(new Inner);
  inner->bounds = OuterBox::Merged(low->bounds, high->bounds);
  inner->count = low->count + high->count;
  inner->bit = bit;
  inner->low = std::move(low);
  inner->high = std::move(high);
  return inner;
}

template <class Item>
auto BoundsTree<Item>::Build(std::span<Entry> entries) -> NodePtr {
  const MortonCode key = KeyOf(entries.front());
  int bit = -1;
  if (entries.size() > kLeafSize) {
    for (const Entry& entry : entries) bit = std::max(bit, FirstDifference(key, KeyOf(entry)));
  }
  if (bit < 0) return MakeLeaf({entries.begin(), entries.end()});
  const auto middle = std::partition(entries.begin(), entries.end(),
                                     [&](const Entry& entry) { return !BitAt(KeyOf(entry), bit); });
  return MakeInner(bit, Build({entries.begin(), middle}), Build({middle, entries.end()}));
}

// Walks down by the bits of the key to some leaf. The entry may not belong there, but no key in the
// tree shares a longer prefix with it than the keys of that leaf (Morrison 1968).
template <class Item>
auto BoundsTree<Item>::Insert(const NodePtr& node, const Entry& entry) -> NodePtr {
  const MortonCode key = KeyOf(entry);
  const Node* nearest = node.get();
  while (nearest->bit >= 0) {
    const Inner& inner = AsInner(*nearest);
    nearest = (BitAt(key, inner.bit) ? inner.high : inner.low).get();
  }
  return InsertAt(FirstDifference(key, KeyOf(AsLeaf(*nearest).entries.front())), node, entry, key);
}

// `bit` is the first bit in which `key` differs from the keys that share its longest prefix.
template <class Item>
auto BoundsTree<Item>::InsertAt(int bit, const NodePtr& node, const Entry& entry,
                                const MortonCode& key) -> NodePtr {
  if (node->bit < 0) {
    Entries entries = AsLeaf(*node).entries;
    entries.push_back(entry);
    return Build({entries.data(), entries.size()});
  }
  if (bit > node->bit) {  // a sibling of the whole node
    NodePtr leaf = MakeLeaf({entry});
    return BitAt(key, bit) ? MakeInner(bit, node, std::move(leaf))
                           : MakeInner(bit, std::move(leaf), node);
  }
  const Inner& inner = AsInner(*node);
  return BitAt(key, inner.bit)
             ? MakeInner(inner.bit, inner.low, InsertAt(bit, inner.high, entry, key))
             : MakeInner(inner.bit, InsertAt(bit, inner.low, entry, key), inner.high);
}

template <class Item>
auto BoundsTree<Item>::Remove(const NodePtr& node, const Item& item, const MortonCode& key)
    -> NodePtr {
  if (node->count <= kLeafSize + 1) {  // the rest fits in one leaf, unless all keys are equal
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
  return is_high ? MakeInner(inner.bit, inner.low, std::move(rest))
                 : MakeInner(inner.bit, std::move(rest), inner.high);
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
  const auto call = [&](const Item& item) {
    if (SquaredDistance_m2(box, BoundsOf(item)) > limit_m2) return true;
    if constexpr (std::is_same_v<decltype(visit(item)), bool>) {
      return visit(item);
    } else {
      visit(item);
      return true;
    }
  };
  if (unbounded_ != nullptr) {
    for (const Item* item : *unbounded_) {
      if (!call(*item)) return;
    }
  }
  if (root_ == nullptr) return;
  absl::InlinedVector<const Node*, 64> stack = {root_.get()};
  while (!stack.empty()) {
    const Node& node = *stack.back();
    stack.pop_back();
    if (SquaredDistance_m2(box, node.bounds.aabb()) > limit_m2) continue;
    if (node.bit >= 0) {
      stack.push_back(AsInner(node).high.get());
      stack.push_back(AsInner(node).low.get());
      continue;
    }
    for (const Entry& entry : AsLeaf(node).entries) {
      if (SquaredDistance_m2(box, entry.outer.aabb()) > limit_m2) continue;
      if (!call(*entry.item)) return;
    }
  }
}

template <class Item>
template <class Key, class Visit>
void BoundsTree<Item>::BestFirst(double limit, const Key& key, Visit&& visit) const {
  // Walks over a few hundred boxes need no heap allocation.
  absl::InlinedVector<QueueEntry, 96> queue;
  const auto push = [&](double k, const Node* node, const Item* item) {
    if (!(k <= limit)) return;
    queue.push_back({k, node, item});
    std::push_heap(queue.begin(), queue.end());
  };
  if (unbounded_ != nullptr) {
    for (const Item* item : *unbounded_) push(key(BoundsOf(*item)), nullptr, item);
  }
  if (root_ != nullptr) push(key(root_->bounds.aabb()), root_.get(), nullptr);
  while (!queue.empty()) {
    std::pop_heap(queue.begin(), queue.end());
    const QueueEntry next = queue.back();
    queue.pop_back();
    if (next.key > limit) return;  // everything left in the queue is at least as far
    if (next.node == nullptr) {
      limit = std::min<double>(limit, visit(*next.item, next.key));
      continue;
    }
    if (next.node->bit < 0) {
      for (const Entry& entry : AsLeaf(*next.node).entries) {
        if (key(entry.outer.aabb()) <= limit) push(key(entry.box()), nullptr, entry.item);
      }
      continue;
    }
    const Inner& inner = AsInner(*next.node);
    push(key(inner.low->bounds.aabb()), inner.low.get(), nullptr);
    push(key(inner.high->bounds.aabb()), inner.high.get(), nullptr);
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
  // A missed box has an infinite key, which an infinite limit must not admit.
  const double limit_m = std::min(max_distance_m, std::numeric_limits<double>::max());
  BestFirst(
      limit_m, [&](const Aabb& box) { return ray.Entry_m(box); }, visit);
}

template <class Item>
std::size_t BoundsTree<Item>::CountUnsharedNodes(const BoundsTree& other) const {
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
