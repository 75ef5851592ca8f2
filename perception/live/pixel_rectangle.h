// Rectangles of pixels.
#pragma once

#include <algorithm>
#include <cstdint>

namespace cwm::perception {

// The pixels [u_begin, u_end) x [v_begin, v_end).
struct PixelRectangle {
  int u_begin = 0, v_begin = 0, u_end = 0, v_end = 0;

  bool empty() const { return u_begin >= u_end || v_begin >= v_end; }
  std::int64_t area() const {
    return empty() ? 0 : static_cast<std::int64_t>(u_end - u_begin) * (v_end - v_begin);
  }
  friend bool operator==(const PixelRectangle&, const PixelRectangle&) = default;
};

inline PixelRectangle Intersection(const PixelRectangle& a, const PixelRectangle& b) {
  return {.u_begin = std::max(a.u_begin, b.u_begin),
          .v_begin = std::max(a.v_begin, b.v_begin),
          .u_end = std::min(a.u_end, b.u_end),
          .v_end = std::min(a.v_end, b.v_end)};
}

// The smallest rectangle that holds both; an empty one adds nothing.
inline PixelRectangle Hull(const PixelRectangle& a, const PixelRectangle& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return {.u_begin = std::min(a.u_begin, b.u_begin),
          .v_begin = std::min(a.v_begin, b.v_begin),
          .u_end = std::max(a.u_end, b.u_end),
          .v_end = std::max(a.v_end, b.v_end)};
}

// The rectangle with `margin_px` more pixels on each side, within an image.
inline PixelRectangle Grown(const PixelRectangle& a, int margin_px, int width, int height) {
  return Intersection({.u_begin = a.u_begin - margin_px,
                       .v_begin = a.v_begin - margin_px,
                       .u_end = a.u_end + margin_px,
                       .v_end = a.v_end + margin_px},
                      {.u_begin = 0, .v_begin = 0, .u_end = width, .v_end = height});
}

}  // namespace cwm::perception
