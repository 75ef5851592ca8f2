#include "perception/segmentation/up.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "perception/cloud/tolerances.h"
#include "perception/cloud/voxel_grid.h"
#include "perception/segmentation/cell_clusters.h"
#include "perception/segmentation/footprint.h"
#include "perception/segmentation/up_evidence.h"

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

// chosen: the sine of 10 degrees above the horizontal plane of the optical axis.
constexpr double kMinUpComponent = 0.17;
// chosen: the least share of all cells of a plane that determines up.
constexpr double kMinPlaneShare = 0.02;
// chosen: the largest cell, in which the smallest things still have three cells.
constexpr float kMaxCellForUp_m = 0.04f;
// tuned: the least difference of log odds that decides; half of the wrong directions have more, and
// 7 % of the right ones less.
constexpr double kDecisiveUp = 1.5;
constexpr double kOpposite_cos = -0.99;  // derived: 8 degrees, within which directions are one

// chosen: the number of points of an unorganised cloud to use: three images of a Kinect, a tenth of
// a second.
constexpr std::size_t kMaxPointsForUp = std::size_t{1} << 20;

// chosen: the least sine of a ray's elevation; a flatter surface passes through the sensor and is
// seen from neither side.
constexpr double kMinDrop = 0.1;
// chosen: the least ratio of level cells seen from below to those seen from above. In a room both
// are seen; of a table with up upside down only one side, besides cells that are level by chance.
constexpr double kMinBelowRatio = 3;
// chosen: an object on a support is at most as high as a bottle.
constexpr double kHighestStanding_m = 0.3;
// chosen: the least share of a support's area that objects cover. Lamps cover less of a ceiling.
constexpr double kMinStandingShare = 0.05;

struct LevelCells {
  std::vector<std::uint32_t> from_below;  // ascending
  std::size_t others = 0;                 // seen from above, or from neither side
};

LevelCells FindLevelCells(const OrientedPoints& cells, const Vector3& up) {
  LevelCells level;
  const double tilt_cos = std::cos(kMaxTilt_rad);
  for (std::uint32_t c = 0; c < cells.size(); ++c) {
    if (std::abs(cells.normals[c].cast<double>().dot(up)) < tilt_cos) continue;
    const Vector3 ray = cells.points[c].cast<double>() - cells.viewpoint;
    if (ray.dot(up) > kMinDrop * ray.norm()) {
      level.from_below.push_back(c);
    } else {
      ++level.others;
    }
  }
  return level;
}

bool AreFromBelowAlone(const LevelCells& level, const CoarseCloud& coarse) {
  const double count = static_cast<double>(level.from_below.size());
  const double edge_m = coarse.grid.edge_m();
  return count * edge_m * edge_m >= kMinSupport_m2 &&
         count >= kMinPlaneShare * static_cast<double>(coarse.cells.size()) &&
         count >= kMinBelowRatio * static_cast<double>(level.others);
}

// The numbers of cells near a plane over its footprint.
struct BesidePlane {
  std::size_t before = 0;  // on the sensor's side
  std::size_t behind = 0;

  bool Stands(std::size_t on_plane, double min_ratio) const {
    const auto count = static_cast<double>(before);
    return count >= kMinStandingShare * static_cast<double>(on_plane) &&
           count >= min_ratio * static_cast<double>(behind);
  }
};

BesidePlane CountBeside(const CoarseCloud& coarse, const Plane& plane,
                        const std::vector<std::uint32_t>& inliers) {
  const OrientedPoints& cells = coarse.cells;
  const double edge_m = coarse.grid.edge_m();
  const Footprint footprint(plane, cells, inliers, edge_m);
  const double side = plane.Height_m(cells.viewpoint) < 0 ? -1 : 1;
  BesidePlane beside;
  for (std::uint32_t c = 0; c < cells.size(); ++c) {
    const Vector3 place = cells.points[c].cast<double>();
    const double height_m = side * plane.Height_m(place);
    const double gate_m = std::max(edge_m, kGate_sigma * cells.sigma_m[c]);
    if (std::abs(height_m) <= gate_m || std::abs(height_m) > kHighestStanding_m) continue;
    if (footprint.Surrounds(place)) ++(height_m > 0 ? beside.before : beside.behind);
  }
  return beside;
}

}  // namespace

CoarseCloud CellsForUp(const MeasuredPoints& measured, const Work& work) {
  if (measured.organised()) return MakeSubsampledCoarseCloud(measured, work, kMaxCellForUp_m);
  const OrientedPoints& all = measured.oriented;
  if (all.size() <= kMaxPointsForUp) return MakeCoarseCloud(all, work, kMaxCellForUp_m);
  std::vector<std::uint32_t> some;
  const std::size_t stride = all.size() / kMaxPointsForUp + 1;
  for (std::size_t i = 0; i < all.size(); i += stride) {
    some.push_back(static_cast<std::uint32_t>(i));
  }
  return MakeCoarseCloud(Subset(all, some), work, kMaxCellForUp_m);
}

std::optional<UpEstimate> EstimateUp(const CoarseCloud& coarse,
                                     const std::optional<ImageAxes>& image) {
  const std::vector<UpEvidence> ups = WeighUps(coarse, image ? *image : AxesOfList(coarse.cells));
  if (ups.empty()) return std::nullopt;
  const bool is_close = ups.size() > 1 && ups[0].LogOdds() - ups[1].LogOdds() < kDecisiveUp;
  // The nearer one to the image's up is taken of two close ones: most sensors stand upright.
  const std::size_t taken = is_close && ups[1].image_cos > ups[0].image_cos ? 1 : 0;
  const UpEvidence& best = ups[taken];
  UpEstimate estimate{.up = best.up, .alternative = std::nullopt};
  const bool is_bare = best.thing_cells == 0 && best.image_cos < kMinUpComponent;
  if (is_bare) estimate.source = UpSource::kBarePlane;
  if (is_close) {
    const UpEvidence& other = ups[1 - taken];
    // A bare plane is a wall, a floor or a ceiling: its other side says nothing new.
    const bool is_opposite = other.up.dot(best.up) < kOpposite_cos;
    if (!is_bare || !is_opposite) {
      estimate.source = UpSource::kDoubtful;
      estimate.alternative = other.up;
    }
  }
  return estimate;
}

UpVerdict CheckUp(const CoarseCloud& coarse, const Vector3& up,
                  const std::optional<ImageAxes>& image) {
  const Vector3 unit_up = up.normalized();
  const LevelCells level = FindLevelCells(coarse.cells, unit_up);
  if (!AreFromBelowAlone(level, coarse)) return UpVerdict::kPlausible;
  // A camera upside down that looks up at a ceiling is one that stands upright and looks down, and
  // vice versa.
  const double image_up = image ? image->up.dot(unit_up) : 0;
  if (image_up <= -kMinUpComponent) return UpVerdict::kReversed;
  if (image_up >= kMinUpComponent) return UpVerdict::kSeenFromBelow;
  const std::optional<Plane> plane = FitPlane(coarse.cells, level.from_below, level.from_below[0]);
  bool objects_stand = false;
  if (plane) {
    const std::vector<std::uint32_t> inliers = Inliers(*plane, coarse.cells, level.from_below);
    const BesidePlane beside = CountBeside(coarse, *plane, inliers);
    objects_stand = beside.Stands(inliers.size(), image ? 0 : kMinBelowRatio);
  }
  if (!image) return objects_stand ? UpVerdict::kSeenFromBelow : UpVerdict::kPlausible;
  return objects_stand ? UpVerdict::kReversed : UpVerdict::kSeenFromBelow;
}

bool IsSeenFromBelowAlone(const CoarseCloud& coarse, const Vector3& up) {
  return AreFromBelowAlone(FindLevelCells(coarse.cells, up.normalized()), coarse);
}

}  // namespace cwm::perception
