#include "perception/segmentation/support_planes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "perception/cloud/downsample.h"
#include "perception/cloud/parallel_for.h"
#include "perception/cloud/quantile.h"
#include "perception/cloud/tolerances.h"
#include "perception/segmentation/cell_clusters.h"
#include "perception/segmentation/footprint.h"
#include "perception/segmentation/support_gaps.h"

namespace cwm::perception {
namespace {

// measured: the share of the cells of a noisy island on the plane of the support that it belongs
// to.
constexpr double kIslandShare = 0.95;

using Eigen::Vector3f;

// chosen: cells of 8 sigma average the noise of a cell's plane to below the gate, with at least 15
// mm, at which a table of one square metre has 4 000 cells.
constexpr float kCoarseCell_sigma = 8;
constexpr float kMinCoarseCell_m = 0.015f;
// chosen: points per cell of a sketch; their mean normal scatters a quarter as much as a point's.
constexpr float kSampledPointsPerCell = 16;
// chosen: the largest stride in an image's points: far cells keep more points, and a sketch is
// cheap.
constexpr float kMaxSampleStride = 16;
// chosen: the largest tilt of cells seen at a grazing angle, within the error of their normals
// (kGate_sigma): at most an eighth of all directions.
constexpr double kMaxGrazingTilt_rad = 30 * kDegree;
// chosen: a patch less than this above a support of twice its size is an object's top, not a shelf.
constexpr double kHighestObjectTop_m = 0.4;
// chosen: the least area of a board, a patch that is a support although it is an object's top by
// the rule above because the sensor sees under it, like low tables, benches and shelves; the area
// seen under it is more than mixed pixels and an overhanging lid make (kMaxPassing). At least the
// size of a stool's seat: goods on a foot are objects.
constexpr double kMinBoard_m2 = 0.05;
// chosen: the least distance below a board of what is seen under it: more than the thickness of the
// board and of what hangs on its edge.
constexpr double kBoardClearance_m = 0.1;

template <class T>
std::vector<T> EveryNth(const std::vector<T>& values, std::size_t n) {
  std::vector<T> some;
  some.reserve(values.size() / n + 1);
  for (std::size_t i = 0; i < values.size(); i += n) some.push_back(values[i]);
  return some;
}

float CoarseCell_m(std::vector<float> sigma_m) {
  return std::max(kMinCoarseCell_m, kCoarseCell_sigma * Median(std::move(sigma_m)));
}

// The area that cells of a plane cover, one face each; about the same if seen at a slant.
double Area_m2(const CellView& coarse, std::size_t cells) {
  return static_cast<double>(cells) * coarse.grid.edge_m() * coarse.grid.edge_m();
}

std::vector<SupportPlane> PlanesOfCluster(const CellView& coarse,
                                          std::vector<std::uint32_t> members) {
  std::vector<SupportPlane> planes;
  while (Area_m2(coarse, members.size()) >= kMinSupport_m2 / 2) {
    const std::optional<Plane> plane = FitPlane(coarse.cells, members, members[0]);
    if (!plane) break;
    std::vector<std::uint32_t> inliers = Inliers(*plane, coarse.cells, members);
    if (Area_m2(coarse, inliers.size()) < kMinSupport_m2 / 2) break;
    std::vector<std::uint32_t> rest;
    std::set_difference(members.begin(), members.end(), inliers.begin(), inliers.end(),
                        std::back_inserter(rest));
    const double area = Area_m2(coarse, inliers.size());
    planes.push_back({*plane, std::move(inliers), area});
    members = std::move(rest);
  }
  return planes;
}

Vector3 MeanPoint(const CellView& coarse, std::span<const std::uint32_t> cells) {
  Vector3 sum = Vector3::Zero();
  for (std::uint32_t c : cells) sum += coarse.cells.points[c].cast<double>();
  return sum / static_cast<double>(cells.size());
}

// True if two planes are coplanar, by the larger one, which is known better: their normals agree
// within 3 degrees, and the middle of the smaller one is explained by the larger one's plane (1
// cm). Also if nearly all of the smaller one is noise about the larger one's plane and its middle
// is within the sigma of its cells: noisy islands of a far floor tilt and rise at random.
bool AreCoplanar(const CellView& coarse, const SupportPlane& larger, const SupportPlane& smaller) {
  const double gap_m = std::abs(larger.plane.Height_m(MeanPoint(coarse, smaller.cells)));
  if (gap_m <= kExplainedWithin_m &&
      larger.plane.normal.dot(smaller.plane.normal) >= std::cos(kFlat_rad)) {
    return true;
  }
  double sigma_m = 0;
  std::size_t within = 0;
  for (std::uint32_t c : smaller.cells) {
    const double cell_sigma_m = coarse.cells.sigma_m[c];
    sigma_m += cell_sigma_m / static_cast<double>(smaller.cells.size());
    within += std::abs(larger.plane.Height_m(coarse.cells.points[c])) <= kGate_sigma * cell_sigma_m;
  }
  return gap_m <= sigma_m &&
         static_cast<double>(within) >= kIslandShare * static_cast<double>(smaller.cells.size());
}

// True if the plane has the area of a support. Where the noise exceeds a cell's height, cells lie
// above each other, so one per column counts.
bool IsLarge(const CellView& coarse, const SupportPlane& plane) {
  if (plane.area_m2 < kMinSupport_m2) return false;
  std::vector<std::pair<int, int>> columns;
  columns.reserve(plane.cells.size());
  for (std::uint32_t c : plane.cells) {
    const auto& cell = coarse.grid.cell(c);
    columns.emplace_back(cell[0], cell[1]);
  }
  std::sort(columns.begin(), columns.end());
  const auto distinct = std::unique(columns.begin(), columns.end()) - columns.begin();
  return Area_m2(coarse, static_cast<std::size_t>(distinct)) >= kMinSupport_m2;
}

// One round of merging over the planes, largest first.
std::vector<SupportPlane> MergeOnce(const CellView& coarse, const SightMap* sight,
                                    std::vector<SupportPlane> planes) {
  std::vector<SupportPlane> merged;
  for (SupportPlane& plane : planes) {
    const auto same = std::find_if(merged.begin(), merged.end(), [&](const SupportPlane& m) {
      return AreCoplanar(coarse, m, plane) &&
             IsGapClosed(m.plane, coarse.cells, m.cells, plane.cells, sight);
    });
    if (same == merged.end()) {
      merged.push_back(std::move(plane));
      continue;
    }
    std::vector<std::uint32_t> all;
    std::set_union(same->cells.begin(), same->cells.end(), plane.cells.begin(), plane.cells.end(),
                   std::back_inserter(all));
    same->plane = RefinePlane(same->plane, coarse.cells, all).value_or(same->plane);
    same->area_m2 += plane.area_m2;
    same->cells = std::move(all);
  }
  return merged;
}

// Repeats until nothing changes: a piece may only be adjacent to the largest plane by way of one
// that was merged later.
std::vector<SupportPlane> MergeCoplanar(const CellView& coarse, const SightMap* sight,
                                        std::vector<SupportPlane> planes) {
  for (std::size_t before = planes.size() + 1; planes.size() < before;) {
    before = planes.size();
    planes = MergeOnce(coarse, sight, std::move(planes));
    std::stable_sort(planes.begin(), planes.end(),
                     [](const auto& a, const auto& b) { return a.area_m2 > b.area_m2; });
  }
  return planes;
}

// True if the plane's own cells are the larger part of the cells on it, among and beside them.
// Planes through cells that fill space, such as foliage and noise, cut cells that face in all
// directions.
bool IsSurface(const CellView& coarse, const SupportPlane& plane) {
  std::vector<std::uint32_t> others;
  for (std::uint32_t own : plane.cells) {
    coarse.grid.ForEachWithin(1, coarse.grid.cell(own), [&](std::size_t c) {
      const double height_m = plane.plane.Height_m(coarse.cells.points[c]);
      if (std::abs(height_m) > kGate_sigma * coarse.cells.sigma_m[c]) return;
      others.push_back(static_cast<std::uint32_t>(c));
    });
  }
  std::sort(others.begin(), others.end());
  others.erase(std::unique(others.begin(), others.end()), others.end());
  std::vector<std::uint32_t> own;
  std::set_intersection(others.begin(), others.end(), plane.cells.begin(), plane.cells.end(),
                        std::back_inserter(own));
  return static_cast<double>(own.size()) >= kMajority * static_cast<double>(others.size());
}

// True if something was measured below the patch, above or on the support, where a solid that
// stands on the support with the patch as its top would be. Points below the support show nothing.
bool IsSeenUnder(const CellView& coarse, const SupportPlane& patch, const SupportPlane& support) {
  if (patch.area_m2 < kMinBoard_m2) return false;
  const Footprint footprint(patch.plane, coarse.cells, patch.cells, coarse.grid.edge_m());
  std::size_t under = 0;
  for (std::size_t c = 0; c < coarse.cells.size(); ++c) {
    const Vector3 place = coarse.cells.points[c].cast<double>();
    const double depth_m = coarse.cells.WidePlaneTolerance_m(c);
    under += patch.plane.Height_m(place) < -kBoardClearance_m &&
             support.plane.Height_m(place) > -depth_m && footprint.Covers(place);
  }
  return Area_m2(coarse, under) >= kMaxPassing * patch.area_m2;
}

// True if upright faces that face away from the patch run from its edge down to the support: the
// sides of a solid on the support, even if its top looks large beside what the top leaves visible
// of the support. A side is visible in a pixel of the footprint if most of its slices between the
// creases (one cell high, at least two) hold cells. The visible sides must be as long as the larger
// part of the side of a square of the patch's area: one side in view, a part of it hidden.
bool HasSidesDownTo(const CellView& coarse, const SupportPlane& patch,
                    const SupportPlane& support) {
  const Vector3 middle = MeanPoint(coarse, patch.cells);
  const double edge_m = coarse.grid.edge_m();
  const double height_m = support.plane.Height_m(middle);
  const int slices = static_cast<int>(height_m / edge_m) - 2;  // without the creases at the ends
  if (slices < 2) return false;
  const Footprint footprint(patch.plane, coarse.cells, patch.cells, edge_m);
  std::map<Footprint::Pixel, std::set<int>> sides;
  for (std::size_t c = 0; c < coarse.cells.size(); ++c) {
    const Vector3 place = coarse.cells.points[c].cast<double>();
    const int slice = static_cast<int>(std::floor(support.plane.Height_m(place) / edge_m)) - 1;
    if (slice < 0 || slice >= slices || !footprint.Touches(place)) continue;
    const Vector3 normal = coarse.cells.normals[c].cast<double>();
    const Vector3 away = place - middle - patch.plane.Height_m(place) * patch.plane.normal;
    if (std::abs(normal.dot(patch.plane.normal)) > kWallRise_sin || normal.dot(away) <= 0) continue;
    sides[footprint.PixelOf(place)].insert(slice);
  }
  const auto whole = std::count_if(sides.begin(), sides.end(), [&](const auto& side) {
    return static_cast<double>(side.second.size()) >= kMainShare * slices;
  });
  return static_cast<double>(whole) * footprint.pixel_m() >= kMajority * std::sqrt(patch.area_m2);
}

// True if the cell may be level. A board at eye height is seen at a grazing angle, where normals
// scatter and lean towards the sensor. That is only known if all points were seen from one place.
bool MayBeLevel(const OrientedPoints& cells, std::uint32_t c, const Vector3f& up,
                bool is_from_one_place) {
  const float cosine = cells.normals[c].dot(up);
  if (cosine >= std::cos(kMaxTilt_rad)) return true;
  if (!is_from_one_place) return false;
  const Vector3f ray = cells.points[c] - cells.viewpoint.cast<float>();
  if (std::abs(ray.dot(up)) >= kGrazing_sin * ray.norm()) return false;
  const double gate_rad = std::min(kGate_sigma * cells.normal_sigma_rad[c], kMaxGrazingTilt_rad);
  return cosine >= std::cos(gate_rad);
}

enum class Size { kMuchLess, kAny };  // the size of a patch compared to the support

// True if the patch lies over the support, within its extent and low enough to be part of an
// object, and the sensor sees nothing under it.
bool IsObjectTop(const CellView& coarse, const SupportPlane& patch, const SupportPlane& support,
                 Size size) {
  const Vector3 middle = MeanPoint(coarse, patch.cells);
  const double height = support.plane.Height_m(middle);
  if (height < 0 || height > kHighestObjectTop_m) return false;
  if (size == Size::kMuchLess && 2 * patch.area_m2 > support.area_m2) return false;
  Eigen::AlignedBox3d bounds;
  for (std::uint32_t c : support.cells) bounds.extend(coarse.cells.points[c].cast<double>());
  const Vector3 below = middle - height * support.plane.normal;
  // chosen: the patch lies within 0.1 m of the support's extent.
  return bounds.squaredExteriorDistance(below) < 0.1 * 0.1 && !IsSeenUnder(coarse, patch, support);
}

// The supports without the tops of solids on other supports, which may be larger than what they
// leave visible of the support.
std::vector<SupportPlane> WithoutTopsOfSolids(const CellView& coarse,
                                              const std::vector<SupportPlane>& supports) {
  std::vector<SupportPlane> kept;
  for (const SupportPlane& top : supports) {
    const bool is_top = std::ranges::any_of(supports, [&](const SupportPlane& s) {
      return &s != &top && IsObjectTop(coarse, top, s, Size::kAny) &&
             HasSidesDownTo(coarse, top, s);
    });
    if (!is_top) kept.push_back(top);
  }
  return kept;
}

}  // namespace

CoarseCloud MakeCoarseCloud(const OrientedPoints& nodes, const Work& work, float max_cell_m) {
  const float edge_m =
      std::min(max_cell_m, CoarseCell_m(EveryNth(nodes.sigma_m, SampleStride(nodes.size()))));
  CoarseCloud coarse{VoxelGrid::Build(nodes.points, edge_m, work), {}};
  coarse.cells = Downsample(nodes, coarse.grid, work);
  return coarse;
}

CoarseCloud MakeSubsampledCoarseCloud(const MeasuredPoints& image, const Work& work,
                                      float max_cell_m) {
  const OrientedPoints& all = image.oriented;
  const std::size_t sampled = SampleStride(all.size());
  std::vector<float> ranges_m;
  for (std::size_t i = 0; i < all.size(); i += sampled) ranges_m.push_back(all.points[i].norm());
  const float edge_m = std::min(max_cell_m, CoarseCell_m(EveryNth(all.sigma_m, sampled)));
  const float across_px = edge_m / (Median(std::move(ranges_m)) * image.pixel_angle_rad);
  const std::size_t stride = static_cast<std::size_t>(
      std::clamp(across_px * across_px / kSampledPointsPerCell, 1.0f, kMaxSampleStride));
  OrientedPoints some;
  some.viewpoint = all.viewpoint;
  some.spread = all.spread;
  some.points_per_sample = all.points_per_sample;
  some.warp_m = all.warp_m;
  some.points = EveryNth(all.points, stride);
  some.normals = EveryNth(all.normals, stride);
  some.sigma_m = EveryNth(all.sigma_m, stride);
  some.normal_sigma_rad = EveryNth(all.normal_sigma_rad, stride);
  some.cloud_index = EveryNth(all.cloud_index, stride);
  CoarseCloud coarse{VoxelGrid::Build(some.points, edge_m, work), {}};
  coarse.cells = Downsample(some, coarse.grid, work);
  return coarse;
}

std::vector<SupportPlane> FindSupportPlanes(const CoarseCloud& coarse, const Vector3& up,
                                            const SightMap* sight, const Work& work) {
  OrientedPoints flipped = coarse.cells;  // normals up: given ones may point either way
  const Vector3f up_f = up.cast<float>();
  for (Vector3f& n : flipped.normals) {
    if (n.dot(up_f) < 0) n = -n;
  }
  const CellView cloud{coarse.grid, flipped};
  const float step = static_cast<float>(std::tan(kMaxTilt_rad));
  const auto clusters = ClusterCells(
      cloud, [&](std::uint32_t c) { return MayBeLevel(cloud.cells, c, up_f, sight != nullptr); },
      [&](std::uint32_t a, std::uint32_t b) {
        const Vector3f d = cloud.cells.points[a] - cloud.cells.points[b];
        const double gate = kGate_sigma * std::max(cloud.cells.sigma_m[a], cloud.cells.sigma_m[b]);
        return std::abs(d.dot(up_f)) <= gate + step * d.norm();
      });
  std::vector<std::vector<SupportPlane>> found(clusters.size());
  ParallelFor(clusters.size(), 1, work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) found[k] = PlanesOfCluster(cloud, clusters[k]);
  });
  std::vector<SupportPlane> planes;
  for (auto& some : found) std::move(some.begin(), some.end(), std::back_inserter(planes));
  auto larger = [](const SupportPlane& a, const SupportPlane& b) { return a.area_m2 > b.area_m2; };
  std::stable_sort(planes.begin(), planes.end(), larger);
  planes = MergeCoplanar(cloud, sight, std::move(planes));
  std::vector<SupportPlane> supports;
  for (SupportPlane& plane : planes) {
    const bool is_top = std::any_of(supports.begin(), supports.end(), [&](const SupportPlane& s) {
      return IsObjectTop(cloud, plane, s, Size::kMuchLess);
    });
    if (!is_top && IsLarge(cloud, plane) && IsSurface(cloud, plane)) {
      supports.push_back(std::move(plane));
    }
  }
  // Only the original normals show the direction in which a side faces.
  return WithoutTopsOfSolids({coarse.grid, coarse.cells}, supports);
}

}  // namespace cwm::perception
