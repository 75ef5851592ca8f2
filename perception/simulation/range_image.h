// The image of an ideal camera: the first surface along the ray of every pixel.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/simulation/simulated_scene.h"

namespace cwm::perception {

struct Sighting {
  double depth_m = 0;                                  // along the optical axis
  Eigen::Vector3f normal_C = Eigen::Vector3f::Zero();  // unit, towards the camera
  std::int32_t object = -1;                            // -1: nothing within range
  std::int32_t part = -1;

  bool seen() const { return object >= 0; }
};

// Row-major, with the camera's width and height.
struct RangeImage {
  int width = 0;
  int height = 0;
  std::vector<Sighting> pixels;

  bool contains(int u, int v) const { return u >= 0 && u < width && v >= 0 && v < height; }
  const Sighting& at(int u, int v) const { return pixels[static_cast<std::size_t>(v) * width + u]; }
};

// Surfaces farther away give no return: the range of the modelled sensors except lasers.
inline constexpr double kMaxCameraDepth_m = 10;

// The direction of the ray through a pixel in C, with depth 1.
Vector3 RayDirection(const PinholeCamera& camera, double u_px, double v_px);

// Renders with one depth test per pixel within the screen bounds of each part (of each triangle of
// a mesh).
RangeImage Render(const SimulatedScene& scene, const PinholeCamera& camera);

// An image without any surface.
RangeImage EmptyImage(const PinholeCamera& camera);

// The pixels that an object covers, or would cover if it were alone.
struct Silhouette {
  std::int64_t pixel_count = 0;
  int row_begin = 0;  // no row outside [row_begin, row_end) has any
  int row_end = 0;
};

// Draws objects over an image one after the other; where surfaces hide each other, the image keeps
// the nearest. The image must outlive the painter.
class ImagePainter {
 public:
  ImagePainter(const PinholeCamera& camera, RangeImage& image);

  // `index` becomes Sighting::object, and differs from those of earlier calls.
  Silhouette Draw(const SimulatedObject& object, std::int32_t index);

 private:
  PinholeCamera camera_;
  RangeImage& image_;
  std::vector<std::int32_t> covered_by_;  // the last object that covers each pixel
};

}  // namespace cwm::perception
