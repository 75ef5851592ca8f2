// One scan against what is known: which objects are still there, which moved, which are gone, which
// are new, and which are merely hidden. Values in, values out; knows no world.
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
  bool owned_by_user = false;  // its points explain the cloud, and nothing ever changes it
  Pose X_WO = Pose::Identity();
  std::shared_ptr<const HybridModel> model;
};

struct Association {
  enum class What {
    kKeep,      // known[known] is still there as it was: no change at all
    kMove,      // same object at another place: only X_WO changes
    kReplace,   // same object, model measurably better or different: keeps its name
    kAdd,       // new
    kRemove,    // rays pass through where it was
    kOcclude,   // hidden now: stays, its state becomes OCCLUDED
    kExplained  // detected, but a user's object explains it, or known objects that are still there
                // do (this scan was cut into other pieces): nothing is made of it
  };
  What what = What::kKeep;
  int known = -1;                // index into known; -1 for kAdd and kExplained
  int support = -1;              // index into scene.supports, or
  int object = -1;               // index into scene.objects; both -1 for kRemove and kOcclude
  Pose X_WO = Pose::Identity();  // for kMove
};

// Every known object that the user does not own, and every support and object of the scene, appears
// exactly once. Known objects outside the sensor's view are kept. A kKeep without support and
// object is one for which nothing was detected, but rays end on it or say nothing of it. For all
// but kMove, X_WO is the known pose (identity where nothing is known). Deterministic; ties go by
// name.
std::vector<Association> Associate(const std::vector<KnownObject>& known,
                                   const SceneInterpretation& scene, const PointCloud& cloud,
                                   const SensorNoise& noise);

}  // namespace cwm::perception
