#include "perception/live/region_cloud.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "perception/track/model_surface.h"

namespace cwm::perception {
namespace {

// chosen: the interpreter sees so much of the support around a region, at least. A support is found
// by a few hundred points, and its height by those next to the object.
constexpr int kMinContext_px = 48;

bool IsOfWorld(PixelClass pixel) {
  return pixel != PixelClass::kMissing && pixel != PixelClass::kRobot &&
         pixel != PixelClass::kCarried && pixel != PixelClass::kMixed &&
         pixel != PixelClass::kHidden;
}

// Tells the points of bodies outside the region: of their supports, or of all others.
class OtherBodies {
 public:
  enum class Which { kSupports, kOthers };
  OtherBodies(const FrameEvidence& frame, std::span<const KnownBody> bodies, Which which)
      : frame_(frame) {
    for (const KnownBody& body : bodies) {
      const bool is_support = body.kind == KnownBody::Kind::kSupport;
      if (is_support != (which == Which::kSupports)) continue;
      others_.push_back({ModelSurface(*body.model, kExplainedWithin_m), body.X_WB.inverse(),
                         TightBounds(*body.model, body.X_WB)});
    }
  }

  bool Explain(const Vector3& p_W, double depth_m) const {
    const double within_m = ExplainedWithin_m(frame_.noise.AxialSigma_m(depth_m));
    return std::ranges::any_of(others_, [&](const Other& other) {
      if (other.bounds_W.isEmpty() || other.bounds_W.exteriorDistance(p_W) > within_m) {
        return false;
      }
      const auto nearest = other.surface.Nearest(other.X_BW * p_W, within_m);
      return nearest && nearest->signed_distance_m <= within_m;
    });
  }

 private:
  struct Other {
    ModelSurface surface;
    Pose X_BW = Pose::Identity();
    Aabb bounds_W;
  };
  const FrameEvidence& frame_;
  std::vector<Other> others_;
};

// Per pixel: 0 outside, 1 context, 2 in a block of the request.
std::vector<std::uint8_t> Windows(const FrameEvidence& frame, const RegionRequest& request) {
  const int width = frame.image->width;
  const int height = frame.image->height;
  std::vector<std::uint8_t> windows(frame.image->depth_m.size(), 0);
  const int columns = frame.classes->block_columns;
  int u_begin = width;
  int v_begin = height;
  int u_end = 0;
  int v_end = 0;
  for (const std::int32_t block : request.blocks) {
    const int u = block % columns * kBlock_px;
    const int v = block / columns * kBlock_px;
    u_begin = std::min(u_begin, u);
    v_begin = std::min(v_begin, v);
    u_end = std::max(u_end, u + kBlock_px);
    v_end = std::max(v_end, v + kBlock_px);
  }
  // As much context on each side as the region is wide.
  const int margin_px = std::max({kMinContext_px, u_end - u_begin, v_end - v_begin});
  const auto fill = [&](int u0, int v0, int u1, int v1, std::uint8_t value) {
    for (int v = std::max(0, v0); v < std::min(height, v1); ++v) {
      for (int u = std::max(0, u0); u < std::min(width, u1); ++u) {
        windows[static_cast<std::size_t>(v) * width + u] = value;
      }
    }
  };
  fill(u_begin - margin_px, v_begin - margin_px, u_end + margin_px, v_end + margin_px, 1);
  for (const std::int32_t block : request.blocks) {
    const int u = block % columns * kBlock_px;
    const int v = block / columns * kBlock_px;
    // Things reach over the border of their hot blocks.
    fill(u - kBlock_px, v - kBlock_px, u + 2 * kBlock_px, v + 2 * kBlock_px, 2);
  }
  return windows;
}

}  // namespace

PointCloud RegionCloud(const FrameEvidence& frame, const RegionRequest& request,
                       std::span<const KnownBody> others) {
  const DepthImage& image = *frame.image;
  PointCloud cloud;
  cloud.width = image.width;
  cloud.height = image.height;
  cloud.points.assign(image.depth_m.size(),
                      Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
  const std::vector<std::uint8_t> windows = request.is_whole_view
                                                ? std::vector<std::uint8_t>(image.depth_m.size(), 2)
                                                : Windows(frame, request);
  if (request.is_whole_view) others = {};
  const OtherBodies supports(frame, others, OtherBodies::Which::kSupports);
  const OtherBodies other_bodies(frame, others, OtherBodies::Which::kOthers);
  const Pinhole& pinhole = frame.camera.pinhole;
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      const std::size_t i = static_cast<std::size_t>(v) * image.width + u;
      const double depth_m = image.depth_m[i];
      if (windows[i] == 0 || depth_m == 0 || !IsOfWorld(frame.classes->pixels[i])) continue;
      const Vector3 p_C((u - pinhole.center_u_px) / pinhole.focal_u_px * depth_m,
                        (v - pinhole.center_v_px) / pinhole.focal_v_px * depth_m, depth_m);
      const bool is_context = windows[i] == 1;
      // What differs beside the region is of another one.
      const bool differs = frame.classes->pixels[i] != PixelClass::kConsistent;
      if (is_context && differs) continue;
      // Of what was known before, a new surface needs only the supports.
      const bool is_new = windows[i] == 2 && frame.classes->pixels[i] == PixelClass::kNearer;
      if (request.is_new_surface && !request.is_whole_view && !is_new &&
          !supports.Explain(frame.X_WC * p_C, depth_m)) {
        continue;
      }
      // A changed pixel is never that of a body that did not change.
      if (!differs && other_bodies.Explain(frame.X_WC * p_C, depth_m)) continue;
      cloud.points[i] = p_C.cast<float>();
    }
  }
  return cloud;
}

}  // namespace cwm::perception
