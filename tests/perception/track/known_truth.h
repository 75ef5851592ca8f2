// Interpretations made of the scanner's ground truth, like those of a good segmentation and good
// fits, so that tracking is tested alone.
#pragma once

#include <string>
#include <vector>

#include "perception/scene_interpretation.h"
#include "perception/simulation/virtual_scanner.h"
#include "perception/track/association.h"

namespace cwm::perception {

struct TrueScan {
  SimulatedCloud scan;
  SceneInterpretation scene;
  std::vector<std::string> object_names;   // of scene.objects
  std::vector<std::string> support_names;  // of scene.supports
};

// Scans with Kinect noise and interprets by the truth. Models have errors of 1 mm (one standard
// deviation) in place and size, as fits have. Objects with fewer than 30 points are not detected.
TrueScan ScanAndInterpret(const SimulatedScene& scene, const PinholeCamera& camera,
                          std::uint64_t seed);

// The known objects of a world that took everything from one scan.
std::vector<KnownObject> Remember(const TrueScan& scan);

// The index of the object of this name.
int IndexOf(const SimulatedScene& scene, const std::string& name);
int IndexOf(const std::vector<KnownObject>& known, const std::string& name);
int IndexOf(const TrueScan& scan, const std::string& object_name);

}  // namespace cwm::perception
