#include "perception/track/association.h"

#include "perception/track/object_association.h"
#include "perception/track/scan_evidence.h"
#include "perception/track/support_association.h"

namespace cwm::perception {

std::vector<Association> Associate(const std::vector<KnownObject>& known,
                                   const SceneInterpretation& scene, const PointCloud& cloud,
                                   const SensorNoise& noise) {
  const ScanEvidence scan(cloud, scene.X_WC, noise);
  std::vector<Association> result = AssociateSupports(known, scene, scan);
  const std::vector<Association> objects = AssociateObjects(known, scene, scan);
  result.insert(result.end(), objects.begin(), objects.end());
  return result;
}

}  // namespace cwm::perception
