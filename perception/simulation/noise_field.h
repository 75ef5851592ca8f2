// Images of correlated noise, like that of range sensors.
#pragma once

#include <cstdint>
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

// Gives independent draws the correlation of ExponentialField.
void Correlate(double row_px, double column_px, NoiseField& field);

// An ExponentialField of equal correlation along rows and columns whose draws come from a table of
// 4096 quantiles, a tenth of the time: for noise that is drawn for every frame.
NoiseField QuickField(int width, int height, double correlation_px, std::uint64_t seed);

// A slow warp: a sum of plane waves with wavelengths of one to three times `wavelength_px`, so that
// points nearer than a quarter of it have the same error.
NoiseField WarpField(int width, int height, double wavelength_px, RandomDraws& draws);

}  // namespace cwm::perception
