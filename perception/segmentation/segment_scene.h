// SCENE INTERPRETER (paper, sections III and IV): a cloud becomes supports, objects and leftovers.
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
  std::optional<Matrix3> R_LC;  // orientation of the sensor in the level frame, where known; else
  std::optional<Vector3> up_C;  // any positive length; else up is estimated
  Clustering clustering = Clustering::kObjects;
  std::function<void(std::string_view stage)> stage_done = [](std::string_view) {};
};

struct SegmentedSupport {
  Placed<Plate> plate;                // in the level frame
  std::vector<std::uint32_t> points;  // indices into SegmentedScene::points, as a thing's
};

struct SegmentedThing {
  std::int32_t supported_by = -1;  // index into supports; -1: residual geometry
  std::int32_t rests_on = -1;      // index of the object between it and the support; -1: none
  double foot_height_m = 0;        // of where it rests, above the support's top
  // Points that follow each other lie near each other: in an image's order, or cell by cell.
  std::vector<std::uint32_t> points;
  std::size_t node_count = 0;  // pixels or cells that hold them
  // Of a wall or front: what bounds it, with holes where rays pass (BoundSupport), in the level
  // frame; the largest part first.
  std::vector<Placed<Plate>> plates;
};

// The level frame L has the sensor as its origin and up as its z: coordinates stay small however
// far from the world's origin the sensor is.
struct SegmentedScene {
  Matrix3 R_LC = Matrix3::Identity();
  UpSource up_source = UpSource::kGiven;
  // Of an up that was given. A vector that is kReversed was taken the other way round; an
  // orientation is taken as it is.
  UpVerdict up_verdict = UpVerdict::kPlausible;
  // Where an up was given and no support found: what EstimateUp would take for up, in the level
  // frame.
  std::optional<Vector3> rival_up;
  OrientedPoints points;
  std::vector<SegmentedSupport> supports;  // largest first
  std::vector<SegmentedThing> things;      // objects, largest first, then residuals
  std::vector<std::uint32_t> rejected;
  // What was seen in each direction, in the level frame; nothing where not all was seen from one
  // place (IsSeenFromOnePlace).
  std::optional<SightMap> sight;
};

// Cancelled when stopped, within one piece of work. Same input, same bytes on any number of
// threads.
absl::StatusOr<SegmentedScene> SegmentScene(MeasuredPoints measured, const SegmentOptions& options,
                                            const Work& work = {});

}  // namespace cwm::perception
