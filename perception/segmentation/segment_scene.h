// Segmentation (paper, sections III and IV): divides a cloud into supports, objects and residuals.
#pragma once

#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/geometry/shape.h"
#include "perception/cloud/measured_points.h"
#include "perception/cloud/work.h"
#include "perception/segmentation/clustering.h"
#include "perception/segmentation/plane_fit.h"
#include "perception/segmentation/sight_map.h"
#include "perception/segmentation/up.h"

namespace cwm::perception {

struct SegmentOptions {
  std::optional<Matrix3> R_LC;  // orientation of the sensor in the level frame, if known; else
  std::optional<Vector3> up_C;  // up of any positive length; else up is estimated
  Clustering clustering = Clustering::kObjects;
  std::function<void(std::string_view stage)> stage_done = [](std::string_view) {};
};

struct SegmentedSupport {
  Placed<Plate> plate;                // in the level frame
  std::vector<std::uint32_t> points;  // indices into SegmentedScene::points, as an object's
};

struct SegmentedHypothesis {
  std::int32_t supported_by = -1;  // index into supports; -1: residual geometry
  std::int32_t rests_on = -1;      // index of the object between it and the support; -1: none
  double foot_height_m = 0;        // the height of its foot above the support's top
  // Consecutive points lie near each other: in the order of an image, or cell by cell.
  std::vector<std::uint32_t> points;
  std::size_t node_count = 0;  // number of pixels or cells with these points
  // The plates of a wall or front, with holes where rays pass (BoundSupport), in the level frame;
  // the largest part first.
  std::vector<Placed<Plate>> plates;
};

// The level frame L has its origin at the sensor and z up, so that coordinates stay small at any
// distance of the sensor from the world's origin.
struct SegmentedScene {
  Matrix3 R_LC = Matrix3::Identity();
  UpSource up_source = UpSource::kGiven;
  // The verdict on a given up. A vector that is kReversed was used with the opposite sign; an
  // orientation is used as it is.
  UpVerdict up_verdict = UpVerdict::kPlausible;
  // In the level frame: the up that is nearly as likely as the estimated one, if that is kDoubtful;
  // the up that EstimateUp would choose, if up was given and no support found.
  std::optional<Vector3> alternative_up;
  OrientedPoints points;
  std::vector<SegmentedSupport> supports;       // largest first
  std::vector<SegmentedHypothesis> hypotheses;  // objects, largest first, then residuals
  std::vector<std::uint32_t> rejected;
  // The sight map of the cloud, in the level frame; empty if not all points were seen from one
  // place (IsSeenFromOnePlace).
  std::optional<SightMap> sight;
};

// Returns Cancelled when stopped, within one piece of work. The same input gives the same bytes on
// any number of threads.
absl::StatusOr<SegmentedScene> SegmentScene(MeasuredPoints measured, const SegmentOptions& options,
                                            const Work& work = {});

}  // namespace cwm::perception
