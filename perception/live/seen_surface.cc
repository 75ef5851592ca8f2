#include "perception/live/seen_surface.h"

#include <algorithm>

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
    const int u_begin = block % classes.block_columns * kBlock_px;
    const int v_begin = block / classes.block_columns * kBlock_px;
    for (int v = v_begin; v < std::min(classes.height, v_begin + kBlock_px); ++v) {
      for (int u = u_begin; u < std::min(classes.width, u_begin + kBlock_px); ++u) {
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
