#include "perception/simulation/noise_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>

#include "perception/cloud/split_mix.h"

namespace cwm::perception {
namespace {

// Values that lie `stride` apart become x_i = rho x_{i-1} + sqrt(1 - rho^2) e_i, which leaves the
// variance at 1: values[i] is such an x_i for i from `stride` on, in the order of the memory.
void Autoregress(float* values, std::ptrdiff_t count, std::ptrdiff_t stride, float rho) {
  const float innovation = std::sqrt(1 - rho * rho);
  for (std::ptrdiff_t i = stride; i < count; ++i) {
    values[i] = rho * values[i - stride] + innovation * values[i];
  }
}

// derived: quantiles of the normal distribution in the middle of 4096 equal steps of probability;
// their variance is within 0.1 % of 1, their largest is 3.7.
constexpr int kQuantileBits = 12;
using QuantileTable = std::array<float, std::size_t{1} << kQuantileBits>;

// Solves Phi(x) = p by bisection.
double NormalQuantile(double p) {
  double low = -8;
  double high = 8;
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (low + high);
    (0.5 * std::erfc(-middle / std::numbers::sqrt2) < p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

QuantileTable MakeQuantiles() {
  QuantileTable table;
  for (std::size_t i = 0; i < table.size(); ++i) {
    table[i] = static_cast<float>(
        NormalQuantile((static_cast<double>(i) + 0.5) / static_cast<double>(table.size())));
  }
  return table;
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
  Correlate(row_px, column_px, field);
  return field;
}

void Correlate(double row_px, double column_px, NoiseField& field) {
  const float row_rho = static_cast<float>(std::exp(-1 / row_px));
  const float column_rho = static_cast<float>(std::exp(-1 / column_px));
  for (int v = 0; v < field.height; ++v) {
    Autoregress(&field.values[static_cast<std::size_t>(v) * field.width], field.width, 1, row_rho);
  }
  Autoregress(field.values.data(), std::ssize(field.values), field.width, column_rho);
}

NoiseField QuickField(int width, int height, double correlation_px, std::uint64_t seed) {
  static const QuantileTable quantiles = MakeQuantiles();
  NoiseField field{.width = width, .height = height, .values = {}};
  field.values.resize(static_cast<std::size_t>(width) * height);
  constexpr std::size_t kPerDraw = 64 / kQuantileBits;
  constexpr std::uint64_t kMask = (std::uint64_t{1} << kQuantileBits) - 1;
  for (std::size_t i = 0; i < field.values.size(); i += kPerDraw) {
    std::uint64_t bits = NextRandomBits(seed);
    const std::size_t end = std::min(i + kPerDraw, field.values.size());
    for (std::size_t j = i; j < end; ++j, bits >>= kQuantileBits) {
      field.values[j] = quantiles[bits & kMask];
    }
  }
  Correlate(correlation_px, correlation_px, field);
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
