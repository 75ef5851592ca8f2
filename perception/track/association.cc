#include "perception/track/association.h"

#include "perception/track/object_association.h"
#include "perception/track/scan_evidence.h"
#include "perception/track/support_association.h"

namespace cwm::perception {
namespace {

std::vector<Association> AllNew(const SceneInterpretation& scene) {
  std::vector<Association> result;
  for (int i = 0; i < static_cast<int>(scene.supports.size()); ++i) {
    result.push_back({.outcome = Association::Outcome::kAdd, .support = i});
  }
  for (int i = 0; i < static_cast<int>(scene.objects.size()); ++i) {
    result.push_back({.outcome = Association::Outcome::kAdd, .object = i});
  }
  return result;
}

}  // namespace

std::vector<Association> Associate(const std::vector<KnownObject>& known,
                                   const SceneInterpretation& scene, const PointCloud& cloud,
                                   const SensorNoise& noise) {
  if (known.empty()) return AllNew(scene);  // no known object to find in the cloud
  const ScanEvidence scan(cloud, scene.X_WC, noise, scene.seen_from_origin);
  std::vector<Association> result = AssociateSupports(known, scene, scan);
  const std::vector<Association> objects = AssociateObjects(known, scene, scan);
  result.insert(result.end(), objects.begin(), objects.end());
  return result;
}

}  // namespace cwm::perception
