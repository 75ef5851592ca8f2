// The objects of a snapshot by name, as a persistent sequence: two versions share everything except
// the paths to their differences.
#pragma once

#include <algorithm>
#include <boost/smart_ptr/intrusive_ptr.hpp>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "absl/container/inlined_vector.h"
#include "collision/world/world_object.h"

namespace cwm::collision {

using WorldObjectPtr = std::shared_ptr<const WorldObject>;

// One difference between two versions, for watches and tests.
struct ObjectDelta {
  WorldObjectPtr before;  // nullptr: added
  WorldObjectPtr after;   // nullptr: removed
};

// A hash of a name, the same in every process.
std::uint64_t HashOf(std::string_view name);

// Immutable and ordered by name. A treap (Seidel and Aragon 1996) whose priorities are hashes of
// the names, so that its shape depends on the names alone. Find, With, Without and access by rank
// take logarithmic time; adversarial names can make them linear.
class ObjectTable {
  struct Entry;
  struct Node;
  using EntryPtr = boost::intrusive_ptr<const Entry>;
  using NodePtr = boost::intrusive_ptr<const Node>;
  friend void intrusive_ptr_add_ref(const Entry* entry);
  friend void intrusive_ptr_release(const Entry* entry);
  friend void intrusive_ptr_add_ref(const Node* node);
  friend void intrusive_ptr_release(const Node* node);

 public:
  // Iterates in order of names. A step takes constant time on average.
  class Iterator {
   public:
    using iterator_category = std::forward_iterator_tag;
    using value_type = WorldObjectPtr;
    using difference_type = std::ptrdiff_t;
    using pointer = const WorldObjectPtr*;
    using reference = const WorldObjectPtr&;

    reference operator*() const;
    pointer operator->() const { return &**this; }
    Iterator& operator++();
    Iterator operator++(int);
    friend bool operator==(const Iterator& a, const Iterator& b) {
      return a.path_.empty() ? b.path_.empty()
                             : !b.path_.empty() && a.path_.back() == b.path_.back();
    }

   private:
    friend class ObjectTable;
    void Descend(const Node* node);
    absl::InlinedVector<const Node*, 24> path_;  // the nodes still to visit, the current one last
  };

  ObjectTable() = default;
  // `objects` are ordered by name, each name once.
  explicit ObjectTable(std::span<const WorldObjectPtr> objects);

  std::size_t size() const;
  bool empty() const { return root_ == nullptr; }
  Iterator begin() const;
  Iterator end() const { return {}; }

  // The object of a rank, 0 <= rank < size().
  const WorldObjectPtr& operator[](std::size_t rank) const;
  // nullptr if there is none.
  const WorldObjectPtr* Find(std::string_view name) const;
  std::optional<std::size_t> RankOf(std::string_view name) const;
  // The largest margin of any object, rounded up to single precision; 0 without objects.
  double max_margin_m() const;
  // The same for the standard deviation of any part's surface.
  double max_sigma_m() const;

  // Equal if both have the same objects by address.
  friend bool operator==(const ObjectTable& a, const ObjectTable& b) {
    return a.root_ == b.root_ ||
           (a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin()));
  }
  friend bool operator==(const ObjectTable& a, std::span<const WorldObjectPtr> b) {
    return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin());
  }

  // The table with `object` added, or replacing the object of its name.
  ObjectTable With(WorldObjectPtr object) const;
  // The table without the object of that name, if there is one.
  ObjectTable Without(std::string_view name) const;

  // The differences, ordered by name. An object that was removed and put again gives two deltas,
  // the removal first. If one table was derived from the other, the cost is the number of
  // differences times the logarithm of the size.
  static std::vector<ObjectDelta> Difference(const ObjectTable& before, const ObjectTable& after);

 private:
  struct Halves;
  struct DifferenceOf;

  static NodePtr Make(EntryPtr entry, NodePtr left, NodePtr right);
  static NodePtr Build(std::span<const WorldObjectPtr> objects);
  static Halves Split(const NodePtr& node, std::string_view name);
  static NodePtr Join(const NodePtr& left, const NodePtr& right);
  static NodePtr Insert(const NodePtr& node, EntryPtr&& entry);
  static NodePtr Replace(const NodePtr& node, EntryPtr&& entry);
  static NodePtr Remove(const NodePtr& node, std::string_view name);

  NodePtr root_;
};

}  // namespace cwm::collision
