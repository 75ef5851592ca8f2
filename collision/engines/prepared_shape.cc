#include "collision/engines/prepared_shape.h"

#include <algorithm>
#include <array>
#include <compare>
#include <map>
#include <mutex>
#include <utility>

#include "collision/geometry/lazy.h"
#include "collision/kernels/exact.h"
#include "collision/kernels/exact_geometry.h"

namespace cwm::collision {

class LazyGeometries {
 public:
  explicit LazyGeometries(Shape shape) : shape_(std::move(shape)) {}

  // nullptr if `work` stopped the construction.
  const EngineGeometry* Get(int engine, WorkCounter* work) const {
    const auto slot = static_cast<std::size_t>(engine);
    if (const auto* form = forms_[slot].GetIfBuilt()) return form->get();
    const auto* exact = exact_.Get([&] { return PrepareExact(shape_, work); }, work);
    if (exact == nullptr) return nullptr;
    const auto* form = forms_[slot].Get(
        [&] { return GetEngine(static_cast<EngineKind>(slot)).PrepareFrom(*exact); }, work);
    return form != nullptr ? form->get() : nullptr;
  }

  void BuildHulls(WorkCounter* work) const {
    const auto* exact = exact_.Get([&] { return PrepareExact(shape_, work); }, work);
    if (exact != nullptr) (*exact)->hulls(work);
  }

 private:
  const Shape shape_;  // keeps the mesh alive, whose address is a key in SharedForms
  Lazy<std::shared_ptr<const ExactGeometry>> exact_;
  std::array<Lazy<std::shared_ptr<const EngineGeometry>>, kEngineCount> forms_;
};

namespace {

// The forms of all meshes and hulls that are alive. An entry that can be locked keeps its mesh
// alive, so that no other mesh can have the same address.
class SharedForms {
 public:
  struct Key {
    const TriangleMesh* mesh;
    ShapeKind kind;
    bool watertight;
    const void* caps;
    friend auto operator<=>(const Key&, const Key&) = default;
  };

  std::shared_ptr<const LazyGeometries> Find(const Key& key, const Shape& shape) {
    const std::lock_guard lock(mutex_);
    std::weak_ptr<const LazyGeometries>& entry = forms_[key];
    if (auto forms = entry.lock()) return forms;
    auto forms = std::make_shared<const LazyGeometries>(shape);
    entry = forms;
    if (forms_.size() >= sweep_at_) Sweep();
    return forms;
  }

 private:
  // Removes expired entries. The threshold is twice the number of live entries, so that the cost
  // per insertion is constant.
  void Sweep() {
    std::erase_if(forms_, [](const auto& entry) { return entry.second.expired(); });
    sweep_at_ = std::max(kMinSweep, 2 * forms_.size());
  }

  static constexpr std::size_t kMinSweep = 64;  // chosen: fewer entries take only a few kilobytes

  std::mutex mutex_;
  std::map<Key, std::weak_ptr<const LazyGeometries>> forms_;
  std::size_t sweep_at_ = kMinSweep;
};

std::shared_ptr<const LazyGeometries> FormsOf(const Shape& shape) {
  static auto* shared = new SharedForms;  // never destroyed: models may outlive static objects
  if (const auto* mesh = std::get_if<Mesh>(&shape)) {
    return shared->Find({mesh->mesh.get(), ShapeKind::kMesh, mesh->watertight, mesh->caps.get()},
                        shape);
  }
  if (const auto* convex = std::get_if<Convex>(&shape)) {
    return shared->Find({convex->hull.get(), ShapeKind::kConvex, true, nullptr}, shape);
  }
  return std::make_shared<const LazyGeometries>(shape);
}

}  // namespace

const EngineGeometry* PreparedShape::operator[](int engine) const {
  return forms_->Get(engine, nullptr);
}

void PreparedShape::BuildHulls(WorkCounter* work) const { forms_->BuildHulls(work); }

PreparedShape PrepareShape(const Shape& shape, WorkCounter* work) {
  PreparedShape prepared;
  prepared.forms_ = FormsOf(shape);
  if (prepared.forms_->Get(static_cast<int>(EngineKind::kExact), work) == nullptr) return {};
  return prepared;
}

}  // namespace cwm::collision
