// Scans that are put together by hand: boxes in front of a wall, seen straight on and without
// noise. For tests of how tracking associates detections.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "perception/track/association.h"
#include "perception/track/scan_evidence.h"

namespace cwm::perception {

// The sensor's position; it looks along z, and all axes are parallel to the world's. It claims a
// sigma of 2 mm, so that gates are 6 mm.
inline const Vector3 kHeadOnSensor_W(1, 2, 3);
inline constexpr double kWallDepth_m = 1.5;

// A box with edges along the axes and its middle in the level frame.
struct HeadOnBox {
  Vector3 middle_L = Vector3::Zero();
  Vector3 size_m = Vector3::Zero();
};

std::shared_ptr<const HybridModel> ModelOfBox(const HeadOnBox& box);
KnownObject KnownBox(const std::string& name, const HeadOnBox& box);

// A scan of the wall and of the fronts of the boxes; their other sides are too edge-on to return.
// Points are 5 mm apart at 1.3 m.
class HeadOnScan {
 public:
  explicit HeadOnScan(std::vector<HeadOnBox> boxes);

  const ScanEvidence& evidence() const { return evidence_; }
  // The detection of a box: its visible points, and the model of the whole box.
  DetectedObject Detected(std::size_t box) const;
  // A scene of all boxes, in their order.
  SceneInterpretation Scene() const;

 private:
  struct Image {
    PointCloud cloud;
    std::vector<int> owner;  // per point the index of its box, -1 for the wall
  };
  static Image See(const std::vector<HeadOnBox>& boxes);

  std::vector<HeadOnBox> boxes_;
  Image image_;
  ScanEvidence evidence_;
};

}  // namespace cwm::perception
