#include "perception/live/unmodelled_blocks.h"

#include <algorithm>
#include <cstddef>

#include "perception/live/depth_noise.h"
#include "perception/live/expected_gates.h"
#include "perception/live/expected_view.h"

namespace cwm::perception {
namespace {

// chosen: pixels in a block and those around it. Three points of a mover, at one for 2 x 2 pixels.
constexpr int kMinUnmodelled_px = 12;

}  // namespace

std::vector<std::int32_t> UnmodelledBlocks(const FrameEvidence& frame,
                                           std::span<const std::int32_t> blocks,
                                           std::span<const KnownBody> bodies) {
  const DepthCamera& camera = frame.camera;
  const FrameClasses& classes = *frame.classes;
  ExpectedView view(camera);
  view.Update(bodies, frame.X_WC);
  ExpectedGates gates(camera.width, camera.height);
  gates.Refresh({.u_end = camera.width, .v_end = camera.height}, view.depth_m(),
                DepthNoise(camera, frame.noise), /*is_moving=*/false);
  const auto is_unmodelled = [&](std::size_t i) {
    return classes.pixels[i] == PixelClass::kNearer && frame.image->depth_m[i] < gates.low_m()[i];
  };
  std::vector<int> counts(classes.hot_blocks.size());
  for (const std::int32_t block : blocks) {
    const PixelRectangle pixels = classes.PixelsOf(block);
    for (int v = pixels.v_begin; v < pixels.v_end; ++v) {
      for (int u = pixels.u_begin; u < pixels.u_end; ++u) {
        const std::size_t i = static_cast<std::size_t>(v) * camera.width + u;
        counts[static_cast<std::size_t>(block)] += is_unmodelled(i) ? 1 : 0;
      }
    }
  }
  const auto count_around = [&](std::int32_t block) {
    const int column = block % classes.block_columns, row = block / classes.block_columns;
    int count = 0;
    for (int r = std::max(0, row - 1); r < std::min(classes.block_rows, row + 2); ++r) {
      for (int c = std::max(0, column - 1); c < std::min(classes.block_columns, column + 2); ++c) {
        count += counts[static_cast<std::size_t>(r) * classes.block_columns + c];
      }
    }
    return count;
  };
  std::vector<std::int32_t> unmodelled;
  for (const std::int32_t block : blocks) {
    if (counts[static_cast<std::size_t>(block)] == 0) continue;
    if (count_around(block) >= kMinUnmodelled_px) unmodelled.push_back(block);
  }
  return unmodelled;
}

}  // namespace cwm::perception
