#include "clients/report/packed_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace cwm::report {
namespace {

using Point = std::array<double, 3>;

// chosen: a tenth of the noise of the best supported sensor at its nearest range.
constexpr double kMinStep_m = 1e-4;
constexpr double kMaxSteps = std::numeric_limits<std::uint16_t>::max();

std::map<std::uint32_t, std::vector<Point>> MeasuredByLabel(const LabelledCloud& scan) {
  const formats::CloudFile& cloud = scan.cloud;
  const formats::CloudField* const fields[] = {cloud.Find("x"), cloud.Find("y"), cloud.Find("z")};
  std::map<std::uint32_t, std::vector<Point>> measured;
  for (std::size_t i = 0; i < scan.labels.size(); ++i) {
    const char* bytes = cloud.bytes.data() + i * cloud.point_step;
    Point p;
    for (std::size_t k = 0; k < 3; ++k) {
      p[k] = scan.scale * formats::ToDouble(bytes + fields[k]->offset, fields[k]->type);
    }
    // The same rule as the server's: a point that is not finite or all zeros is no return.
    const bool is_finite = std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
    if (is_finite && (p[0] != 0 || p[1] != 0 || p[2] != 0)) {
      measured[scan.labels[i]].push_back(p);
    }
  }
  return measured;
}

// Sets the corner and the step of the grid that contains all points.
void LayGrid(const std::map<std::uint32_t, std::vector<Point>>& measured, PackedPoints& packed) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Point low = {kInfinity, kInfinity, kInfinity};
  Point high = {-kInfinity, -kInfinity, -kInfinity};
  for (const auto& [label, points] : measured) {
    for (const Point& p : points) {
      for (std::size_t k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], p[k]);
        high[k] = std::max(high[k], p[k]);
      }
    }
  }
  packed.origin_m = low;
  packed.step_m = kMinStep_m;
  for (std::size_t k = 0; k < 3; ++k) {
    packed.step_m = std::max(packed.step_m, (high[k] - low[k]) / kMaxSteps);
  }
}

void Append(const Point& p, PackedPoints& packed) {
  for (std::size_t k = 0; k < 3; ++k) {
    const double steps = std::round((p[k] - packed.origin_m[k]) / packed.step_m);
    const auto step = static_cast<std::uint16_t>(std::clamp(steps, 0.0, kMaxSteps));
    packed.grid.push_back(static_cast<char>(step & 0xff));
    packed.grid.push_back(static_cast<char>(step >> 8));
  }
}

}  // namespace

PackedPoints PackPoints(const LabelledCloud& scan, std::int64_t max_points) {
  const auto measured = MeasuredByLabel(scan);
  PackedPoints packed;
  if (measured.empty()) return packed;
  LayGrid(measured, packed);
  for (const auto& [label, points] : measured) {
    packed.measured += static_cast<std::int64_t>(points.size());
  }
  packed.every = std::max<std::int64_t>(1, (packed.measured + max_points - 1) / max_points);
  for (const auto& [label, points] : measured) {
    PointRun run{.label = label};
    for (std::size_t i = 0; i < points.size(); i += static_cast<std::size_t>(packed.every)) {
      Append(points[i], packed);
      ++run.count;
    }
    packed.runs.push_back(run);
  }
  return packed;
}

}  // namespace cwm::report
