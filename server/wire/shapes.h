// Converts shapes: dimensions directly, meshes by the hash of their bytes.
#pragma once

#include <optional>

#include "absl/status/statusor.h"
#include "collision/geometry/hybrid_model.h"
#include "collision/geometry/shape.h"
#include "cwm/v1/geometry.pb.h"
#include "cwm/v1/world.pb.h"
#include "server/core/geometry_store.h"
#include "server/wire/field_path.h"

namespace cwm::server {

// An error names the first broken rule, e.g. "shapes[0].box.size_x_m: is -0.1, must be ...".
// NotFound GEOMETRY_UNKNOWN for a hash that the store does not have. The status of the budget if it
// ended.
absl::StatusOr<Placed<>> PlacedShapeFromProto(const v1::PlacedShape& placed,
                                              const GeometryStore& store, const FieldPath& path,
                                              WorkBudget* budget = nullptr);
absl::StatusOr<ShapePart> ShapePartFromProto(const v1::ShapePart& part, const GeometryStore& store,
                                             const FieldPath& path, WorkBudget* budget = nullptr);
absl::StatusOr<SurfacePart> SurfacePartFromProto(const v1::SurfacePart& part,
                                                 const GeometryStore& store, const FieldPath& path,
                                                 WorkBudget* budget = nullptr);

// Meshes become readable by their hash (`store.RegisterMesh`). The hash of a Convex is that of its
// hull.
v1::PlacedShape PlacedShapeToProto(const Placed<>& placed, GeometryStore& store);
v1::ShapePart ShapePartToProto(const ShapePart& part, GeometryStore& store);
v1::SurfacePart SurfacePartToProto(const SurfacePart& part, GeometryStore& store);
v1::OrientedBox OrientedBoxToProto(const Placed<Box>& box);

}  // namespace cwm::server
