// All geometry that collision checking takes for solid or for a surface after a scan, in the
// camera's frame.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "collision/geometry/aabb.h"
#include "collision/geometry/hybrid_model.h"
#include "perception/scene_interpretation.h"

namespace cwm::benchmarks {

enum class Claim { kSupport, kFitted, kCompleted, kHandle, kSurface };
inline constexpr int kClaimCount = 5;
std::string_view NameOf(Claim claim);

// A shape with an inside: primitives, plates, and watertight meshes.
struct ClaimedSolid {
  Claim claim = Claim::kFitted;
  Pose X_CS = Pose::Identity();
  Shape shape = {};
  Aabb bounds_C = {};
};

struct ClaimedTriangle {
  Claim claim = Claim::kSurface;
  std::array<Vector3, 3> corners_C = {};
};

struct ClaimedGeometry {
  std::vector<ClaimedSolid> solids;
  std::vector<ClaimedTriangle> triangles;  // of all meshes, watertight or not
};

// The claims as the world prepares them for its engines: plates of supports, shapes of objects,
// their meshes, and handles as meshes or, if they have none, as boxes.
ClaimedGeometry ClaimsOf(const perception::SceneInterpretation& interpretation);

}  // namespace cwm::benchmarks
