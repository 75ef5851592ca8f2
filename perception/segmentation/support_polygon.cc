#include "perception/segmentation/support_polygon.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "perception/segmentation/cell_mask.h"
#include "perception/segmentation/outline_tracing.h"

namespace cwm::perception {
namespace {

// chosen: cells hold several nodes of an evenly sampled surface, so that few stay empty by chance.
constexpr double kCell_spacings = 3;
// chosen: the largest side of a raster: the floor of a room of 10 m in cells of 26 mm, 150 000
// cells in all.
constexpr int kMaxRasterSide = 384;

// An orthonormal basis with z along the normal and x along the projection of the parent's x (of its
// y if the normal is nearly x).
Matrix3 LevelBasis(const Vector3& normal) {
  Vector3 x = Vector3::UnitX() - normal.x() * normal;
  if (x.norm() < 0.1) x = Vector3::UnitY() - normal.y() * normal;
  x.normalize();
  Matrix3 basis;
  basis << x, normal.cross(x), normal;
  return basis;
}

// A raster of the plane with the nodes that were seen on it.
class PlaneRaster {
 public:
  // `places` are those of the nodes in the plane.
  PlaneRaster(const std::vector<Vector2>& places, double cell_m) {
    Eigen::AlignedBox2d bounds;
    for (const Vector2& p : places) bounds.extend(p);
    cell_m_ = std::max(cell_m, bounds.sizes().maxCoeff() / (kMaxRasterSide - 1));
    low_ = bounds.min();
    const Eigen::Vector2i size = (bounds.sizes() / cell_m_).cast<int>() + Eigen::Vector2i::Ones();
    seen_ = CellMask::Empty(size.x(), size.y());
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const auto columns = static_cast<std::size_t>(size.x());
    const auto rows = static_cast<std::size_t>(size.y());
    left_.assign(rows, {kInfinity, 0});
    right_.assign(rows, {-kInfinity, 0});
    lowest_.assign(columns, {0, kInfinity});
    highest_.assign(columns, {0, -kInfinity});
    for (const Vector2& p : places) Mark(p);
  }

  double cell_m() const { return cell_m_; }
  const CellMask& seen() const { return seen_; }
  Vector2 Center(int x, int y) const { return PlaceOf(Vector2(x, y)); }
  // The place of a point whose coordinates are in cells, as TraceOutline returns them.
  Vector2 PlaceOf(const Vector2& p) const { return low_ + cell_m_ * (p + Vector2(0.5, 0.5)); }
  Eigen::Vector2i CellOf(const Vector2& place) const {
    return ((place - low_) / cell_m_).array().floor().cast<int>().matrix();
  }

  // The convex hull of the nodes, to one cell: only the nodes at the ends of rows and columns of
  // cells are tested as corners.
  Polygon Hull() const {
    std::vector<Vector2> ends;
    for (const auto* some : {&left_, &right_, &lowest_, &highest_}) {
      for (const Vector2& p : *some) {
        if (p.allFinite()) ends.push_back(p);
      }
    }
    return ConvexHull(std::move(ends));
  }

  // Cells whose middle lies in the convex polygon, and all cells that were seen.
  CellMask Filled(const Polygon& hull) const {
    CellMask mask = seen_;
    for (int y = 0; y < mask.height; ++y) {
      const double v = Center(0, y).y();
      double from = std::numeric_limits<double>::infinity(), to = -from;
      for (std::size_t i = 0, j = hull.size() - 1; i < hull.size(); j = i++) {
        const Vector2 &a = hull[j], &b = hull[i];
        if ((a.y() > v) == (b.y() > v)) continue;
        const double u = a.x() + (v - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
        from = std::min(from, u);
        to = std::max(to, u);
      }
      if (!(from <= to)) continue;
      const int first = std::max(0, CellOf({from + 0.5 * cell_m_, v}).x());
      const int last = std::min(mask.width - 1, CellOf({to - 0.5 * cell_m_, v}).x());
      for (int x = first; x <= last; ++x) mask.on[mask.Index(x, y)] = 1;
    }
    return mask;
  }

 private:
  void Mark(const Vector2& p) {
    const Eigen::Vector2i cell = ((p - low_) / cell_m_).cast<int>();  // never negative
    seen_.on[seen_.Index(cell.x(), cell.y())] = 1;
    const auto x = static_cast<std::size_t>(cell.x()), y = static_cast<std::size_t>(cell.y());
    if (p.x() < left_[y].x()) left_[y] = p;
    if (p.x() > right_[y].x()) right_[y] = p;
    if (p.y() < lowest_[x].y()) lowest_[x] = p;
    if (p.y() > highest_[x].y()) highest_[x] = p;
  }

  double cell_m_ = 1;
  Vector2 low_ = Vector2::Zero();
  CellMask seen_;
  // The nodes at the ends of each row and each column of cells; infinite for an empty one.
  std::vector<Vector2> left_, right_, lowest_, highest_;
};

class SupportBounder {
 public:
  SupportBounder(const SupportPlane& support, const CoarseCloud& coarse,
                 const OrientedPoints& nodes, const SightMap* sight)
      : support_(support),
        coarse_(coarse),
        nodes_(nodes),
        sight_(sight),
        basis_(LevelBasis(support.plane.normal)),
        raster_(PlacesOfNodes(), Cell_m()) {}

  std::vector<BoundedSupport> Bound() const {
    std::vector<BoundedSupport> bounded;
    const Polygon hull = raster_.Hull();
    const double min_area_m2 = raster_.cell_m() * raster_.cell_m();
    if (hull.size() < 3 || SignedArea_m2(hull) < min_area_m2) return bounded;
    const CellMask within = raster_.Filled(hull);
    // Free places into which no square of three cells fits count as noise.
    const CellMask free = Opened(Free(within), 1);
    if (std::find(free.on.begin(), free.on.end(), 1) == free.on.end()) {
      const SimplifyLimits limits{.tolerance = 0.5 * raster_.cell_m()};
      bounded.push_back({support_, MakePlate(Simplified({hull, {}}, limits))});
      return bounded;
    }
    CellMask solid = within;
    for (std::size_t k = 0; k < solid.on.size(); ++k) solid.on[k] &= free.on[k] == 0;
    AppendParts(solid, bounded);
    return bounded;
  }

 private:
  Vector2 InPlane(const Vector3& p) const { return {basis_.col(0).dot(p), basis_.col(1).dot(p)}; }

  std::vector<Vector2> PlacesOfNodes() const {
    std::vector<Vector2> places;
    places.reserve(NodeCount());
    for (std::uint32_t c : support_.cells) {
      for (std::uint32_t i : coarse_.grid.PointsOf(c)) {
        const double gate_m = kGate_sigma * nodes_.sigma_m[i];
        if (std::abs(support_.plane.Height_m(nodes_.points[i])) > gate_m) continue;
        places.push_back(InPlane(nodes_.points[i].cast<double>()));
      }
    }
    return places;
  }

  std::size_t NodeCount() const {
    std::size_t nodes = 0;
    for (std::uint32_t c : support_.cells) nodes += coarse_.grid.PointsOf(c).size();
    return nodes;
  }

  double Cell_m() const {
    const double spacing_m =
        std::sqrt(support_.area_m2 / std::max(1.0, static_cast<double>(NodeCount())));
    return std::max(0.5 * coarse_.grid.edge_m(), kCell_spacings * spacing_m);
  }

  CellMask Free(const CellMask& within) const {
    CellMask free = within;
    if (sight_ == nullptr) {
      const auto reach = static_cast<int>(kClosing_m / raster_.cell_m());
      const CellMask closed = Closed(raster_.seen(), reach);
      for (std::size_t k = 0; k < free.on.size(); ++k) free.on[k] &= closed.on[k] == 0;
      return free;
    }
    const PassageTest passes(*sight_, support_.plane, coarse_.cells, support_.cells);
    for (int y = 0; y < free.height; ++y) {
      for (int x = 0; x < free.width; ++x) {
        char& on = free.on[free.Index(x, y)];
        on = on != 0 && !raster_.seen().Has(x, y) && passes(PointAt(raster_.Center(x, y)));
      }
    }
    return free;
  }

  Vector3 PointAt(const Vector2& place) const {
    return basis_ * Vector3(place.x(), place.y(), support_.plane.offset_m);
  }

  // Appends the connected parts of the mask of which enough was seen.
  void AppendParts(const CellMask& solid, std::vector<BoundedSupport>& bounded) const {
    const Components parts = ComponentsOf(solid);
    std::vector<SupportPlane> supports(static_cast<std::size_t>(parts.count),
                                       {support_.plane, {}, 0});
    const double cell_area = support_.area_m2 / static_cast<double>(support_.cells.size());
    for (std::uint32_t c : support_.cells) {
      const std::int32_t part = PartNear(parts, InPlane(coarse_.cells.points[c].cast<double>()));
      if (part == kNoIndex) continue;
      supports[static_cast<std::size_t>(part)].cells.push_back(c);
      supports[static_cast<std::size_t>(part)].area_m2 += cell_area;
    }
    for (std::int32_t k = 0; k < parts.count; ++k) {
      SupportPlane& support = supports[static_cast<std::size_t>(k)];
      if (support.area_m2 < std::min(kMinSupport_m2, 0.5 * support_.area_m2)) continue;
      CellMask part = solid;
      for (std::size_t i = 0; i < part.on.size(); ++i) part.on[i] = parts.of_cell[i] == k;
      Outline outline = TraceOutline(part);
      for (Vector2& p : outline.border) p = raster_.PlaceOf(p);
      for (Polygon& hole : outline.holes) {
        for (Vector2& p : hole) p = raster_.PlaceOf(p);
      }
      const SimplifyLimits limits{.tolerance = 0.5 * raster_.cell_m()};
      bounded.push_back({std::move(support), MakePlate(Simplified(std::move(outline), limits))});
    }
    std::stable_sort(bounded.begin(), bounded.end(), [](const auto& a, const auto& b) {
      return a.support.area_m2 > b.support.area_m2;
    });
  }

  // The part at the place or within two cells of it: a coarse cell's centroid may lie in a raster
  // cell without nodes.
  std::int32_t PartNear(const Components& parts, const Vector2& place) const {
    const CellMask& seen = raster_.seen();
    const Eigen::Vector2i cell = raster_.CellOf(place);
    for (int ring = 0; ring <= 2; ++ring) {
      for (int y = cell.y() - ring; y <= cell.y() + ring; ++y) {
        for (int x = cell.x() - ring; x <= cell.x() + ring; ++x) {
          if (x < 0 || y < 0 || x >= seen.width || y >= seen.height) continue;
          const std::int32_t part = parts.of_cell[seen.Index(x, y)];
          if (part != kNoIndex) return part;
        }
      }
    }
    return kNoIndex;
  }

  Placed<Plate> MakePlate(Outline outline) const {
    Eigen::AlignedBox2d bounds;
    for (const Vector2& v : outline.border) bounds.extend(v);
    const Vector2 middle = bounds.center();
    for (Vector2& v : outline.border) v -= middle;
    for (Polygon& hole : outline.holes) {
      for (Vector2& v : hole) v -= middle;
    }
    Placed<Plate> placed;
    placed.shape = {.outline = std::move(outline.border),
                    .holes = std::move(outline.holes),
                    .thickness_m = kPlateThickness_m};
    placed.X_FS.linear() = basis_;
    placed.X_FS.translation() = PointAt(middle);
    return placed;
  }

  const SupportPlane& support_;
  const CoarseCloud& coarse_;
  const OrientedPoints& nodes_;
  const SightMap* sight_;
  Matrix3 basis_;
  PlaneRaster raster_;
};

}  // namespace

std::vector<BoundedSupport> BoundSupport(const SupportPlane& support, const CoarseCloud& coarse,
                                         const OrientedPoints& nodes, const SightMap* sight) {
  if (support.cells.empty()) return {};
  return SupportBounder(support, coarse, nodes, sight).Bound();
}

double OutsideOutline_m(const Placed<Plate>& plate, const Vector3& point) {
  const Vector3 local = plate.X_FS.inverse(Eigen::Isometry) * point;
  const Vector2 p = local.head<2>();
  double to_border = (NearestOnBorder(plate.shape.outline, p) - p).norm();
  if (!Contains(plate.shape.outline, p)) return to_border;
  for (const Polygon& hole : plate.shape.holes) {
    const double to_hole = (NearestOnBorder(hole, p) - p).norm();
    if (Contains(hole, p)) return to_hole;
    to_border = std::min(to_border, to_hole);
  }
  return -to_border;
}

}  // namespace cwm::perception
