#include "collision/world/object_table.h"

#include <algorithm>
#include <boost/smart_ptr/intrusive_ref_counter.hpp>
#include <cmath>
#include <limits>
#include <utility>

namespace cwm::collision {
namespace {

// Rounds up to single precision, as an upper bound must.
float RoundedUp(double value) {
  const auto rounded = static_cast<float>(value);
  return rounded < value ? std::nextafter(rounded, std::numeric_limits<float>::infinity())
                         : rounded;
}

// The largest values of several objects, at least 0.
struct MaxValues {
  float margin_m = 0;
  float sigma_m = 0;

  void Include(const MaxValues& other) {
    margin_m = std::max(margin_m, other.margin_m);
    sigma_m = std::max(sigma_m, other.sigma_m);
  }
};

}  // namespace

// An object, shared by the copies of its node in all versions.
struct ObjectTable::Entry : boost::intrusive_ref_counter<ObjectTable::Entry> {
  explicit Entry(WorldObjectPtr o) : object(std::move(o)) {}
  WorldObjectPtr object;
};

// Nodes are small because every kept revision owns the path that its change copied, some dozen
// nodes. 40 bytes fill a block of the allocator; the next larger block has 56.
struct ObjectTable::Node : boost::intrusive_ref_counter<ObjectTable::Node> {
  std::uint32_t size = 0;
  MaxValues max_values;  // of the objects of this subtree
  EntryPtr entry;
  NodePtr left, right;

  const WorldObjectPtr& object() const { return entry->object; }
  std::string_view name() const { return entry->object->name; }
  static std::uint32_t SizeOf(const NodePtr& node) { return node == nullptr ? 0 : node->size; }
  // True if `a` is above `b` in a tree that has both.
  static bool IsAbove(std::string_view a, std::string_view b) {
    const std::uint64_t hash_a = HashOf(a), hash_b = HashOf(b);
    return hash_a != hash_b ? hash_a > hash_b : a < b;
  }
  bool IsAbove(const Node& other) const { return IsAbove(name(), other.name()); }
};

void intrusive_ptr_add_ref(const ObjectTable::Entry* entry) {
  boost::sp_adl_block::intrusive_ptr_add_ref<ObjectTable::Entry>(entry);
}
void intrusive_ptr_release(const ObjectTable::Entry* entry) {
  boost::sp_adl_block::intrusive_ptr_release<ObjectTable::Entry>(entry);
}
void intrusive_ptr_add_ref(const ObjectTable::Node* node) {
  boost::sp_adl_block::intrusive_ptr_add_ref<ObjectTable::Node>(node);
}
void intrusive_ptr_release(const ObjectTable::Node* node) {
  boost::sp_adl_block::intrusive_ptr_release<ObjectTable::Node>(node);
}

// The parts of a tree before and behind a name.
struct ObjectTable::Halves {
  NodePtr before, behind;
};

std::uint64_t HashOf(std::string_view name) {
  std::uint64_t hash = 0xcbf29ce484222325;  // FNV-1a
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  hash = (hash ^ (hash >> 30)) * 0xbf58476d1ce4e5b9;  // splitmix64: FNV's high bits are poor
  hash = (hash ^ (hash >> 27)) * 0x94d049bb133111eb;
  return hash ^ (hash >> 31);
}

ObjectTable::Iterator::reference ObjectTable::Iterator::operator*() const {
  return path_.back()->object();
}

void ObjectTable::Iterator::Descend(const Node* node) {
  for (; node != nullptr; node = node->left.get()) path_.push_back(node);
}

ObjectTable::Iterator& ObjectTable::Iterator::operator++() {
  const Node* node = path_.back();
  path_.pop_back();
  Descend(node->right.get());
  return *this;
}

ObjectTable::Iterator ObjectTable::Iterator::operator++(int) {
  Iterator before = *this;
  ++*this;
  return before;
}

ObjectTable::ObjectTable(std::span<const WorldObjectPtr> objects) : root_(Build(objects)) {}

std::size_t ObjectTable::size() const { return Node::SizeOf(root_); }

double ObjectTable::max_margin_m() const { return empty() ? 0 : root_->max_values.margin_m; }

double ObjectTable::max_sigma_m() const { return empty() ? 0 : root_->max_values.sigma_m; }

ObjectTable::Iterator ObjectTable::begin() const {
  Iterator first;
  first.Descend(root_.get());
  return first;
}

const WorldObjectPtr& ObjectTable::operator[](std::size_t rank) const {
  const Node* node = root_.get();
  while (true) {
    const std::size_t before = Node::SizeOf(node->left);
    if (rank == before) return node->object();
    if (rank < before) {
      node = node->left.get();
    } else {
      rank -= before + 1;
      node = node->right.get();
    }
  }
}

const WorldObjectPtr* ObjectTable::Find(std::string_view name) const {
  for (const Node* node = root_.get(); node != nullptr;) {
    const int order = name.compare(node->name());
    if (order == 0) return &node->object();
    node = (order < 0 ? node->left : node->right).get();
  }
  return nullptr;
}

std::optional<std::size_t> ObjectTable::RankOf(std::string_view name) const {
  std::size_t rank = 0;
  for (const Node* node = root_.get(); node != nullptr;) {
    const int order = name.compare(node->name());
    if (order == 0) return rank + Node::SizeOf(node->left);
    if (order > 0) rank += Node::SizeOf(node->left) + 1;
    node = (order < 0 ? node->left : node->right).get();
  }
  return std::nullopt;
}

ObjectTable ObjectTable::With(WorldObjectPtr object) const {
  const bool is_known = Find(object->name) != nullptr;
  EntryPtr entry(new Entry(std::move(object)));
  ObjectTable next;
  next.root_ = is_known ? Replace(root_, std::move(entry)) : Insert(root_, std::move(entry));
  return next;
}

ObjectTable ObjectTable::Without(std::string_view name) const {
  if (Find(name) == nullptr) return *this;
  ObjectTable next;
  next.root_ = Remove(root_, name);
  return next;
}

ObjectTable::NodePtr ObjectTable::Make(EntryPtr entry, NodePtr left, NodePtr right) {
  const boost::intrusive_ptr<Node> node(new Node);
  const WorldObject& object = *entry->object;
  node->size = 1 + Node::SizeOf(left) + Node::SizeOf(right);
  node->max_values = {RoundedUp(object.margin_m), RoundedUp(object.geometry->max_sigma_m)};
  if (left != nullptr) node->max_values.Include(left->max_values);
  if (right != nullptr) node->max_values.Include(right->max_values);
  node->entry = std::move(entry);
  node->left = std::move(left);
  node->right = std::move(right);
  return node;
}

ObjectTable::NodePtr ObjectTable::Build(std::span<const WorldObjectPtr> objects) {
  if (objects.empty()) return nullptr;
  // For equal hashes the first name is the root, as in IsAbove.
  const auto root = std::max_element(objects.begin(), objects.end(),
                                     [](const WorldObjectPtr& a, const WorldObjectPtr& b) {
                                       return Node::IsAbove(b->name, a->name);
                                     });
  return Make(EntryPtr(new Entry(*root)), Build({objects.begin(), root}),
              Build({root + 1, objects.end()}));
}

ObjectTable::Halves ObjectTable::Split(const NodePtr& node, std::string_view name) {
  if (node == nullptr) return {};
  if (node->name() < name) {
    Halves right = Split(node->right, name);
    return {Make(node->entry, node->left, std::move(right.before)), std::move(right.behind)};
  }
  Halves left = Split(node->left, name);
  return {std::move(left.before), Make(node->entry, std::move(left.behind), node->right)};
}

ObjectTable::NodePtr ObjectTable::Join(const NodePtr& left, const NodePtr& right) {
  if (left == nullptr) return right;
  if (right == nullptr) return left;
  if (left->IsAbove(*right)) return Make(left->entry, left->left, Join(left->right, right));
  return Make(right->entry, Join(left, right->left), right->right);
}

ObjectTable::NodePtr ObjectTable::Insert(const NodePtr& node, EntryPtr&& entry) {
  if (node == nullptr) return Make(std::move(entry), nullptr, nullptr);
  const bool is_before = entry->object->name < node->name();
  if (Node::IsAbove(entry->object->name, node->name())) {
    Halves halves = Split(node, entry->object->name);
    return Make(std::move(entry), std::move(halves.before), std::move(halves.behind));
  }
  return is_before ? Make(node->entry, Insert(node->left, std::move(entry)), node->right)
                   : Make(node->entry, node->left, Insert(node->right, std::move(entry)));
}

ObjectTable::NodePtr ObjectTable::Replace(const NodePtr& node, EntryPtr&& entry) {
  const int order = std::string_view(entry->object->name).compare(node->name());
  if (order == 0) return Make(std::move(entry), node->left, node->right);
  return order < 0 ? Make(node->entry, Replace(node->left, std::move(entry)), node->right)
                   : Make(node->entry, node->left, Replace(node->right, std::move(entry)));
}

ObjectTable::NodePtr ObjectTable::Remove(const NodePtr& node, std::string_view name) {
  const int order = name.compare(node->name());
  if (order == 0) return Join(node->left, node->right);
  return order < 0 ? Make(node->entry, Remove(node->left, name), node->right)
                   : Make(node->entry, node->left, Remove(node->right, name));
}

// Walks both trees at once and skips shared subtrees. If only one tree has a name, the other is
// split at that name, which copies a path.
struct ObjectTable::DifferenceOf {
  std::vector<ObjectDelta> deltas;

  void operator()(const NodePtr& before, const NodePtr& after) {
    if (before == after) return;
    if (before == nullptr || (after != nullptr && after->IsAbove(*before))) {
      const Halves halves = Split(before, after->name());
      (*this)(halves.before, after->left);
      deltas.push_back({.before = nullptr, .after = after->object()});
      (*this)(halves.behind, after->right);
    } else if (after == nullptr || before->IsAbove(*after)) {
      const Halves halves = Split(after, before->name());
      (*this)(before->left, halves.before);
      deltas.push_back({.before = before->object(), .after = nullptr});
      (*this)(before->right, halves.behind);
    } else {
      (*this)(before->left, after->left);
      Compare(before->object(), after->object());
      (*this)(before->right, after->right);
    }
  }

  void Compare(const WorldObjectPtr& before, const WorldObjectPtr& after) {
    if (before == after) return;
    if (before->IsSameAs(*after)) {
      deltas.push_back({.before = before, .after = after});
    } else {
      deltas.push_back({.before = before, .after = nullptr});
      deltas.push_back({.before = nullptr, .after = after});
    }
  }
};

std::vector<ObjectDelta> ObjectTable::Difference(const ObjectTable& before,
                                                 const ObjectTable& after) {
  DifferenceOf difference;
  difference(before.root_, after.root_);
  return std::move(difference.deltas);
}

}  // namespace cwm::collision
