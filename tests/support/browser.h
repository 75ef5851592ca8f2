// A headless Chromium that opens pages as a user would.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/process.h"

namespace cwm::testing {

enum class ColorScheme { kLight, kDark };

struct Window {
  int width_px = 1440;
  int height_px = 1200;
  ColorScheme scheme = ColorScheme::kLight;
};

struct Pixel {
  std::uint8_t r = 0, g = 0, b = 0;
  friend auto operator<=>(const Pixel&, const Pixel&) = default;
};

// Pixels row by row, from the top.
struct Picture {
  int width = 0, height = 0;
  std::vector<Pixel> pixels;

  const Pixel& at(int x, int y) const {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
};

// True if a Chromium is on the PATH; ./dev setup test installs it.
bool HaveBrowser();

// The document after its scripts have run, as HTML. Fails the test if the browser fails.
std::string DocumentOf(const std::string& page, const Window& window,
                       const ScratchDirectory& scratch);

// The content of the window, one pixel per CSS pixel. Fails the test and returns an empty picture
// if the browser fails.
Picture ScreenshotOf(const std::string& page, const Window& window,
                     const ScratchDirectory& scratch);

}  // namespace cwm::testing
