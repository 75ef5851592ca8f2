// One number per pixel of an image, laid out for loops over several pixels at once.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include "perception/cloud/measured_points.h"
#include "perception/cloud/parallel_for.h"

namespace cwm::perception {

// The least radius of a normal's neighbourhood, in pixels.
// chosen: 5 x 5 pixels, because in an image with little noise neighbours are farther apart than the
// noise requires.
inline constexpr float kMinWindow_px = 2;
// chosen: the largest radius; a larger one only occurs with the sensor on the surface.
inline constexpr float kMaxWindow_px = 64;

// The largest number of pixels in a vector of Highway's: wider registers are not filled.
inline constexpr int kMaxLanes = 8;  // cited: floats of an AVX register, 32 bytes

// One value per pixel, row-major, with a margin on both sides of each row. Margins and pixels
// without a point are NaN, so that comparisons need no test for either.
class ImagePlane {
 public:
  // derived: a window, and a block of lanes on either side of it.
  static constexpr int kMargin = static_cast<int>(kMaxWindow_px) + kMaxLanes * 2;

  ImagePlane() = default;
  ImagePlane(int width, int height)
      : stride_(static_cast<std::size_t>(width) + std::size_t{2} * kMargin),
        values_(stride_ * static_cast<std::size_t>(height),
                std::numeric_limits<float>::quiet_NaN()) {}

  // The pixel in column 0.
  float* Row(int row) { return values_.data() + static_cast<std::size_t>(row) * stride_ + kMargin; }
  const float* Row(int row) const { return const_cast<ImagePlane*>(this)->Row(row); }

 private:
  std::size_t stride_ = 0;
  std::vector<float> values_;
};

// Calls set(index of the point, row, column) for every point of an organised cloud, rows in
// parallel.
template <class Set>
void ForEachPixel(const MeasuredPoints& measured, const Work& work, const Set& set) {
  using namespace std::chrono_literals;
  ParallelFor(static_cast<std::size_t>(measured.height),
              ItemsPerChunk(10ns * std::max(measured.width, 1)), work,
              [&](std::size_t begin, std::size_t end) {
                for (std::size_t row = begin; row < end; ++row) {
                  const std::int32_t* line =
                      measured.image.data() + row * static_cast<std::size_t>(measured.width);
                  for (int column = 0; column < measured.width; ++column) {
                    if (line[column] < 0) continue;
                    set(static_cast<std::size_t>(line[column]), static_cast<int>(row), column);
                  }
                }
              });
}

}  // namespace cwm::perception
