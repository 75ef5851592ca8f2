#include "collision/mesh_files/mesh_builder.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/geometry/polygon.h"

namespace cwm::collision {
namespace {

constexpr std::size_t kMaxCorners = 4096;
// chosen: the total work allows four of the largest polygons, plus 64 per corner, which is what
// each corner takes in a file of 64-cornered polygons. measured: one unit of work (a corner
// squared) takes some 5 ns.
constexpr std::size_t kMaxFreeWork = 4 * kMaxCorners * kMaxCorners;
constexpr std::size_t kMaxWorkPerCorner = 64;

using Corners = std::vector<Vector3>;

// Twice the area times the unit normal (Newell), also for polygons that are not quite flat.
Vector3 AreaVector(const Corners& corners) {
  Vector3 area = Vector3::Zero();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector3& next = corners[(i + 1) % corners.size()];
    area += (corners[i] - corners[0]).cross(next - corners[0]);
  }
  return area;
}

std::vector<std::array<int, 3>> Fan(std::size_t corners) {
  std::vector<std::array<int, 3>> triangles;
  for (int i = 1; i + 1 < static_cast<int>(corners); ++i) triangles.push_back({0, i, i + 1});
  return triangles;
}

std::vector<std::array<int, 3>> TriangulatePolygon(const Corners& corners) {
  const Vector3 area = AreaVector(corners);
  if (corners.size() == 3 || !(area.norm() > 0) || !area.allFinite()) return Fan(corners.size());
  const Matrix3 basis = BasisFromZ(area.normalized());
  Polygon outline;
  for (const Vector3& p : corners) {
    outline.emplace_back(basis.col(0).dot(p - corners[0]), basis.col(1).dot(p - corners[0]));
  }
  std::vector<std::array<int, 3>> triangles = TriangulateIndices(outline, {});
  return triangles.empty() ? Fan(corners.size()) : triangles;
}

}  // namespace

absl::Status TooManyTriangles(std::size_t max_triangles) {
  return absl::ResourceExhaustedError(
      absl::StrCat("must have at most ", max_triangles, " triangles"));
}

absl::StatusOr<std::vector<PolygonTriangulator::Triangle>> PolygonTriangulator::Triangulate(
    const Corners& corners) {
  if (corners.size() < 3 || corners.size() > kMaxCorners) {
    return absl::InvalidArgumentError("faces must have 3 to 4096 corners");
  }
  corners_ += corners.size();
  if (corners.size() > 3) work_ += corners.size() * corners.size();
  if (work_ > kMaxFreeWork + kMaxWorkPerCorner * corners_) {
    return absl::ResourceExhaustedError(
        "must not have so many faces of so many corners: the squares of their corners together "
        "must "
        "be at most 67108864 and 64 for each corner");
  }
  return TriangulatePolygon(corners);
}

absl::Status MeshBuilder::Add(const std::array<Vector3, 3>& corners) {
  TriangleMesh::Triangle t;
  for (int i = 0; i < 3; ++i) {
    if (!corners[i].allFinite()) {
      const Vector3& p = corners[i];
      return absl::InvalidArgumentError(absl::StrCat("triangle ", added_, " has the corner (",
                                                     p.x(), ", ", p.y(), ", ", p.z(),
                                                     "), must have finite vertices"));
    }
  }
  if (added_++ == max_triangles_) return TooManyTriangles(max_triangles_);
  if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) {
    return absl::OkStatus();
  }
  for (int i = 0; i < 3; ++i) t[i] = IndexOf(corners[i]);
  mesh_.triangles.push_back(t);
  return absl::OkStatus();
}

absl::Status MeshBuilder::AddPolygon(const std::vector<Vector3>& corners) {
  const absl::StatusOr<std::vector<PolygonTriangulator::Triangle>> triangles =
      triangulator_.Triangulate(corners);
  if (!triangles.ok()) return triangles.status();
  for (const PolygonTriangulator::Triangle& t : *triangles) {
    const absl::Status status = Add({corners[t[0]], corners[t[1]], corners[t[2]]});
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status MeshBuilder::CheckCapacity(std::size_t triangles) const {
  return triangles <= max_triangles_ - added_ ? absl::OkStatus() : TooManyTriangles(max_triangles_);
}

absl::StatusOr<TriangleMesh> MeshBuilder::Finish() && {
  if (mesh_.triangles.empty()) return absl::InvalidArgumentError("must have triangles");
  return std::move(mesh_);
}

std::uint32_t MeshBuilder::IndexOf(const Vector3& p) {
  const auto [at, is_new] =
      index_.try_emplace({p.x(), p.y(), p.z()}, static_cast<std::uint32_t>(mesh_.vertices.size()));
  if (is_new) mesh_.vertices.push_back(p);
  return at->second;
}

}  // namespace cwm::collision
