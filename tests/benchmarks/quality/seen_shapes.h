// The two sides of a comparison: the true shapes of a scanned scene, and those of an interpretation
// of the scan.
#pragma once

#include <cstdint>
#include <vector>

#include "collision/geometry/hybrid_model.h"
#include "perception/cloud/sensor_noise.h"
#include "perception/scene_interpretation.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::benchmarks {

// All poses are in the world W of the interpretation, given or estimated; X_WC is the camera's pose
// in it.
struct TrueShape {
  Pose X_WS = Pose::Identity();
  Shape shape = {};
  std::int32_t object = -1;                // into SimulatedScene::objects
  std::vector<std::uint32_t> points = {};  // measured on it, indices into the cloud, ascending
};

struct FoundShape {
  Pose X_WS = Pose::Identity();
  ShapePart part = {};
  std::int32_t object = -1;                // into SceneInterpretation::objects
  std::vector<std::uint32_t> points = {};  // that it explains
};

// A simulated scan and its interpretation.
struct InterpretedView {
  const perception::SimulatedScene& scene;
  const perception::PinholeCamera& camera;
  const perception::SimulatedCloud& scan;
  const perception::SceneInterpretation& interpretation;
  perception::SensorNoise noise = {};  // of the scan
};

// Parts of this extent or more are the room and its furniture, not objects to handle.
inline constexpr double kMaxObjectLength_m = 0.5;

// True for supports, walls, fronts and cabinets, which are not counted.
bool IsFixture(const perception::SimulatedObject& object);

// Boxes, cylinders, spheres and cones of objects, visible (one point or more) or not.
std::vector<TrueShape> TrueShapes(const InterpretedView& view);

// The shapes of all objects, residual ones included. Labels distinguish the parts of an object up
// to the ninth; points of a later part are assigned to the nearest of those.
std::vector<FoundShape> FoundShapes(const InterpretedView& view);

// The position of a measured point in the world.
Vector3 PointInWorld(const InterpretedView& view, std::uint32_t index);

}  // namespace cwm::benchmarks
