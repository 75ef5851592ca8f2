#include "collision/spheres/bounding_spheres.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "collision/geometry/aabb.h"
#include "collision/geometry/quick_bounds.h"
#include "collision/geometry/signed_distance.h"
#include "collision/geometry/tessellate.h"

namespace cwm::collision {
namespace {

// chosen: larger meshes are represented by boxes of their tree, which bounds the time. measured: 20
// 000 triangles take some 30 ms.
constexpr std::size_t kMaxTriangles = 20000;
// derived: lengths in a cell are rounded some dozen times.
constexpr double kRoundingShare = 1e-12;

using Corners = std::array<Vector3, 3>;

// A piece in the frame of its link, with a test for its inside.
struct Solid {
  LinkPiece piece;
  Pose X_PL = Pose::Identity();
  std::vector<Aabb> boxes_P = {};  // used instead of the triangles inside them, if not empty
  double deviation_m = 0;
  WorkCounter* work = nullptr;

  bool Contains(const Vector3& p_L) const {
    const Vector3 p = X_PL * p_L;
    const auto* mesh = std::get_if<Mesh>(piece.shape);
    if (mesh == nullptr) return SignedDistance_m(*piece.shape, p) <= 0;
    if (std::ranges::any_of(boxes_P, [&](const Aabb& box) { return box.contains(p); })) return true;
    return mesh->watertight && piece.tree->Contains(p, work);
  }
};

struct Cell {
  std::size_t solid = 0;
  Aabb box;
  std::vector<Corners> surface = {};  // clipped to the box
  LinkSphere sphere = {};
};

// Clips a triangle at a plane; each side receives the triangles of its part.
void Clip(const Corners& corners, int axis, double at, std::vector<Corners>& below,
          std::vector<Corners>& above) {
  std::array<Vector3, 4> low, high;
  std::size_t lows = 0, highs = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3 &a = corners[k], &b = corners[(k + 1) % 3];
    if (a[axis] <= at) low[lows++] = a;
    if (a[axis] >= at) high[highs++] = a;
    if ((a[axis] < at && b[axis] > at) || (a[axis] > at && b[axis] < at)) {
      Vector3 cut = a + (at - a[axis]) / (b[axis] - a[axis]) * (b - a);
      cut[axis] = at;
      low[lows++] = high[highs++] = cut;
    }
  }
  for (std::size_t k = 2; k < lows; ++k) below.push_back({low[0], low[k - 1], low[k]});
  for (std::size_t k = 2; k < highs; ++k) above.push_back({high[0], high[k - 1], high[k]});
}

// A small sphere around the points: its centre moves towards the farthest point in ever smaller
// steps (Badoiu and Clarkson 2003).
LinkSphere Around(const std::vector<Vector3>& points) {
  constexpr int kSteps = 48;
  Aabb box;
  for (const Vector3& p : points) box.extend(p);
  Vector3 middle = box.center();
  LinkSphere best{.center_L = middle, .radius_m = std::numeric_limits<double>::infinity()};
  for (int step = 2; step < kSteps; ++step) {
    double farthest_m2 = -1;
    const Vector3* farthest = nullptr;
    for (const Vector3& p : points) {
      const double off_m2 = (p - middle).squaredNorm();
      if (off_m2 > farthest_m2) {
        farthest_m2 = off_m2;
        farthest = &p;
      }
    }
    if (const double radius_m = std::sqrt(farthest_m2); radius_m < best.radius_m) {
      best = {.center_L = middle, .radius_m = radius_m};
    }
    middle += (*farthest - middle) / step;
  }
  best.radius_m += kRoundingShare * (best.radius_m + best.center_L.norm());
  return best;
}

// Shrinks the cell's box to its contents, and sets its sphere. False if the cell is empty, or
// `work` has ended.
bool Fit(const Solid& solid, Cell& cell) {
  std::vector<Vector3> points;
  for (const Corners& corners : cell.surface)
    points.insert(points.end(), corners.begin(), corners.end());
  for (int k = 0; k < 8; ++k) {
    const Vector3 corner = cell.box.corner(static_cast<Aabb::CornerType>(k));
    if (solid.Contains(corner)) points.push_back(corner);
  }
  if (points.empty()) return false;
  cell.box.setEmpty();
  for (const Vector3& p : points) cell.box.extend(p);
  // Around visits each point 48 times.
  if (MustEnd(solid.work, 4 * points.size())) return false;
  cell.sphere = Around(points);
  cell.sphere.radius_m += solid.deviation_m;
  return true;
}

std::vector<Cell> Halves(const Solid& solid, const Cell& cell) {
  int axis = 0;
  cell.box.sizes().maxCoeff(&axis);
  const double at = cell.box.center()[axis];
  std::array<Cell, 2> halves;
  for (Cell& half : halves) {
    half.solid = cell.solid;
    half.box = cell.box;
  }
  halves[0].box.max()[axis] = at;
  halves[1].box.min()[axis] = at;
  for (const Corners& corners : cell.surface)
    Clip(corners, axis, at, halves[0].surface, halves[1].surface);
  std::vector<Cell> fitted;
  for (Cell& half : halves) {
    if (Fit(solid, half)) fitted.push_back(std::move(half));
  }
  return fitted;
}

// The bounds of tree nodes at a level at which there are not too many.
std::vector<Aabb> CoarseBoxes(const TriangleTree& tree) {
  const std::vector<TriangleTree::Node>& nodes = tree.nodes();
  std::vector<std::int32_t> level = {0};
  while (level.size() < kMaxTriangles / 24) {  // each box has twelve triangles
    std::vector<std::int32_t> next;
    for (std::int32_t index : level) {
      const TriangleTree::Node& node = nodes[static_cast<std::size_t>(index)];
      next.push_back(node.count > 0 ? index : index + 1);
      if (node.count == 0) next.push_back(node.right);
    }
    if (next.size() == level.size()) break;
    level = std::move(next);
  }
  std::vector<Aabb> boxes;
  for (std::int32_t index : level) boxes.push_back(nodes[static_cast<std::size_t>(index)].bounds);
  return boxes;
}

// A sphere around the bounding box of a piece.
LinkSphere AroundBox(const LinkPiece& piece) {
  const Aabb box = piece.tree != nullptr ? BoundsOfBox(piece.tree->bounds(), piece.X_LP)
                                         : TightBounds(*piece.shape, piece.X_LP);
  const Vector3 center_L = box.center();
  const double radius_m = box.diagonal().norm() / 2;
  return {.center_L = center_L,
          .radius_m = radius_m + kRoundingShare * (radius_m + center_L.norm())};
}

// The deviation of facets from a round shape: half a millimetre for shapes smaller than half a
// metre. For larger shapes it grows with the size, so that the number of triangles stays at some
// thousand.
double DeviationOf(const Shape& shape) {
  constexpr double kRelativeDeviation = 1e-3;
  return std::max(kDefaultDeviation_m,
                  kRelativeDeviation * TightBounds(shape, Pose::Identity()).sizes().maxCoeff());
}

void AddSurface(const TriangleMesh& mesh, const Pose& X_LM, std::vector<Corners>& surface) {
  for (const TriangleMesh::Triangle& triangle : mesh.triangles) {
    surface.push_back({X_LM * mesh.vertices[triangle[0]], X_LM * mesh.vertices[triangle[1]],
                       X_LM * mesh.vertices[triangle[2]]});
  }
}

Cell RootCell(Solid& solid, std::size_t index) {
  Cell cell;
  cell.solid = index;
  const Pose& X_LP = solid.piece.X_LP;
  const auto* mesh = std::get_if<Mesh>(solid.piece.shape);
  if (mesh != nullptr && !mesh->watertight) {
    solid.boxes_P = {solid.piece.tree->bounds()};
  } else if (mesh != nullptr && mesh->mesh->triangles.size() > kMaxTriangles) {
    solid.boxes_P = CoarseBoxes(*solid.piece.tree);
  }
  if (!solid.boxes_P.empty()) {
    for (const Aabb& box : solid.boxes_P) {
      const Pose X_LB = X_LP * Eigen::Translation3d(box.center());
      AddSurface(Tessellate(Box{box.sizes()}), X_LB, cell.surface);
    }
  } else {
    const double deviation_m =
        mesh != nullptr ? kDefaultDeviation_m : DeviationOf(*solid.piece.shape);
    AddSurface(Tessellate(*solid.piece.shape, deviation_m), X_LP, cell.surface);
    solid.deviation_m = mesh != nullptr ? 0 : DeviationBound_m(*solid.piece.shape, deviation_m);
  }
  for (const Corners& corners : cell.surface) {
    for (const Vector3& p : corners) cell.box.extend(p);
  }
  return cell;
}

}  // namespace

std::optional<std::vector<LinkSphere>> FitBoundingSpheres(std::span<const LinkPiece> pieces,
                                                          WorkCounter* work) {
  std::vector<Solid> solids;
  std::vector<Cell> cells;
  // With this many pieces no cell may be halved, so a sphere around each box suffices, and the
  // surfaces, which are large, are not built.
  const bool is_crowded = pieces.size() >= kMaxSpheres;
  for (const LinkPiece& piece : pieces) {
    if (HasEnded(work) || std::holds_alternative<HalfSpace>(*piece.shape)) return std::nullopt;
    solids.push_back({.piece = piece, .X_PL = piece.X_LP.inverse(), .work = work});
    if (const auto* sphere = std::get_if<Sphere>(piece.shape)) {
      cells.push_back(
          {.solid = solids.size() - 1,
           .box = {},
           .surface = {},
           .sphere = {.center_L = piece.X_LP.translation(), .radius_m = sphere->radius_m}});
      continue;
    }
    if (is_crowded) {
      cells.push_back(
          {.solid = solids.size() - 1, .box = {}, .surface = {}, .sphere = AroundBox(piece)});
      continue;
    }
    Cell whole = RootCell(solids.back(), solids.size() - 1);
    if (Fit(solids.back(), whole)) cells.push_back(std::move(whole));
  }
  const auto is_smaller = [](const Cell& a, const Cell& b) {
    const auto splits = [](const Cell& cell) {
      return cell.box.isEmpty() ? 0.0 : cell.sphere.radius_m;
    };
    return splits(a) < splits(b);
  };
  while (!cells.empty() && cells.size() < kMaxSpheres) {
    const auto largest = std::ranges::max_element(cells, is_smaller);
    if (largest->box.isEmpty() || HasEnded(work)) break;
    std::vector<Cell> halves = Halves(solids[largest->solid], *largest);
    cells.erase(largest);
    for (Cell& half : halves) cells.push_back(std::move(half));
  }
  if (HasEnded(work)) return std::nullopt;
  std::vector<LinkSphere> spheres;
  for (const Cell& cell : cells) spheres.push_back(cell.sphere);
  return spheres;
}

}  // namespace cwm::collision
