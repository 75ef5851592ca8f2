// The classes of a frame's pixels against what is known.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "perception/live/pixel_rectangle.h"

namespace cwm::perception {

enum class PixelClass : std::uint8_t {
  kConsistent = 1,  // as the known world, or what was seen before at rest, is expected to look
  kNearer,          // before what is known, or where nothing is known
  kFarther,         // the ray passed through what is known
  kMissing,         // no return
  kRobot,
  kCarried,  // what a robot carries
  kMixed,    // at the outline of a robot: neither geometry nor free space
  kHidden    // a known surface behind the robot, if the pixel shows neither
};
inline constexpr std::size_t kPixelClasses = 9;  // indexed by the enumerators; 0 is not used

using PixelCounts = std::array<std::int64_t, kPixelClasses>;

// chosen: the edge of a block of pixels. Blocks are hot or not as a whole.
inline constexpr int kBlock_px = 8;

struct FrameClasses {
  int width = 0;
  int height = 0;
  std::vector<PixelClass> pixels;  // row-major
  PixelCounts counts = {};

  // Blocks of kBlock_px x kBlock_px pixels, row-major; those at the right and lower edge may be
  // smaller. 1: differs from what is known in more pixels than noise explains.
  int block_columns = 0;
  int block_rows = 0;
  std::vector<std::uint8_t> hot_blocks;

  PixelRectangle PixelsOf(std::int32_t block) const {
    const int u = block % block_columns * kBlock_px;
    const int v = block / block_columns * kBlock_px;
    return {.u_begin = u,
            .v_begin = v,
            .u_end = std::min(width, u + kBlock_px),
            .v_end = std::min(height, v + kBlock_px)};
  }
  std::int32_t BlockOf(std::size_t pixel) const {
    const int u = static_cast<int>(pixel) % width;
    const int v = static_cast<int>(pixel) / width;
    return v / kBlock_px * block_columns + u / kBlock_px;
  }
};

}  // namespace cwm::perception
