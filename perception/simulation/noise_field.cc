#include "perception/simulation/noise_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace cwm::perception {
namespace {

// Filters `count` values that lie `stride` apart: x_i = rho x_{i-1} + sqrt(1 - rho^2) e_i, which
// leaves the variance at 1.
void Autoregress(float* values, int count, std::ptrdiff_t stride, float rho) {
  const float innovation = std::sqrt(1 - rho * rho);
  for (int i = 1; i < count; ++i) {
    values[i * stride] = rho * values[(i - 1) * stride] + innovation * values[i * stride];
  }
}

struct PlaneWave {
  double k_u = 0;  // radians per pixel
  double k_v = 0;
  double phase_rad = 0;
};

constexpr int kWaveCount = 24;    // enough for the sum to be close to normal
constexpr int kWarpCell_px = 16;  // the warp is smooth: linear between nodes this far apart

using Waves = std::array<PlaneWave, kWaveCount>;

Waves DrawWaves(double wavelength_px, RandomDraws& draws) {
  Waves waves;
  for (PlaneWave& wave : waves) {
    const double k = 2 * std::numbers::pi / (wavelength_px * draws.Uniform(1, 3));
    const double direction_rad = draws.Uniform(0, 2 * std::numbers::pi);
    wave = {.k_u = k * std::cos(direction_rad),
            .k_v = k * std::sin(direction_rad),
            .phase_rad = draws.Uniform(0, 2 * std::numbers::pi)};
  }
  return waves;
}

float SumOf(const Waves& waves, double u, double v) {
  double sum = 0;
  for (const PlaneWave& wave : waves) {
    sum += std::cos(wave.k_u * u + wave.k_v * v + wave.phase_rad);
  }
  return static_cast<float>(sum * std::sqrt(2.0 / kWaveCount));  // a cosine has variance 1/2
}

}  // namespace

NoiseField ExponentialField(int width, int height, double row_px, double column_px,
                            RandomDraws& draws) {
  NoiseField field{.width = width, .height = height, .values = {}};
  field.values.resize(static_cast<std::size_t>(width) * height);
  for (float& value : field.values) value = static_cast<float>(draws.Normal());
  const float row_rho = static_cast<float>(std::exp(-1 / row_px));
  const float column_rho = static_cast<float>(std::exp(-1 / column_px));
  for (int v = 0; v < height; ++v) {
    Autoregress(&field.values[static_cast<std::size_t>(v) * width], width, 1, row_rho);
  }
  for (int u = 0; u < width; ++u) Autoregress(&field.values[u], height, width, column_rho);
  return field;
}

NoiseField WarpField(int width, int height, double wavelength_px, RandomDraws& draws) {
  const Waves waves = DrawWaves(wavelength_px, draws);
  const int node_columns = width / kWarpCell_px + 2;
  const int node_rows = height / kWarpCell_px + 2;
  std::vector<float> nodes;
  for (int row = 0; row < node_rows; ++row) {
    for (int column = 0; column < node_columns; ++column) {
      nodes.push_back(SumOf(waves, column * kWarpCell_px, row * kWarpCell_px));
    }
  }
  NoiseField field{.width = width, .height = height, .values = {}};
  for (int v = 0; v < height; ++v) {
    const float along_v = static_cast<float>(v % kWarpCell_px) / kWarpCell_px;
    for (int u = 0; u < width; ++u) {
      const float along_u = static_cast<float>(u % kWarpCell_px) / kWarpCell_px;
      const float* node = &nodes[v / kWarpCell_px * node_columns + u / kWarpCell_px];
      const float top = std::lerp(node[0], node[1], along_u);
      const float bottom = std::lerp(node[node_columns], node[node_columns + 1], along_u);
      field.values.push_back(std::lerp(top, bottom, along_v));
    }
  }
  return field;
}

}  // namespace cwm::perception
