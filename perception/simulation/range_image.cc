#include "perception/simulation/range_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "collision/geometry/aabb.h"
#include "perception/simulation/ray_casting.h"

namespace cwm::perception {
namespace {

// Pixels [u_begin, u_end) x [v_begin, v_end).
struct ScreenBounds {
  int u_begin = 0;
  int u_end = 0;
  int v_begin = 0;
  int v_end = 0;
};

constexpr double kNearestDepth_m = 0.01;  // projections are only bounded from here on

int ClampedPixel(double px, int size) {
  return static_cast<int>(std::clamp(px, 0.0, static_cast<double>(size)));
}

ScreenBounds Project(const Aabb& bounds_C, const PinholeCamera& camera) {
  const ScreenBounds whole{.u_end = camera.width, .v_end = camera.height};
  if (bounds_C.max().z() <= 0) return {};
  const bool bounded = bounds_C.min().allFinite() && bounds_C.max().allFinite();
  if (!bounded || bounds_C.min().z() < kNearestDepth_m) return whole;
  Eigen::AlignedBox2d pixels;
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3 p = bounds_C.corner(static_cast<Aabb::CornerType>(corner));
    pixels.extend(Vector2(camera.focal_px * p.x() / p.z() + camera.center_x_px,
                          camera.focal_px * p.y() / p.z() + camera.center_y_px));
  }
  return {.u_begin = ClampedPixel(std::ceil(pixels.min().x()), camera.width),
          .u_end = ClampedPixel(std::floor(pixels.max().x()) + 1, camera.width),
          .v_begin = ClampedPixel(std::ceil(pixels.min().y()), camera.height),
          .v_end = ClampedPixel(std::floor(pixels.max().y()) + 1, camera.height)};
}

struct PartId {
  std::int32_t object = 0;
  std::int32_t part = 0;
};

// Told of each pixel that a part covers, hidden or not.
class CoveredPixels {
 public:
  // `covered_by` has the last object that covered each pixel; null: nothing is counted.
  CoveredPixels(std::vector<std::int32_t>* covered_by, const RangeImage& image)
      : covered_by_(covered_by), image_(image) {
    silhouette_.row_begin = image.height;
  }

  void Add(std::int32_t object, int u, int v) {
    if (covered_by_ == nullptr) return;
    std::int32_t& last = (*covered_by_)[static_cast<std::size_t>(v) * image_.width + u];
    if (last == object) return;
    last = object;
    ++silhouette_.pixel_count;
    silhouette_.row_begin = std::min(silhouette_.row_begin, v);
    silhouette_.row_end = std::max(silhouette_.row_end, v + 1);
  }

  Silhouette Take() const { return silhouette_.pixel_count == 0 ? Silhouette{} : silhouette_; }

 private:
  std::vector<std::int32_t>* covered_by_;
  const RangeImage& image_;
  Silhouette silhouette_;
};

// A part to draw, S placed at X_CS.
struct PlacedPart {
  PartId id = {};
  Pose X_CS = Pose::Identity();
  Pose X_SC = Pose::Identity();
};

// `cast` returns where a ray in frame S hits the surface.
template <class Cast>
void Draw(const PlacedPart& part, const ScreenBounds& screen, const PinholeCamera& camera,
          const Cast& cast, RangeImage& image, CoveredPixels& covered) {
  Ray ray_S{.origin = part.X_SC.translation()};
  for (int v = screen.v_begin; v < screen.v_end; ++v) {
    for (int u = screen.u_begin; u < screen.u_end; ++u) {
      // The direction has depth 1, so t is the depth.
      ray_S.direction = part.X_SC.linear() * RayDirection(camera, u, v);
      const std::optional<RayHit> hit = cast(ray_S);
      if (!hit || hit->t > kMaxCameraDepth_m) continue;
      covered.Add(part.id.object, u, v);
      Sighting& pixel = image.pixels[static_cast<std::size_t>(v) * image.width + u];
      if (pixel.seen() && pixel.depth_m <= hit->t) continue;
      pixel = {.depth_m = hit->t,
               .normal_C = (part.X_CS.linear() * hit->normal).cast<float>(),
               .object = part.id.object,
               .part = part.id.part};
    }
  }
}

// The pixels whose rays may hit a triangle with these corners in C, farther away than
// kNearestDepth_m. Far tighter than the bounds of a box around it.
ScreenBounds ProjectTriangle(const std::array<Vector3, 3>& corners_C, const PinholeCamera& camera) {
  Eigen::AlignedBox2d pixels;
  const auto extend = [&](const Vector3& p) {
    const double scale_px = camera.focal_px / p.z();
    pixels.extend(
        Vector2(scale_px * p.x() + camera.center_x_px, scale_px * p.y() + camera.center_y_px));
  };
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3& p = corners_C[i];
    const Vector3& next = corners_C[(i + 1) % 3];
    const bool seen = p.z() >= kNearestDepth_m;
    if (seen) extend(p);
    if (seen == (next.z() >= kNearestDepth_m)) continue;
    // The edge crosses the nearest depth.
    Vector3 crossing = p + (kNearestDepth_m - p.z()) / (next.z() - p.z()) * (next - p);
    crossing.z() = kNearestDepth_m;
    extend(crossing);
  }
  if (pixels.isEmpty()) return {};
  constexpr double kRounding_px = 1e-6;
  return {.u_begin = ClampedPixel(std::ceil(pixels.min().x() - kRounding_px), camera.width),
          .u_end = ClampedPixel(std::floor(pixels.max().x() + kRounding_px) + 1, camera.width),
          .v_begin = ClampedPixel(std::ceil(pixels.min().y() - kRounding_px), camera.height),
          .v_end = ClampedPixel(std::floor(pixels.max().y() + kRounding_px) + 1, camera.height)};
}

void DrawTriangles(const PlacedPart& part, const TriangleMesh& mesh, const PinholeCamera& camera,
                   RangeImage& image, CoveredPixels& covered) {
  std::vector<Vector3> vertices_C;
  vertices_C.reserve(mesh.vertices.size());
  for (const Vector3& vertex : mesh.vertices) vertices_C.push_back(part.X_CS * vertex);
  for (const TriangleMesh::Triangle& triangle : mesh.triangles) {
    const ScreenBounds screen = ProjectTriangle(
        {vertices_C[triangle[0]], vertices_C[triangle[1]], vertices_C[triangle[2]]}, camera);
    const Vector3& a = mesh.vertices[triangle[0]];
    const Vector3& b = mesh.vertices[triangle[1]];
    const Vector3& c = mesh.vertices[triangle[2]];
    Draw(
        part, screen, camera, [&](const Ray& ray) { return CastRay(a, b, c, ray); }, image,
        covered);
  }
}

void DrawPart(const PlacedPart& part, const Shape& shape, const PinholeCamera& camera,
              RangeImage& image, CoveredPixels& covered) {
  if (const Mesh* mesh = std::get_if<Mesh>(&shape)) {
    DrawTriangles(part, *mesh->mesh, camera, image, covered);
  } else if (const Convex* convex = std::get_if<Convex>(&shape)) {
    DrawTriangles(part, *convex->hull, camera, image, covered);
  } else {
    Draw(
        part, Project(TightBounds(shape, part.X_CS), camera), camera,
        [&](const Ray& ray) { return CastRay(shape, ray); }, image, covered);
  }
}

void DrawParts(const SimulatedObject& object, std::int32_t index, const Pose& X_CW,
               const PinholeCamera& camera, RangeImage& image, CoveredPixels& covered) {
  for (std::size_t j = 0; j < object.parts.size(); ++j) {
    const Pose X_CS = X_CW * object.X_WO * object.parts[j].X_FS;
    const PlacedPart part{.id = {.object = index, .part = static_cast<std::int32_t>(j)},
                          .X_CS = X_CS,
                          .X_SC = X_CS.inverse()};
    DrawPart(part, object.parts[j].shape, camera, image, covered);
  }
}

}  // namespace

Vector3 RayDirection(const PinholeCamera& camera, double u_px, double v_px) {
  return {(u_px - camera.center_x_px) / camera.focal_px,
          (v_px - camera.center_y_px) / camera.focal_px, 1};
}

RangeImage EmptyImage(const PinholeCamera& camera) {
  RangeImage image{.width = camera.width, .height = camera.height, .pixels = {}};
  image.pixels.resize(static_cast<std::size_t>(camera.width) * camera.height);
  return image;
}

RangeImage Render(const SimulatedScene& scene, const PinholeCamera& camera) {
  RangeImage image = EmptyImage(camera);
  CoveredPixels uncounted(nullptr, image);
  const Pose X_CW = camera.X_WC.inverse();
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    DrawParts(scene.objects[i], static_cast<std::int32_t>(i), X_CW, camera, image, uncounted);
  }
  return image;
}

ImagePainter::ImagePainter(const PinholeCamera& camera, RangeImage& image)
    : camera_(camera), image_(image), covered_by_(image.pixels.size(), -1) {}

Silhouette ImagePainter::Draw(const SimulatedObject& object, std::int32_t index) {
  CoveredPixels covered(&covered_by_, image_);
  DrawParts(object, index, camera_.X_WC.inverse(), camera_, image_, covered);
  return covered.Take();
}

}  // namespace cwm::perception
