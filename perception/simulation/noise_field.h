// Images of correlated noise, like that of range sensors.
#pragma once

#include <vector>

#include "perception/simulation/random_draws.h"

namespace cwm::perception {

// Row-major image of draws of mean 0 and standard deviation 1.
struct NoiseField {
  int width = 0;
  int height = 0;
  std::vector<float> values;

  float at(int u, int v) const { return values[static_cast<std::size_t>(v) * width + u]; }
};

// Correlation exp(-|du| / row_px) * exp(-|dv| / column_px), exact at any distance: a first-order
// autoregressive filter along each axis, started in its stationary state.
NoiseField ExponentialField(int width, int height, double row_px, double column_px,
                            RandomDraws& draws);

// A slow warp: a sum of plane waves with wavelengths of one to three times `wavelength_px`, so that
// points nearer than a quarter of it have the same error.
NoiseField WarpField(int width, int height, double wavelength_px, RandomDraws& draws);

}  // namespace cwm::perception
