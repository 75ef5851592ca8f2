// The depths that the known bodies explain, per pixel.
#pragma once

#include <vector>

#include "perception/live/depth_noise.h"
#include "perception/live/pixel_rectangle.h"

namespace cwm::perception {

// A pixel shows a known surface if its depth is within [low_m, high_m]: the nearest and the
// farthest surface that is expected within some pixels, with the tolerance of the noise, since a
// pixel beside an edge may show either side, or a mixture. Both are infinite where nothing is
// expected, and high_m also beside such pixels: nothing is too far there.
class ExpectedGates {
 public:
  ExpectedGates(int width, int height);

  // chosen: matching windows blur edges by two pixels. The pose of a moving sensor has an error of
  // some tenths of a degree, which is a pixel or more.
  static constexpr int kStillRadius_px = 2;
  static constexpr int kMinMovingRadius_px = 3;
  static constexpr int kMaxMovingRadius_px = 6;
  // The radius for a moving sensor, with the error of its pose in pixels, one standard deviation.
  static int MovingRadius_px(double sigma_px);

  // Computes the pixels whose neighbourhood contains changed ones. The expected depths are
  // row-major, infinite where nothing is expected.
  void Refresh(const PixelRectangle& changed, const std::vector<float>& expected_m,
               const DepthNoise& noise, bool is_moving, int radius_px = kStillRadius_px);

  const std::vector<float>& low_m() const { return low_m_; }
  const std::vector<float>& high_m() const { return high_m_; }

 private:
  template <class Join>
  void JoinAround(const PixelRectangle& pixels, int radius, const float* from, float neutral,
                  const Join& join, float* to);

  int width_;
  int height_;
  std::vector<float> low_m_, high_m_;
  std::vector<float> rows_, lines_;  // used again from call to call
};

}  // namespace cwm::perception
