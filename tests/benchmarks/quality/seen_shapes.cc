#include "tests/benchmarks/quality/seen_shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/geometry/signed_distance.h"
#include "tests/benchmarks/quality/point_labels.h"

namespace cwm::benchmarks {
namespace {

bool IsComparable(ShapeKind kind) {
  return kind == ShapeKind::kBox || kind == ShapeKind::kCylinder || kind == ShapeKind::kSphere ||
         kind == ShapeKind::kCone;
}

// The shape of an object (from 0) that explains a point whose label names part `part` (from 1); -1
// for a handle.
std::int32_t ShapeOfPart(std::size_t part, const Vector3& p_W, const std::vector<FoundShape>& found,
                         std::size_t first, std::size_t count) {
  if (part < kTellableParts || count < kTellableParts) {
    return part <= count ? static_cast<std::int32_t>(first + part - 1) : -1;
  }
  std::int32_t nearest = -1;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t s = first + kTellableParts - 1; s < first + count; ++s) {
    const Vector3 p_S = found[s].X_WS.inverse() * p_W;
    const double distance_m = std::abs(SignedDistance_m(found[s].part.shape, p_S));
    if (distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    nearest = static_cast<std::int32_t>(s);
  }
  return nearest;
}

}  // namespace

bool IsFixture(const perception::SimulatedObject& object) {
  if (object.is_support) return true;
  return std::any_of(object.parts.begin(), object.parts.end(), [](const Placed<>& part) {
    const Aabb bounds = TightBounds(part.shape, Pose::Identity());
    return bounds.sizes().maxCoeff() >= kMaxObjectLength_m;
  });
}

Vector3 PointInWorld(const InterpretedView& view, std::uint32_t index) {
  return view.interpretation.X_WC * view.scan.cloud.points[index].cast<double>();
}

std::vector<TrueShape> TrueShapes(const InterpretedView& view) {
  const Pose X_WT = view.interpretation.X_WC * view.camera.X_WC.inverse();  // T: the scene's world
  std::vector<TrueShape> shapes;
  std::vector<std::vector<std::int32_t>> shape_of_part(view.scene.objects.size());
  for (std::size_t o = 0; o < view.scene.objects.size(); ++o) {
    const perception::SimulatedObject& object = view.scene.objects[o];
    shape_of_part[o].assign(object.parts.size(), -1);
    if (IsFixture(object)) continue;
    for (std::size_t p = 0; p < object.parts.size(); ++p) {
      const Placed<>& part = object.parts[p];
      if (!IsComparable(KindOf(part.shape))) continue;
      shape_of_part[o][p] = static_cast<std::int32_t>(shapes.size());
      TrueShape& shape = shapes.emplace_back();
      shape.X_WS = X_WT * object.X_WO * part.X_FS;
      shape.shape = part.shape;
      shape.object = static_cast<std::int32_t>(o);
    }
  }
  for (std::uint32_t i = 0; i < view.scan.cloud.size(); ++i) {
    if (view.scan.object[i] < 0 || !view.scan.cloud.points[i].allFinite()) continue;
    const std::int32_t shape = shape_of_part[static_cast<std::size_t>(view.scan.object[i])]
                                            [static_cast<std::size_t>(view.scan.part[i])];
    if (shape >= 0) shapes[static_cast<std::size_t>(shape)].points.push_back(i);
  }
  return shapes;
}

std::vector<FoundShape> FoundShapes(const InterpretedView& view) {
  const std::vector<perception::DetectedObject>& objects = view.interpretation.objects;
  std::vector<FoundShape> shapes;
  std::vector<std::size_t> first;  // per object, and the end of the last
  for (std::size_t o = 0; o < objects.size(); ++o) {
    first.push_back(shapes.size());
    for (const ShapePart& part : objects[o].model->shapes) {
      FoundShape& shape = shapes.emplace_back();
      shape.X_WS = objects[o].X_WO * part.X_OS;
      shape.part = part;
      shape.object = static_cast<std::int32_t>(o);
    }
  }
  first.push_back(shapes.size());
  for (std::uint32_t i = 0; i < view.interpretation.labels.size(); ++i) {
    const std::uint32_t label = view.interpretation.labels[i];
    if (label < kFirstObjectLabel || label % kLabelsPerObject == 0) continue;
    const std::size_t o = (label - kFirstObjectLabel) / kLabelsPerObject;
    const std::int32_t shape = ShapeOfPart(label % kLabelsPerObject, PointInWorld(view, i), shapes,
                                           first[o], first[o + 1] - first[o]);
    if (shape >= 0) shapes[static_cast<std::size_t>(shape)].points.push_back(i);
  }
  return shapes;
}

}  // namespace cwm::benchmarks
