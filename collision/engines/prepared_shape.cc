#include "collision/engines/prepared_shape.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <compare>
#include <map>
#include <mutex>
#include <utility>

#include "collision/kernels/exact.h"
#include "collision/kernels/exact_geometry.h"

namespace cwm::collision {

// Each form is written once, under its flag, before its pointer is published; readers take the
// pointer alone.
class LazyForms {
 public:
  explicit LazyForms(Shape shape) : shape_(std::move(shape)) {}

  const EngineGeometry* Get(int engine) const {
    const auto slot = static_cast<std::size_t>(engine);
    const EngineGeometry* form = published_[slot].load(std::memory_order_acquire);
    return form != nullptr ? form : Build(slot);
  }

  void BuildHulls() const {
    BuildExact();
    exact_->hulls();
  }

 private:
  void BuildExact() const {
    std::call_once(exact_once_, [this] { exact_ = PrepareExact(shape_); });
  }

  const EngineGeometry* Build(std::size_t slot) const {
    BuildExact();
    std::call_once(once_[slot], [this, slot] {
      forms_[slot] = GetEngine(static_cast<EngineKind>(slot)).PrepareFrom(exact_);
      published_[slot].store(forms_[slot].get(), std::memory_order_release);
    });
    return forms_[slot].get();
  }

  const Shape shape_;  // keeps the mesh alive, whose address is the key in SharedForms
  mutable std::once_flag exact_once_;
  mutable std::shared_ptr<const ExactGeometry> exact_;
  mutable std::array<std::once_flag, kEngineCount> once_;
  mutable std::array<std::shared_ptr<const EngineGeometry>, kEngineCount> forms_;
  mutable std::array<std::atomic<const EngineGeometry*>, kEngineCount> published_ = {};
};

namespace {

// The forms of all meshes and hulls that are alive. An entry that can be locked keeps its mesh
// alive, so that no other mesh can have its address.
class SharedForms {
 public:
  struct Key {
    const TriangleMesh* mesh;
    ShapeKind kind;
    bool watertight;
    friend auto operator<=>(const Key&, const Key&) = default;
  };

  std::shared_ptr<const LazyForms> Find(const Key& key, const Shape& shape) {
    const std::lock_guard lock(mutex_);
    std::weak_ptr<const LazyForms>& entry = forms_[key];
    if (auto forms = entry.lock()) return forms;
    auto forms = std::make_shared<const LazyForms>(shape);
    entry = forms;
    if (forms_.size() >= sweep_at_) Sweep();
    return forms;
  }

 private:
  // At twice the number of live ones: a constant share of the work of inserting.
  void Sweep() {
    std::erase_if(forms_, [](const auto& entry) { return entry.second.expired(); });
    sweep_at_ = std::max(kLeastSweep, 2 * forms_.size());
  }

  static constexpr std::size_t kLeastSweep = 64;  // below, a few kilobytes

  std::mutex mutex_;
  std::map<Key, std::weak_ptr<const LazyForms>> forms_;
  std::size_t sweep_at_ = kLeastSweep;
};

std::shared_ptr<const LazyForms> FormsOf(const Shape& shape) {
  static auto* shared = new SharedForms;  // never destroyed: models may outlive static objects
  if (const auto* mesh = std::get_if<Mesh>(&shape)) {
    return shared->Find({mesh->mesh.get(), ShapeKind::kMesh, mesh->watertight}, shape);
  }
  if (const auto* convex = std::get_if<Convex>(&shape)) {
    return shared->Find({convex->hull.get(), ShapeKind::kConvex, true}, shape);
  }
  return std::make_shared<const LazyForms>(shape);
}

}  // namespace

const EngineGeometry* PreparedShape::operator[](int engine) const { return forms_->Get(engine); }

void PreparedShape::BuildHulls() const { forms_->BuildHulls(); }

PreparedShape PrepareForAll(const Shape& shape) {
  PreparedShape prepared;
  prepared.forms_ = FormsOf(shape);
  prepared.forms_->Get(static_cast<int>(EngineKind::kExact));
  return prepared;
}

}  // namespace cwm::collision
