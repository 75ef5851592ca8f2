// The hybrid model of one object, M = S u O (paper, section III step 8): shapes with their quality
// where a primitive explains the points, triangle meshes where none does. Immutable once built and
// shared between revisions.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "collision/geometry/aabb.h"
#include "collision/geometry/fit_quality.h"
#include "collision/geometry/shape.h"
#include "collision/geometry/vessel_shell.h"

namespace cwm {

enum class PartRole { kFitted, kCompleted };  // measured, or supplied where nothing was measured

// A bounded solid. A support's plate is completed: its body was supplied. Its top face was measured,
// and `fit` is of that.
struct ShapePart {
  Pose X_OS = Pose::Identity();  // the shape in the object's frame
  Shape shape;
  PartRole role = PartRole::kFitted;
  std::optional<FitQuality> fit = std::nullopt;  // absent where a user gave the shape
  // Of an open vessel, whose `shape` is then the watertight mesh of this.
  std::shared_ptr<const VesselShell> vessel = nullptr;
};

// As that of the part's shape, p in its frame; a vessel's by its profile: exact, and far sooner than
// by its mesh.
double SignedDistance_m(const ShapePart& part, const Vector3& p);

// An open or closed mesh over points that no shape explains, vertices in the object's frame.
struct SurfacePart {
  Mesh surface;
  int point_count = 0;  // measured points that it stands for
};

// A cluster grown from a shape's surface (paper, section V), e.g. the handle of a mug.
struct Handle {
  int shape_index = 0;  // into HybridModel::shapes; -1: a surface carries it
  int point_count = 0;
  Vector3 axis_O = Vector3::UnitZ();  // unit, direction of largest extent
  Placed<Box> bounds;                 // in the object's frame, x along the axis
  Mesh surface;                       // object's frame; may have no triangles
};

struct HybridModel {
  std::vector<ShapePart> shapes;
  std::vector<SurfacePart> surfaces;
  std::vector<Handle> handles;
  int point_count = 0;  // measured points behind the model; 0 for what users put
};

// Bounds of all parts in frame F, the object's frame placed at X_FO. Empty for a model without
// parts.
Aabb TightBounds(const HybridModel& model, const Pose& X_FO);

}  // namespace cwm
