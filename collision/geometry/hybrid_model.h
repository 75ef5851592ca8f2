// The hybrid model of one object, M = S u O (paper, section III step 8): shapes with their fit
// quality for points that a primitive explains, triangle meshes for the others. Immutable once
// built, and shared between revisions.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "collision/geometry/aabb.h"
#include "collision/geometry/fit_quality.h"
#include "collision/geometry/shape.h"
#include "collision/geometry/vessel_shell.h"

namespace cwm {

enum class PartRole { kFitted, kCompleted };  // measured, or assumed where nothing was measured

// A bounded solid. The plate of a support is kCompleted, since its body is assumed; its `fit`
// describes the top face, which was measured.
struct ShapePart {
  Pose X_OS = Pose::Identity();  // the shape in the object's frame
  Shape shape;
  PartRole role = PartRole::kFitted;
  std::optional<FitQuality> fit = std::nullopt;  // absent if a user supplied the shape
  // The profile of an open vessel; `shape` is then its watertight mesh. nullptr for other shapes.
  std::shared_ptr<const VesselShell> vessel = nullptr;
  // Space in the object's frame, around the shape, that no sensor saw and into which the body of
  // the part may extend: behind a face whose other side was not seen, as deep as no ray shows it
  // free. Answers about it are bounded, not exact. Absent where nothing is hidden.
  std::optional<Placed<Box>> hidden = std::nullopt;
};

// Signed distance of p (in the shape's frame) from the part's surface, in metres, negative inside.
// A vessel is evaluated by its profile, which is exact and much faster than its mesh.
double SignedDistance_m(const ShapePart& part, const Vector3& p);

// How far the hidden space reaches beyond the shape's bounds along its own axes, at most, in metres.
// 0 if nothing is hidden.
double HiddenDepth_m(const ShapePart& part);

// An open or closed mesh over points that no shape explains, vertices in the object's frame.
struct SurfacePart {
  Mesh surface;
  int point_count = 0;  // measured points that the mesh represents
};

// A cluster grown from a shape's surface (paper, section V), e.g. the handle of a mug.
struct Handle {
  int shape_index = 0;  // into HybridModel::shapes; -1 if it grew from a surface part
  int point_count = 0;
  Vector3 axis_O = Vector3::UnitZ();  // unit vector in the direction of largest extent
  Placed<Box> bounds;                 // in the object's frame, x along the axis
  Mesh surface;                       // in the object's frame; may have no triangles
};

struct HybridModel {
  std::vector<ShapePart> shapes;
  std::vector<SurfacePart> surfaces;
  std::vector<Handle> handles;
  int point_count = 0;  // measured points behind the model; 0 if a user supplied it
};

// Bounds of all parts in frame F, with the object's frame placed at X_FO. Empty for a model without
// parts.
Aabb TightBounds(const HybridModel& model, const Pose& X_FO);

}  // namespace cwm
