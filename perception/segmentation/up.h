// Where up is: estimated from a cloud, or given and doubted.
#pragma once

#include <optional>

#include "perception/cloud/image_axes.h"
#include "perception/cloud/measured_points.h"
#include "perception/cloud/work.h"
#include "perception/segmentation/support_planes.h"

namespace cwm::perception {

// The cells that up is estimated or doubted by: of some of the points.
CoarseCloud CellsForUp(const MeasuredPoints& measured, const Work& work = {});

// What up was taken from.
enum class UpSource {
  kGiven,
  kSupport,    // estimated: a plane that lies in the image as supports do, or that things stand on
  kBarePlane,  // estimated: a plane that may as well be a wall
  kNoPlane     // the sensor's own axes, for no plane tells
};

struct UpEstimate {
  Vector3 up = Vector3::UnitZ();  // unit
  bool shows_in_image = false;    // along the image's up, as the normals of supports do
};

// The normal of the largest plane in the view. Of an image, planes whose normal does not show along
// its up count for a third of their area, and against it for a tenth: walls are no supports, but of
// cameras that look straight down, or lie on their side, tables show as walls do. Nothing when the
// cloud shows no plane.
std::optional<UpEstimate> EstimateUp(const CoarseCloud& coarse,
                                     const std::optional<ImageAxes>& image);

// What the level surfaces of a cloud say to an up that was given. Tables and floors lie below the
// sensor, unless it looks at a ceiling alone.
enum class UpVerdict {
  kPlausible,
  kSeenFromBelow,  // level surfaces are seen from below, and nothing tells why
  kReversed,       // and the image or what stands on them tells that up is upside down
};

// `image` is that of an organised cloud. Any other may have been seen from several places: it is
// never kReversed, and kSeenFromBelow only when things stand on the lower sides of its surfaces.
UpVerdict JudgeUp(const CoarseCloud& coarse, const Vector3& up,
                  const std::optional<ImageAxes>& image);

// Whether all but little of what is level is seen from below, and it is no small part of the cloud:
// of one that was seen from its viewpoint, that speaks against up or of a ceiling.
bool IsSeenFromBelowAlone(const CoarseCloud& coarse, const Vector3& up);

}  // namespace cwm::perception
