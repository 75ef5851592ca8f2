#include "collision/world/world_object.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/geometry/surface_sigma.h"

namespace cwm::collision {
namespace {

PreparedPart PreparePart(PartSource source, int index, const Pose& X_OP, Shape shape) {
  return {.source = source,
          .index = index,
          .X_OP = X_OP,
          .shape = shape,
          .bounds_O = TightBounds(shape, X_OP),
          .engines = PrepareForAll(shape)};
}

bool HasTriangles(const Mesh& surface) {
  return surface.mesh != nullptr && !surface.mesh->triangles.empty();
}

}  // namespace

std::string_view NameOf(ObjectKind kind) {
  switch (kind) {
    case ObjectKind::kSupport:
      return "SUPPORT";
    case ObjectKind::kObject:
      return "OBJECT";
    case ObjectKind::kResidual:
      return "RESIDUAL";
    case ObjectKind::kUnseen:
      return "UNSEEN";
    case ObjectKind::kUser:
      return "USER";
  }
  return "?";
}

std::string_view NameOf(Owner owner) { return owner == Owner::kPerception ? "PERCEPTION" : "USER"; }

std::string_view NameOf(ObjectState state) {
  switch (state) {
    case ObjectState::kConfirmed:
      return "CONFIRMED";
    case ObjectState::kOccluded:
      return "OCCLUDED";
    case ObjectState::kLost:
      return "LOST";
  }
  return "?";
}

bool IsValidName(std::string_view name) {
  constexpr std::size_t kLongestName = 128;  // fits a file name with room for a suffix
  if (name.empty() || name.size() > kLongestName) return false;
  return std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '.' || c == '/';
  });
}

std::shared_ptr<const PreparedModel> Prepare(std::shared_ptr<const HybridModel> model) {
  auto prepared = std::make_shared<PreparedModel>();
  for (int i = 0; i < static_cast<int>(model->shapes.size()); ++i) {
    const ShapePart& part = model->shapes[i];
    prepared->parts.push_back(PreparePart(PartSource::kShape, i, part.X_OS, part.shape));
    prepared->parts.back().sigma_m = SurfaceSigma_m(part);
    prepared->widest_sigma_m = std::max(prepared->widest_sigma_m, prepared->parts.back().sigma_m);
  }
  for (int i = 0; i < static_cast<int>(model->surfaces.size()); ++i) {
    const Mesh& surface = model->surfaces[i].surface;
    if (!HasTriangles(surface)) continue;
    prepared->parts.push_back(PreparePart(PartSource::kSurface, i, Pose::Identity(), surface));
  }
  for (int i = 0; i < static_cast<int>(model->handles.size()); ++i) {
    const Handle& handle = model->handles[i];
    prepared->parts.push_back(
        HasTriangles(handle.surface)
            ? PreparePart(PartSource::kHandle, i, Pose::Identity(), handle.surface)
            : PreparePart(PartSource::kHandle, i, handle.bounds.X_FS, handle.bounds.shape));
  }
  prepared->model = std::move(model);
  return prepared;
}

std::string UidOf(const std::string& name, Revision create_revision) {
  return create_revision.value == 0 ? "" : absl::StrCat(name, "@", create_revision.value);
}

std::shared_ptr<const WorldObject> Place(WorldObject object) {
  object.parts_W.clear();
  object.bounds_W.setEmpty();
  object.parts_W.reserve(object.geometry->parts.size());
  for (const PreparedPart& part : object.geometry->parts) {
    const Pose X_WP = object.X_WO * part.X_OP;
    object.parts_W.push_back({.X_WP = X_WP, .bounds_W = TightBounds(part.shape, X_WP)});
    object.bounds_W.extend(object.parts_W.back().bounds_W);
  }
  return std::make_shared<const WorldObject>(std::move(object));
}

}  // namespace cwm::collision
