// The pixels of a frame that show robots and what they carry.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/live/frame_classes.h"

namespace cwm::perception {

// Per pixel: kRobot, kCarried, kMixed, kHidden (the expected surface is behind a robot), or 0 if no
// robot concerns the pixel. Empty: no robot is in view.
struct RobotMask {
  std::vector<std::uint8_t> pixels;  // row-major, PixelClass or 0
  // A rectangle that holds all other pixels than 0; half open.
  int u_begin = 0, v_begin = 0, u_end = 0, v_end = 0;

  bool empty() const { return pixels.empty(); }
};

}  // namespace cwm::perception
