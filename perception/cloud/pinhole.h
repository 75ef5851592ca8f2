// The pinhole camera model.
#pragma once

namespace cwm::perception {

// u = focal_u x / z + center_u and v = focal_v y / z + center_v for z > 0, in pixels, in the
// optical frame (z forward, x right, y down). The centre of the first pixel is (0, 0).
struct Pinhole {
  double focal_u_px = 0;
  double focal_v_px = 0;
  double center_u_px = 0;
  double center_v_px = 0;

  friend bool operator==(const Pinhole&, const Pinhole&) = default;
};

}  // namespace cwm::perception
