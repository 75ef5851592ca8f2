#include "collision/world/world_object.h"

#include <bit>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/engines/exact_engine.h"
#include "collision/geometry/quick_bounds.h"
#include "collision/geometry/surface_sigma.h"

namespace cwm::collision {
namespace {

// The work for a part besides preparing it for the engines: a microsecond or two, or up to a
// millisecond for the bounds of many vertices.
constexpr std::size_t kStepsPerPart = 64;
constexpr std::size_t kStepsPerBounds = std::size_t{1} << 14;
std::size_t StepsOf(const Shape& shape) {
  return HasManyVertices(shape) ? kStepsPerBounds : kStepsPerPart;
}

// Collects the parts of a model.
class Preparation {
 public:
  Preparation(PreparedModel& prepared, WorkCounter* work) : prepared_(prepared), work_(work) {}

  // False if `work` stopped it.
  bool Add(PartSource source, int index, const Pose& X_OP, const Shape& shape) {
    PreparedPart part{.source = source,
                      .index = index,
                      .X_OP = X_OP,
                      .shape = shape,
                      .bounds_O = {},
                      .engines = PrepareShape(shape, work_)};
    if (MustEnd(work_, StepsOf(shape))) return false;
    part.bounds_O = BoundsAt(part, X_OP);
    prepared_.weight += QueryCost(shape);
    prepared_.has_caps = prepared_.has_caps || HasCaps(shape);
    prepared_.parts.push_back(std::move(part));
    return true;
  }

 private:
  PreparedModel& prepared_;
  WorkCounter* const work_;
};

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
    case ObjectKind::kMover:
      return "MOVER";
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
  constexpr std::size_t kMaxNameBytes = 128;  // chosen: fits a file name with room for a suffix
  if (name.empty() || name.size() > kMaxNameBytes) return false;
  return std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '.' || c == '/';
  });
}

std::int64_t QueryCost(const Shape& shape) {
  constexpr std::size_t kCornersOfUnit = 64;
  constexpr std::int64_t kOfMesh = 4;
  if (const auto* mesh = std::get_if<Mesh>(&shape)) {
    return kOfMesh + std::bit_width(mesh->mesh->triangles.size());
  }
  std::size_t corners = 0;
  if (const auto* convex = std::get_if<Convex>(&shape)) corners = convex->hull->vertices.size();
  if (const auto* plate = std::get_if<Plate>(&shape)) {
    corners = 2 * plate->outline.size();
    for (const Polygon& hole : plate->holes) corners += 2 * hole.size();
  }
  return 1 + static_cast<std::int64_t>(corners / kCornersOfUnit);
}

Aabb BoundsAt(const PreparedPart& part, const Pose& X_FP) {
  constexpr std::size_t kMaxLinearTriangles = 64;  // chosen: as fast as a search of a tree
  const auto* mesh = std::get_if<Mesh>(&part.shape);
  if (mesh == nullptr || mesh->mesh->triangles.size() <= kMaxLinearTriangles) {
    return TightBounds(part.shape, X_FP);
  }
  return TreeOf(*part.engines[static_cast<int>(EngineKind::kExact)])->BoundsAt(X_FP);
}

std::shared_ptr<const PreparedModel> Prepare(std::shared_ptr<const HybridModel> model,
                                             WorkCounter* work) {
  auto prepared = std::make_shared<PreparedModel>();
  prepared->parts.reserve(model->shapes.size() + model->surfaces.size() + model->handles.size());
  Preparation preparation(*prepared, work);
  for (int i = 0; i < static_cast<int>(model->shapes.size()); ++i) {
    const ShapePart& part = model->shapes[i];
    if (!preparation.Add(PartSource::kShape, i, part.X_OS, part.shape)) return nullptr;
    prepared->parts.back().sigma_m = SurfaceSigma_m(part);
    prepared->max_sigma_m = std::max(prepared->max_sigma_m, prepared->parts.back().sigma_m);
    prepared->max_hidden_m = std::max(prepared->max_hidden_m, HiddenDepth_m(part));
  }
  for (int i = 0; i < static_cast<int>(model->surfaces.size()); ++i) {
    const Mesh& surface = model->surfaces[i].surface;
    if (!HasTriangles(surface)) continue;
    if (!preparation.Add(PartSource::kSurface, i, Pose::Identity(), surface)) return nullptr;
  }
  for (int i = 0; i < static_cast<int>(model->handles.size()); ++i) {
    const Handle& handle = model->handles[i];
    const bool is_whole =
        HasTriangles(handle.surface)
            ? preparation.Add(PartSource::kHandle, i, Pose::Identity(), handle.surface)
            : preparation.Add(PartSource::kHandle, i, handle.bounds.X_FS, handle.bounds.shape);
    if (!is_whole) return nullptr;
  }
  prepared->model = std::move(model);
  return prepared;
}

std::string UidOf(const std::string& name, Revision create_revision) {
  return create_revision.value == 0 ? "" : absl::StrCat(name, "@", create_revision.value);
}

std::shared_ptr<const WorldObject> Place(WorldObject object, WorkCounter* work) {
  object.parts_W.clear();
  object.bounds_W.setEmpty();
  object.parts_W.reserve(object.geometry->parts.size());
  for (const PreparedPart& part : object.geometry->parts) {
    const Pose X_WP = object.X_WO * part.X_OP;
    object.parts_W.push_back({.X_WP = X_WP, .bounds_W = BoundsAt(part, X_WP)});
    if (MustEnd(work, HasManyVertices(part.shape) ? kStepsPerBounds : 1)) return nullptr;
    object.bounds_W.extend(object.parts_W.back().bounds_W);
  }
  return std::make_shared<const WorldObject>(std::move(object));
}

}  // namespace cwm::collision
