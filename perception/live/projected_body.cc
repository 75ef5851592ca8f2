#include "perception/live/projected_body.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <variant>

#include "collision/geometry/aabb.h"
#include "perception/live/box_edges.h"

namespace cwm::perception {
namespace {

// chosen: no depth camera measures nearer, and projections are bounded from here on.
constexpr double kNearPlane_m = 0.01;
constexpr double kMaxInverseDepth = 1 / kNearPlane_m;
// derived: a square metre times the precision of a double; the camera is on the surface.
constexpr double kOnSurface_m2 = 1e-14;

// Bounds of places in the image, in pixels.
using ImageBounds = Eigen::AlignedBox2d;

int ClampedTo(double px, int size) {
  return static_cast<int>(std::clamp(px, 0.0, static_cast<double>(size)));
}

// The pixels whose centres are within the bounds, and one more on each side.
PixelRectangle PixelsIn(const ImageBounds& bounds, const DepthCamera& camera) {
  if (bounds.isEmpty()) return {};
  return {.u_begin = ClampedTo(std::floor(bounds.min().x()), camera.width),
          .v_begin = ClampedTo(std::floor(bounds.min().y()), camera.height),
          .u_end = ClampedTo(std::ceil(bounds.max().x()) + 1, camera.width),
          .v_end = ClampedTo(std::ceil(bounds.max().y()) + 1, camera.height)};
}

// The part of a polygon beyond the near plane (Sutherland and Hodgman 1974). A polygon that is cut
// into several pieces gets sides along the plane that cancel each other by the even-odd rule.
void ClipAtNearPlane(std::span<const Vector3> polygon, std::vector<Vector3>& clipped) {
  clipped.clear();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3& a = polygon[i];
    const Vector3& b = polygon[(i + 1) % polygon.size()];
    const bool a_beyond = a.z() >= kNearPlane_m;
    const bool b_beyond = b.z() >= kNearPlane_m;
    if (a_beyond) clipped.push_back(a);
    if (a_beyond == b_beyond) continue;
    // From the same end in both directions, so that neighbours share the point to the bit.
    const Vector3& from = a_beyond ? a : b;
    const Vector3& to = a_beyond ? b : a;
    const double share = (kNearPlane_m - from.z()) / (to.z() - from.z());
    Vector3 cut = from + share * (to - from);
    cut.z() = kNearPlane_m;
    clipped.push_back(cut);
  }
}

}  // namespace

class ProjectedBody::Builder {
 public:
  Builder(const DepthCamera& camera, ProjectedBody& out) : camera_(camera), out_(out) {}

  void Add(const Shape& shape, const Pose& X_CS) {
    X_CS_ = X_CS;
    const Pose X_SC = X_CS.inverse();
    const Pinhole& pinhole = camera_.pinhole;
    rays_.origin = X_SC.translation();
    rays_.per_u = X_SC.linear().col(0) / pinhole.focal_u_px;
    rays_.per_v = X_SC.linear().col(1) / pinhole.focal_v_px;
    rays_.at_0 = X_SC.linear().col(2) - pinhole.center_u_px * rays_.per_u -
                 pinhole.center_v_px * rays_.per_v;
    std::visit([this](const auto& alternative) { AddShape(alternative); }, shape);
  }

  void AddSurface(const Mesh& mesh, const Pose& X_CB) {
    X_CS_ = X_CB;
    AddShape(mesh);
  }

 private:
  Vector3 Project(const Vector3& p_C) const {  // u, v, 1 / z
    const double inverse = 1 / p_C.z();
    return {camera_.pinhole.focal_u_px * p_C.x() * inverse + camera_.pinhole.center_u_px,
            camera_.pinhole.focal_v_px * p_C.y() * inverse + camera_.pinhole.center_v_px, inverse};
  }

  void AddShape(const Sphere& sphere) { AddSphere(0, sphere.radius_m); }

  void AddShape(const Box& box) {
    const Vector3 half = 0.5 * box.size_m;
    for (int axis = 0; axis < 3; ++axis) {
      if (std::abs(rays_.origin[axis]) <= half[axis]) continue;
      const double side = std::copysign(1.0, rays_.origin[axis]);
      const int first = (axis + 1) % 3;
      const int second = (axis + 2) % 3;
      std::array<Vector3, 4> corners;
      for (std::size_t i = 0; i < 4; ++i) {
        corners[i][axis] = side * half[axis];
        corners[i][first] = (i == 0 || i == 3 ? -1 : 1) * half[first];
        corners[i][second] = (i < 2 ? -1 : 1) * half[second];
      }
      const Vector3 normal = side * Vector3::Unit(axis);
      AddFace(corners, normal);
    }
  }

  void AddShape(const Cylinder& cylinder) {
    AddLateral(cylinder.radius_m, 0, 0.5 * cylinder.length_m, true);
    AddEnds(cylinder.radius_m, cylinder.radius_m, 0.5 * cylinder.length_m);
  }

  void AddShape(const Cone& cone) {
    AddLateral(0.5 * (cone.radius_bottom_m + cone.radius_top_m),
               (cone.radius_top_m - cone.radius_bottom_m) / cone.length_m, 0.5 * cone.length_m,
               false);
    AddEnds(cone.radius_bottom_m, cone.radius_top_m, 0.5 * cone.length_m);
  }

  // Rays meet the ends of its cylinder only inside of its spheres.
  void AddShape(const Capsule& capsule) {
    AddLateral(capsule.radius_m, 0, 0.5 * capsule.length_m, true);
    AddSphere(-0.5 * capsule.length_m, capsule.radius_m);
    AddSphere(0.5 * capsule.length_m, capsule.radius_m);
  }

  void AddShape(const HalfSpace&) {
    if (rays_.origin.z() <= 0) return;
    const Vector2 last(camera_.width, camera_.height);
    const std::array<Vector2, 4> corners = {Vector2(-1, -1), Vector2(last.x(), -1), last,
                                            Vector2(-1, last.y())};
    const auto edge_begin = static_cast<std::uint32_t>(out_.edges_.size());
    for (std::size_t i = 0; i < 4; ++i) AddEdge(corners[i], corners[(i + 1) % 4]);
    Finish({.w_min = -std::numeric_limits<float>::infinity(),
            .w_max = static_cast<float>(kMaxInverseDepth),
            .edge_begin = edge_begin,
            .bounds = {.u_end = camera_.width, .v_end = camera_.height}},
           X_CS_.linear().col(2), X_CS_.translation());
  }

  void AddShape(const Plate& plate) {
    const double z = rays_.origin.z();
    if (z > 0 || z < -plate.thickness_m) AddPlateFace(plate, z > 0 ? 0 : -plate.thickness_m);
    AddRim(plate.outline, plate.thickness_m);
    for (const cwm::Polygon& hole : plate.holes) AddRim(hole, plate.thickness_m);
  }

  void AddShape(const Convex& convex) { AddTriangles(*convex.hull, true); }

  void AddShape(const Mesh& mesh) {
    if (mesh.mesh != nullptr) AddTriangles(*mesh.mesh, mesh.watertight);
  }

  void AddSphere(double z, double radius_m) {
    const double from_center = rays_.origin.z() - z;
    Quadric quadric = {.rays = rays_, .z_square = 1, .z_linear = from_center};
    quadric.c =
        rays_.origin.head<2>().squaredNorm() + from_center * from_center - radius_m * radius_m;
    if (quadric.c <= kOnSurface_m2) return;  // from inside
    quadric.bounds = BoundsOf(Aabb(Vector3(-radius_m, -radius_m, z - radius_m),
                                   Vector3(radius_m, radius_m, z + radius_m)));
    Keep(quadric, out_.quadrics_);
  }

  void AddLateral(double mid_radius_m, double slope, double half_length_m, bool is_cylinder) {
    const double radius_m = mid_radius_m + slope * rays_.origin.z();
    Quadric quadric = {.rays = rays_,
                       .z_square = -slope * slope,
                       .z_linear = -radius_m * slope,
                       .c = rays_.origin.head<2>().squaredNorm() - radius_m * radius_m,
                       .slope = slope,
                       .radius_at_origin = radius_m,
                       .half_length_m = half_length_m};
    if (is_cylinder && quadric.c <= kOnSurface_m2) return;  // the camera looks at an end
    if (std::abs(quadric.c) < kOnSurface_m2) quadric.c = kOnSurface_m2;
    const double widest_m = mid_radius_m + std::abs(slope) * half_length_m;
    quadric.bounds = BoundsOf(Aabb(Vector3(-widest_m, -widest_m, -half_length_m),
                                   Vector3(widest_m, widest_m, half_length_m)));
    Keep(quadric, out_.quadrics_);
  }

  void AddEnds(double radius_bottom_m, double radius_top_m, double half_length_m) {
    if (rays_.origin.z() > half_length_m) AddDisc(half_length_m, radius_top_m);
    if (rays_.origin.z() < -half_length_m) AddDisc(-half_length_m, radius_bottom_m);
  }

  void AddDisc(double z, double radius_m) {
    Keep(Disc{.rays = rays_,
              .z = z,
              .radius_m = radius_m,
              .bounds =
                  BoundsOf(Aabb(Vector3(-radius_m, -radius_m, z), Vector3(radius_m, radius_m, z)))},
         out_.discs_);
  }

  void AddPlateFace(const Plate& plate, double z) {
    const Vector3 normal = Vector3::UnitZ();
    const auto edge_begin = BeginFace();
    const auto add_loop = [&](const cwm::Polygon& loop) {
      corners_.clear();
      for (const Vector2& p : loop) corners_.push_back(X_CS_ * Vector3(p.x(), p.y(), z));
      AddLoop(corners_);
    };
    add_loop(plate.outline);
    for (const cwm::Polygon& hole : plate.holes) add_loop(hole);
    FinishFace(edge_begin, X_CS_.linear() * normal, X_CS_ * Vector3(0, 0, z));
  }

  // Sides that face away are behind others, so none needs to be left out.
  void AddRim(const cwm::Polygon& polygon, double thickness_m) {
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vector2& a = polygon[i];
      const Vector2& b = polygon[(i + 1) % polygon.size()];
      const std::array<Vector3, 4> corners = {Vector3(a.x(), a.y(), 0), Vector3(b.x(), b.y(), 0),
                                              Vector3(b.x(), b.y(), -thickness_m),
                                              Vector3(a.x(), a.y(), -thickness_m)};
      AddFace(corners, Vector3(b.y() - a.y(), a.x() - b.x(), 0));
    }
  }

  // A planar face with corners and normal in the frame of the shape.
  void AddFace(const std::array<Vector3, 4>& corners, const Vector3& normal) {
    const auto edge_begin = BeginFace();
    corners_.clear();
    for (const Vector3& corner : corners) corners_.push_back(X_CS_ * corner);
    AddLoop(corners_);
    FinishFace(edge_begin, X_CS_.linear() * normal, corners_.front());
  }

  void AddTriangles(const TriangleMesh& mesh, bool is_closed) {
    points_C_.clear();
    projected_.clear();
    for (const Vector3& vertex : mesh.vertices) {
      points_C_.push_back(X_CS_ * vertex);
      projected_.push_back(Project(points_C_.back()));
    }
    for (const auto& [a, b, c] : mesh.triangles) {
      const Vector3& p_a = points_C_[a];
      const Vector3& p_b = points_C_[b];
      const Vector3& p_c = points_C_[c];
      const bool is_cut = std::min({p_a.z(), p_b.z(), p_c.z()}) < kNearPlane_m;
      if (is_cut && std::max({p_a.z(), p_b.z(), p_c.z()}) < kNearPlane_m) continue;
      if (!is_cut && ShowsNoPixel(projected_[a], projected_[b], projected_[c])) continue;
      const Vector3 normal = (p_b - p_a).cross(p_c - p_a);
      if (is_closed && normal.dot(p_a) >= 0) continue;
      const auto edge_begin = BeginFace();
      if (is_cut) {
        AddLoop(std::array<Vector3, 3>{p_a, p_b, p_c});
      } else {
        AddProjectedLoop(std::array<Vector3, 3>{projected_[a], projected_[b], projected_[c]});
      }
      FinishFace(edge_begin, normal, p_a);
    }
  }

  // True if the triangle is outside of the image or between the pixels' centres.
  bool ShowsNoPixel(const Vector3& a, const Vector3& b, const Vector3& c) const {
    const Vector3 low = a.cwiseMin(b).cwiseMin(c);
    const Vector3 high = a.cwiseMax(b).cwiseMax(c);
    return std::ceil(low.x()) >= std::ceil(high.x()) || std::ceil(low.y()) >= std::ceil(high.y()) ||
           high.x() < 0 || high.y() < 0 || low.x() > camera_.width || low.y() > camera_.height;
  }

  std::uint32_t BeginFace() {
    image_.setEmpty();
    w_min_ = std::numeric_limits<double>::infinity();
    w_max_ = 0;
    return static_cast<std::uint32_t>(out_.edges_.size());
  }

  void AddLoop(std::span<const Vector3> polygon_C) {
    ClipAtNearPlane(polygon_C, clipped_);
    for (Vector3& p : clipped_) p = Project(p);
    AddProjectedLoop(clipped_);
  }

  void AddProjectedLoop(std::span<const Vector3> polygon) {
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vector3& a = polygon[i];
      image_.extend(Vector2(a.head<2>()));
      w_min_ = std::min(w_min_, a.z());
      w_max_ = std::max(w_max_, a.z());
      AddEdge(a.head<2>(), polygon[(i + 1) % polygon.size()].head<2>());
    }
  }

  // The same edge for both directions, to the bit, so that neighbours leave no gap.
  void AddEdge(const Vector2& a, const Vector2& b) {
    if (std::ceil(a.y()) == std::ceil(b.y())) return;  // crosses no row
    const Vector2& low = a.y() < b.y() ? a : b;
    const Vector2& high = a.y() < b.y() ? b : a;
    out_.edges_.push_back({.u_low = low.x(),
                           .v_low = low.y(),
                           .v_high = high.y(),
                           .u_per_v = (high.x() - low.x()) / (high.y() - low.y())});
  }

  void FinishFace(std::uint32_t edge_begin, const Vector3& normal_C, const Vector3& point_C) {
    Finish({.w_min = static_cast<float>(w_min_),
            .w_max = static_cast<float>(w_max_),
            .edge_begin = edge_begin,
            .bounds = PixelsIn(image_, camera_)},
           normal_C, point_C);
  }

  // The plane n * (z d) = n * p of directions d with depth 1, as 1 / z = (n * d) / (n * p).
  void Finish(Polygon polygon, const Vector3& normal_C, const Vector3& point_C) {
    polygon.edge_end = static_cast<std::uint32_t>(out_.edges_.size());
    const Vector3 plane = normal_C / normal_C.dot(point_C);
    if (!plane.allFinite() || polygon.edge_begin == polygon.edge_end || polygon.bounds.empty()) {
      out_.edges_.resize(polygon.edge_begin);  // seen edge-on, or not at all
      return;
    }
    const Pinhole& pinhole = camera_.pinhole;
    polygon.w_u = plane.x() / pinhole.focal_u_px;
    polygon.w_v = plane.y() / pinhole.focal_v_px;
    polygon.w_0 = plane.z() - polygon.w_u * pinhole.center_u_px - polygon.w_v * pinhole.center_v_px;
    Keep(polygon, out_.polygons_);
  }

  PixelRectangle BoundsOf(const Aabb& box_S) const {
    std::array<Vector3, 8> corners_C;
    for (int i = 0; i < 8; ++i) {
      corners_C[static_cast<std::size_t>(i)] =
          X_CS_ * box_S.corner(static_cast<Aabb::CornerType>(i));
    }
    ImageBounds bounds;
    for (const auto& [first, second] : kBoxEdges) {
      Vector3 a = corners_C[static_cast<std::size_t>(first)];
      Vector3 b = corners_C[static_cast<std::size_t>(second)];
      if (a.z() > b.z()) std::swap(a, b);
      if (b.z() < kNearPlane_m) continue;
      if (a.z() < kNearPlane_m) a += (kNearPlane_m - a.z()) / (b.z() - a.z()) * (b - a);
      bounds.extend(Vector2(Project(a).head<2>())).extend(Vector2(Project(b).head<2>()));
    }
    return PixelsIn(bounds, camera_);
  }

  template <class Face>
  void Keep(const Face& face, std::vector<Face>& faces) {
    if (face.bounds.empty()) return;
    out_.bounds_ = Hull(out_.bounds_, face.bounds);
    faces.push_back(face);
  }

  const DepthCamera& camera_;
  ProjectedBody& out_;
  Pose X_CS_ = Pose::Identity();
  Rays rays_ = {};
  // They belong to the face being added.
  ImageBounds image_;
  double w_min_ = 0;
  double w_max_ = 0;
  std::vector<Vector3> corners_, clipped_, points_C_, projected_;
};

ProjectedBody::ProjectedBody(const HybridModel& model, const Pose& X_CB,
                             const DepthCamera& camera) {
  Builder builder(camera, *this);
  for (const ShapePart& part : model.shapes) builder.Add(part.shape, X_CB * part.X_OS);
  for (const SurfacePart& part : model.surfaces) builder.AddSurface(part.surface, X_CB);
  for (const Handle& handle : model.handles) builder.AddSurface(handle.surface, X_CB);
}

void ProjectedBody::Draw(BodyId id, const PixelRectangle& within,
                         const InverseDepthBuffer& buffer) const {
  if (Intersection(bounds_, within).empty()) return;
  std::vector<double> crossings;
  for (const Polygon& polygon : polygons_) Draw(polygon, id, within, buffer, crossings);

  // Offers an inverse depth at a pixel; not if it is not a number.
  const auto offer = [&](double w, bool is_surface, std::size_t pixel) {
    const auto inverse = static_cast<float>(w);
    if (!(is_surface && w <= kMaxInverseDepth && inverse > buffer.inverse_depth[pixel])) return;
    buffer.inverse_depth[pixel] = inverse;
    buffer.body[pixel] = id;
  };
  const auto for_pixels = [&](const auto& face, const auto& draw) {
    const PixelRectangle pixels = Intersection(face.bounds, within);
    const Rays& rays = face.rays;
    for (int v = pixels.v_begin; v < pixels.v_end; ++v) {
      const Vector3 at_row = rays.at_0 + v * rays.per_v;
      const std::size_t row = static_cast<std::size_t>(v) * buffer.width;
      for (int u = pixels.u_begin; u < pixels.u_end; ++u) {
        draw(Vector3(at_row + u * rays.per_u), row + u);
      }
    }
  };
  for (const Quadric& quadric : quadrics_) {
    const Vector3& o = quadric.rays.origin;
    const double inverse_c = 1 / quadric.c;
    for_pixels(quadric, [&](const Vector3& d, std::size_t pixel) {
      const double a = d.x() * d.x() + d.y() * d.y() + quadric.z_square * d.z() * d.z();
      const double b = o.x() * d.x() + o.y() * d.y() + quadric.z_linear * d.z();
      const double discriminant = b * b - a * quadric.c;
      if (discriminant < 0) return;
      // The root at which a ray from outside enters, whatever the signs of a and c.
      const double w = (std::sqrt(discriminant) - b) * inverse_c;
      const bool is_surface = std::abs(o.z() * w + d.z()) <= quadric.half_length_m * w &&
                              quadric.radius_at_origin * w + quadric.slope * d.z() >= 0;
      offer(w, is_surface, pixel);
    });
  }
  for (const Disc& disc : discs_) {
    const Vector3& o = disc.rays.origin;
    const double inverse_height = 1 / (disc.z - o.z());
    const double radius_squared = disc.radius_m * disc.radius_m;
    for_pixels(disc, [&](const Vector3& d, std::size_t pixel) {
      const double w = d.z() * inverse_height;
      const double x = o.x() * w + d.x();
      const double y = o.y() * w + d.y();
      offer(w, x * x + y * y <= radius_squared * w * w, pixel);
    });
  }
}

void ProjectedBody::Draw(const Polygon& polygon, BodyId id, const PixelRectangle& within,
                         const InverseDepthBuffer& buffer, std::vector<double>& crossings) const {
  const PixelRectangle pixels = Intersection(polygon.bounds, within);
  if (pixels.empty()) return;
  const auto begin = edges_.begin() + polygon.edge_begin;
  const auto end = edges_.begin() + polygon.edge_end;
  const auto step = static_cast<float>(polygon.w_u);
  for (int v = pixels.v_begin; v < pixels.v_end; ++v) {
    crossings.clear();
    for (auto edge = begin; edge != end; ++edge) {
      if (v < edge->v_low || v >= edge->v_high) continue;
      crossings.push_back(edge->u_low + (v - edge->v_low) * edge->u_per_v);
    }
    if (crossings.size() == 2) {
      if (crossings[0] > crossings[1]) std::swap(crossings[0], crossings[1]);
    } else {
      std::sort(crossings.begin(), crossings.end());
    }
    for (std::size_t i = 0; i + 1 < crossings.size(); i += 2) {
      // Relative to the first pixel of the span in the image, whatever is drawn of it.
      const int u_first = ClampedTo(std::ceil(crossings[i]), buffer.width);
      const int u_begin = std::max(u_first, pixels.u_begin);
      const int u_end =
          std::min(ClampedTo(std::ceil(crossings[i + 1]), buffer.width), pixels.u_end);
      const auto base = static_cast<float>(polygon.w_0 + polygon.w_v * v + polygon.w_u * u_first);
      float* const inverse = buffer.inverse_depth + static_cast<std::size_t>(v) * buffer.width;
      BodyId* const body = buffer.body + static_cast<std::size_t>(v) * buffer.width;
      for (int u = u_begin; u < u_end; ++u) {
        const float w = std::min(
            std::max(base + step * static_cast<float>(u - u_first), polygon.w_min), polygon.w_max);
        const bool is_nearer = w > inverse[u];
        inverse[u] = is_nearer ? w : inverse[u];
        body[u] = is_nearer ? id : body[u];
      }
    }
  }
}

}  // namespace cwm::perception
