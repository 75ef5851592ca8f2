#include "perception/live/seen_surface.h"

#include <algorithm>

namespace cwm::perception {
namespace {

constexpr int kKeyBits = 21;  // per axis: 60 km at 3 cm
constexpr std::int64_t kKeyMask = (std::int64_t{1} << kKeyBits) - 1;

bool IsSurface(PixelClass pixel) {
  return pixel == PixelClass::kConsistent || pixel == PixelClass::kNearer ||
         pixel == PixelClass::kFarther;
}

}  // namespace

std::uint64_t SeenSurface::KeyOf(const Cell& cell) {
  return static_cast<std::uint64_t>((cell.x() & kKeyMask) << (2 * kKeyBits) |
                                    (cell.y() & kKeyMask) << kKeyBits | (cell.z() & kKeyMask));
}

void SeenSurface::Add(const FrameEvidence& frame, std::span<const std::int32_t> blocks) {
  const FrameClasses& classes = *frame.classes;
  const Pinhole& pinhole = frame.camera.pinhole;
  absl::flat_hash_set<std::uint64_t> centers;
  for (const std::int32_t block : blocks) {
    const int u_begin = block % classes.block_columns * kBlock_px;
    const int v_begin = block / classes.block_columns * kBlock_px;
    for (int v = v_begin; v < std::min(classes.height, v_begin + kBlock_px); ++v) {
      for (int u = u_begin; u < std::min(classes.width, u_begin + kBlock_px); ++u) {
        const double depth_m = frame.image->at(u, v);
        const std::size_t i = static_cast<std::size_t>(v) * classes.width + u;
        if (depth_m == 0 || !IsSurface(classes.pixels[i])) continue;
        const Vector3 p_C((u - pinhole.center_u_px) / pinhole.focal_u_px * depth_m,
                          (v - pinhole.center_v_px) / pinhole.focal_v_px * depth_m, depth_m);
        const Cell center = CellOf(frame.X_WC * p_C);
        if (!centers.insert(KeyOf(center)).second || cells_.size() >= kMaxCells) continue;
        for (int k = 0; k < 27; ++k) {
          cells_.insert(KeyOf(center + Cell(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1)));
        }
      }
    }
  }
}

}  // namespace cwm::perception
