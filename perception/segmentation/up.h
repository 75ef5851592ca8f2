// Estimates up from a cloud, or judges a given up.
#pragma once

#include <optional>

#include "perception/cloud/image_axes.h"
#include "perception/cloud/measured_points.h"
#include "perception/cloud/work.h"
#include "perception/segmentation/support_planes.h"

namespace cwm::perception {

// The cells for estimating or judging up, made of a subset of the points.
CoarseCloud CellsForUp(const MeasuredPoints& measured, const Work& work = {});

// The source of up.
enum class UpSource {
  kGiven,
  kSupport,    // estimated: a plane that objects stand on, or that lies in the image as supports do
  kBarePlane,  // estimated: a plane that nothing stands on and that may be a wall
  kDoubtful,   // estimated, but another direction is nearly as likely
  kNoPlane     // the sensor's own axes, as there is no plane
};

struct UpEstimate {
  Vector3 up = Vector3::UnitZ();  // unit
  UpSource source = UpSource::kSupport;
  std::optional<Vector3> alternative;  // unit; nearly as likely, so that the source is kDoubtful
};

// Returns the likeliest of the normals of the large planes and their opposites (up_evidence.h): by
// the area of level planes, by things that stand and loose parts that rest on what faces up, and by
// the axes of the image, or those that a list of points shows by where it lies. Empty if the cloud
// shows no plane.
std::optional<UpEstimate> EstimateUp(const CoarseCloud& coarse,
                                     const std::optional<ImageAxes>& image);

// The verdict of a cloud's level surfaces on a given up. Tables and floors lie below the sensor,
// unless it sees only a ceiling.
enum class UpVerdict {
  kPlausible,
  kSeenFromBelow,  // level surfaces are seen from below for an unknown reason
  kReversed,       // and the image, or objects on them, show that up is upside down
};

// `image` is that of an organised cloud. Without one the cloud may have been seen from several
// places: it is never kReversed, and kSeenFromBelow only if objects stand on the lower sides of its
// surfaces.
UpVerdict CheckUp(const CoarseCloud& coarse, const Vector3& up,
                  const std::optional<ImageAxes>& image);

// True if nearly all level cells are seen from below, and they are not a small part of the cloud.
// If the cloud was seen from its viewpoint, up is wrong or it shows a ceiling.
bool IsSeenFromBelowAlone(const CoarseCloud& coarse, const Vector3& up);

}  // namespace cwm::perception
