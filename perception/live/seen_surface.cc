#include "perception/live/seen_surface.h"

#include "perception/live/pixel_rays.h"

namespace cwm::perception {
namespace {

bool IsSurface(PixelClass pixel) {
  return pixel == PixelClass::kConsistent || pixel == PixelClass::kNearer ||
         pixel == PixelClass::kFarther;
}

}  // namespace

void SeenSurface::Add(const FrameEvidence& frame, std::span<const std::int32_t> blocks,
                      const ExpectedGates& gates) {
  const FrameClasses& classes = *frame.classes;
  const PixelRays rays(frame.camera, frame.X_WC);
  absl::flat_hash_set<std::uint64_t> centers;
  for (const std::int32_t block : blocks) {
    const PixelRectangle pixels = classes.PixelsOf(block);
    for (int v = pixels.v_begin; v < pixels.v_end; ++v) {
      for (int u = pixels.u_begin; u < pixels.u_end; ++u) {
        const float depth_m = frame.image->at(u, v);
        const std::size_t i = static_cast<std::size_t>(v) * classes.width + u;
        if (depth_m == 0 || !IsSurface(classes.pixels[i])) continue;
        if (depth_m >= gates.low_m()[i] && depth_m <= gates.high_m()[i]) continue;
        const WorldCell center =
            CellOf(frame.X_WC.translation() + rays.Point(u, v, depth_m).cast<double>());
        if (!centers.insert(KeyOf(center)).second || cells_.size() >= kMaxCells) continue;
        for (int k = 0; k < 27; ++k) {
          cells_.insert(KeyOf(center + WorldCell(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1)));
        }
      }
    }
  }
}

}  // namespace cwm::perception
