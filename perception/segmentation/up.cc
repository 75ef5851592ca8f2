#include "perception/segmentation/up.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "perception/cloud/tolerances.h"
#include "perception/cloud/voxel_grid.h"
#include "perception/segmentation/cell_clusters.h"
#include "perception/segmentation/footprint.h"

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

// chosen: between neighbouring cells of one surface.
constexpr double kSmoothTurn_rad = 10 * kDegree;
// chosen: 10 degrees above the optical axis's plane, as a sine.
constexpr double kMinUpComponent = 0.17;
// chosen: of all cells: smaller planes do not tell up.
constexpr double kMinPlaneShare = 0.02;
// chosen: of a plane's area, where its normal does not show along the image's up. It shows across
// it of walls, and of tables seen from straight above or by a camera on its side: these are larger
// than the side of any box on them, and walls seldom more than three times as large as what stands
// before them.
constexpr double kAcrossWeight = 1.0 / 3;
// chosen: against it, of the walls that a camera sees which looks down, and of the tables of one
// that hangs upside down, which are fewer.
constexpr double kAgainstWeight = 0.1;

// chosen: of a cloud that is no image: three images of a Kinect, in a tenth of a second.
constexpr std::size_t kMaxPointsForUp = std::size_t{1} << 20;

// chosen: of the sine of a ray's elevation: flatter, a surface passes through the sensor's place,
// and is seen from neither side.
constexpr double kMinDrop = 0.1;
// chosen: of the level cells that are seen from below and from above: of a room both are seen, of a
// table with up upside down one alone, but for what else is level by chance.
constexpr double kMostlyBelow = 3;
// chosen: what stands on a support is as high as a bottle.
constexpr double kHighestStanding_m = 0.3;
// chosen: of the area of a support, what stands on it. Lamps cover less of a ceiling.
constexpr double kMinStandingShare = 0.05;

double WeightOf(double image_up) {
  if (image_up >= kMinUpComponent) return 1;
  return image_up > -kMinUpComponent ? kAcrossWeight : kAgainstWeight;
}

struct LevelCells {
  std::vector<std::uint32_t> from_below;  // ascending
  std::size_t others = 0;                 // from above, or neither
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
         count >= kMostlyBelow * static_cast<double>(level.others);
}

// Cells near a plane, over its footprint.
struct BesidePlane {
  std::size_t before = 0;  // on the sensor's side
  std::size_t behind = 0;

  bool Stands(std::size_t on_plane, double least_ratio) const {
    const auto count = static_cast<double>(before);
    return count >= kMinStandingShare * static_cast<double>(on_plane) &&
           count >= least_ratio * static_cast<double>(behind);
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
  if (measured.organised()) return SketchCoarseCloud(measured, work);
  const OrientedPoints& all = measured.oriented;
  if (all.size() <= kMaxPointsForUp) return MakeCoarseCloud(all, work);
  std::vector<std::uint32_t> some;
  const std::size_t stride = all.size() / kMaxPointsForUp + 1;
  for (std::size_t i = 0; i < all.size(); i += stride) {
    some.push_back(static_cast<std::uint32_t>(i));
  }
  return MakeCoarseCloud(Subset(all, some), work);
}

std::optional<UpEstimate> EstimateUp(const CoarseCloud& coarse,
                                     const std::optional<ImageAxes>& image) {
  const float turn_cos = static_cast<float>(std::cos(kSmoothTurn_rad));
  const std::vector<Vector3f>& normals = coarse.cells.normals;
  const auto clusters = ClusterCells(
      {coarse.grid, coarse.cells}, [&](std::uint32_t c) { return !normals[c].isZero(); },
      [&](std::uint32_t a, std::uint32_t b) { return normals[a].dot(normals[b]) >= turn_cos; });
  std::optional<UpEstimate> best;
  double best_score = 0;
  const double least = kMinPlaneShare * static_cast<double>(coarse.cells.size());
  for (const auto& cluster : clusters) {
    if (static_cast<double>(cluster.size()) < least || cluster.size() < 3) break;
    const std::optional<Plane> plane = FitPlane(coarse.cells, cluster, cluster[0]);
    if (!plane) continue;
    const auto area = static_cast<double>(Inliers(*plane, coarse.cells, cluster).size());
    // Given normals may point anywhere; what an image shows, it shows from the sensor's side.
    const bool turned = image && plane->Height_m(coarse.cells.viewpoint) < 0;
    const Vector3 up = turned ? Vector3(-plane->normal) : plane->normal;
    const double image_up = image ? image->up.dot(up) : 0;
    const double score = area * (image ? WeightOf(image_up) : 1);
    if (score <= best_score) continue;
    best = {.up = up, .shows_in_image = image_up >= kMinUpComponent};
    best_score = score;
  }
  return best;
}

UpVerdict JudgeUp(const CoarseCloud& coarse, const Vector3& up,
                  const std::optional<ImageAxes>& image) {
  const Vector3 unit_up = up.normalized();
  const LevelCells level = FindLevelCells(coarse.cells, unit_up);
  if (!AreFromBelowAlone(level, coarse)) return UpVerdict::kPlausible;
  // A camera upside down that looks up at a ceiling is one that stands upright and looks down, and
  // the other way round.
  const double image_up = image ? image->up.dot(unit_up) : 0;
  if (image_up <= -kMinUpComponent) return UpVerdict::kReversed;
  if (image_up >= kMinUpComponent) return UpVerdict::kSeenFromBelow;
  const std::optional<Plane> plane = FitPlane(coarse.cells, level.from_below, level.from_below[0]);
  bool things_stand = false;
  if (plane) {
    const std::vector<std::uint32_t> inliers = Inliers(*plane, coarse.cells, level.from_below);
    const BesidePlane beside = CountBeside(coarse, *plane, inliers);
    things_stand = beside.Stands(inliers.size(), image ? 0 : kMostlyBelow);
  }
  if (!image) return things_stand ? UpVerdict::kSeenFromBelow : UpVerdict::kPlausible;
  return things_stand ? UpVerdict::kReversed : UpVerdict::kSeenFromBelow;
}

bool IsSeenFromBelowAlone(const CoarseCloud& coarse, const Vector3& up) {
  return AreFromBelowAlone(FindLevelCells(coarse.cells, up.normalized()), coarse);
}

}  // namespace cwm::perception
