#include "perception/simulation/vessel_meshes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

namespace cwm::perception {
namespace {

// Facets of a pan of 140 mm radius deviate from the circle by 0.14 mm: a tenth of a camera's noise.
constexpr int kWallSegments = 96;
constexpr int kTubeSegments = 16;  // up to 7.5 mm radius: 0.14 mm too

using Ring = std::vector<Vector3>;

// A surface swept from pole to pole through rings with equal numbers of vertices. The rings are
// counter-clockwise if seen against the direction of the sweep.
class SweptMesh {
 public:
  explicit SweptMesh(const Vector3& first_pole) { mesh_.vertices.push_back(first_pole); }

  void AddRing(const Ring& ring) {
    const std::uint32_t begin = VertexCount();
    const auto count = static_cast<std::uint32_t>(ring.size());
    mesh_.vertices.insert(mesh_.vertices.end(), ring.begin(), ring.end());
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t next = (i + 1) % count;
      if (begin == 1) {
        mesh_.triangles.push_back({0, begin + next, begin + i});
      } else {
        const std::uint32_t before = begin - count;
        mesh_.triangles.push_back({before + i, before + next, begin + next});
        mesh_.triangles.push_back({before + i, begin + next, begin + i});
      }
    }
    last_ring_size_ = count;
  }

  TriangleMesh Close(const Vector3& last_pole) {
    const std::uint32_t pole = VertexCount();
    const std::uint32_t begin = pole - last_ring_size_;
    mesh_.vertices.push_back(last_pole);
    for (std::uint32_t i = 0; i < last_ring_size_; ++i) {
      mesh_.triangles.push_back({begin + i, begin + (i + 1) % last_ring_size_, pole});
    }
    return std::move(mesh_);
  }

 private:
  std::uint32_t VertexCount() const { return static_cast<std::uint32_t>(mesh_.vertices.size()); }

  TriangleMesh mesh_;
  std::uint32_t last_ring_size_ = 0;
};

Ring WallRing(double radius_m, double height_m) {
  Ring ring;
  for (int i = 0; i < kWallSegments; ++i) {
    const double angle_rad = 2 * std::numbers::pi * i / kWallSegments;
    ring.emplace_back(radius_m * std::cos(angle_rad), radius_m * std::sin(angle_rad), height_m);
  }
  return ring;
}

// Unit vector along the tube at a point: the mean of the directions to its neighbours.
Vector2 Along(const std::vector<TubePoint>& points, std::size_t i) {
  Vector2 along = Vector2::Zero();
  if (i > 0) along += (points[i].place_xz - points[i - 1].place_xz).normalized();
  if (i + 1 < points.size()) along += (points[i + 1].place_xz - points[i].place_xz).normalized();
  return along.normalized();
}

Vector3 InPlane(const Vector2& xz) { return {xz.x(), 0, xz.y()}; }

Ring TubeRing(const TubePoint& point, const Vector2& along) {
  // This vector, y and the direction of the tube are right-handed.
  const Vector3 across = InPlane({along.y(), -along.x()});
  Ring ring;
  for (int i = 0; i < kTubeSegments; ++i) {
    const double angle_rad = 2 * std::numbers::pi * i / kTubeSegments;
    ring.push_back(InPlane(point.place_xz) +
                   point.half_width_m * std::cos(angle_rad) * Vector3::UnitY() -
                   point.half_thickness_m * std::sin(angle_rad) * across);
  }
  return ring;
}

}  // namespace

double OuterRadius_m(const VesselWall& wall, double height_m) {
  const std::vector<WallPoint>& outer = wall.outer;
  const auto above = std::find_if(outer.begin(), outer.end(), [&](const WallPoint& point) {
    return point.height_m >= height_m;
  });
  if (above == outer.begin()) return outer.front().radius_m;
  if (above == outer.end()) return outer.back().radius_m;
  const auto below = above - 1;
  const double share = (height_m - below->height_m) / (above->height_m - below->height_m);
  return std::lerp(below->radius_m, above->radius_m, share);
}

TriangleMesh MakeVessel(const VesselWall& wall) {
  SweptMesh mesh({0, 0, 0});
  for (const WallPoint& point : wall.outer) mesh.AddRing(WallRing(point.radius_m, point.height_m));
  for (auto point = wall.outer.rbegin(); point != wall.outer.rend(); ++point) {
    if (point->height_m <= wall.floor_m) break;
    mesh.AddRing(WallRing(point->radius_m - wall.wall_m, point->height_m));
  }
  mesh.AddRing(WallRing(OuterRadius_m(wall, wall.floor_m) - wall.wall_m, wall.floor_m));
  return mesh.Close({0, 0, wall.floor_m});
}

TriangleMesh MakeTube(const std::vector<TubePoint>& points) {
  SweptMesh mesh(InPlane(points.front().place_xz));
  for (std::size_t i = 0; i < points.size(); ++i) {
    mesh.AddRing(TubeRing(points[i], Along(points, i)));
  }
  return mesh.Close(InPlane(points.back().place_xz));
}

}  // namespace cwm::perception
