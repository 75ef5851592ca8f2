// Associates one scan with the known objects: which are still there, moved, gone, new, or only
// hidden. Works on values and does not depend on the world.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "collision/geometry/hybrid_model.h"
#include "perception/cloud/point_cloud.h"
#include "perception/cloud/sensor_noise.h"
#include "perception/scene_interpretation.h"

namespace cwm::perception {

// An object of the world as tracking sees it.
struct KnownObject {
  std::string name;
  enum class Kind { kSupport, kObject, kResidual } kind = Kind::kObject;
  bool owned_by_user = false;  // its points explain the cloud, but it never changes
  // It was taken out of the world, and may come back: nothing of it is where it was, seen or not.
  bool is_gone = false;
  Pose X_WO = Pose::Identity();
  std::shared_ptr<const HybridModel> model;
};

struct Association {
  enum class Outcome {
    kKeep,      // known[known] is where it was: no change
    kMove,      // same object at another place: only X_WO changes
    kReplace,   // same object, model measurably better or different: keeps its name
    kAdd,       // new
    kRemove,    // rays pass through its place
    kOcclude,   // hidden now: stays, with state OCCLUDED
    kExplained  // a user's object explains the detection, or known objects that are still there do
                // (this scan is segmented differently): nothing is added
  };
  Outcome outcome = Outcome::kKeep;
  int known = -1;                // index into known; -1 for kAdd and kExplained
  int support = -1;              // index into scene.supports, or
  int object = -1;               // index into scene.objects; both -1 for kRemove and kOcclude
  Pose X_WO = Pose::Identity();  // for kMove
};

// Every known object that the user does not own, and every support and object of the scene, appears
// exactly once. Known objects outside the sensor's view are kept. A kKeep without support and
// object was not detected, but rays end on it or give no information about it. X_WO is the known
// pose (identity without a known object) except for kMove. Deterministic; ties are resolved by
// name.
std::vector<Association> Associate(const std::vector<KnownObject>& known,
                                   const SceneInterpretation& scene, const PointCloud& cloud,
                                   const SensorNoise& noise);

}  // namespace cwm::perception
