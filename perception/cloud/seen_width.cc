#include "perception/cloud/seen_width.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "perception/cloud/quantile.h"
#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

// derived: a disc as wide as a cell, which is about as wide as the thinnest handles.
constexpr double kAround_m = kFootprintCell_m / 2;
// measured: a disc is full with this share of the points that its density predicts. Drop-outs and
// ragged edges make holes; at a straight border half a disc holds 0.5.
constexpr double kFullDisc = 0.85;
// chosen: discs evenly spread over the points. More discs take more time and change widths by less
// than a pixel.
constexpr std::size_t kMaxDiscs = 200;

// Positions on the plane through the middle of the points across the ray to it, in metres.
std::vector<Vector2> PlacesAcross(std::span<const Eigen::Vector3f> points,
                                  const Vector3& viewpoint) {
  Vector3 middle = Vector3::Zero();
  for (const Eigen::Vector3f& p : points) middle += p.cast<double>();
  const Vector3 ray = middle / static_cast<double>(points.size()) - viewpoint;
  const Matrix3 R = BasisFromZ(ray.norm() > 0 ? Vector3(ray.normalized()) : Vector3::UnitZ());
  std::vector<Vector2> places;
  for (const Eigen::Vector3f& p : points) {
    const Vector3 x = R.transpose() * (p.cast<double>() - viewpoint);
    places.push_back(ray.norm() / x.z() * x.head<2>());
  }
  return places;
}

std::size_t Stride(const std::vector<Vector2>& places) { return 1 + places.size() / kMaxDiscs; }

// The distances of all places from one of them.
void AwayFrom(const std::vector<Vector2>& places, std::size_t k, std::vector<double>& away_m) {
  away_m.resize(places.size());
  std::transform(places.begin(), places.end(), away_m.begin(),
                 [&](const Vector2& place) { return (place - places[k]).norm(); });
}

double CountWithin(const std::vector<double>& away_m, double radius_m) {
  return static_cast<double>(
      std::count_if(away_m.begin(), away_m.end(), [&](double away) { return away <= radius_m; }));
}

double Density_per_m2(const std::vector<Vector2>& places) {
  std::vector<double> away_m, around;
  for (std::size_t k = 0; k < places.size(); k += Stride(places)) {
    AwayFrom(places, k, away_m);
    around.push_back(CountWithin(away_m, kAround_m));
  }
  return Quantile(std::move(around), kFullCell) / (std::numbers::pi * kAround_m * kAround_m);
}

bool IsFull(double count, double radius_m, double per_m2) {
  return count >= kFullDisc * per_m2 * std::numbers::pi * radius_m * radius_m;
}

}  // namespace

double SeenPitch_m(std::span<const Eigen::Vector3f> points, const Vector3& viewpoint) {
  if (points.empty()) return 0;
  std::map<std::pair<long, long>, double> count_of_cell;
  for (const Vector2& x : PlacesAcross(points, viewpoint)) {
    ++count_of_cell[{std::lround(x.x() / kFootprintCell_m), std::lround(x.y() / kFootprintCell_m)}];
  }
  std::vector<double> counts;
  for (const auto& [at, count] : count_of_cell) counts.push_back(count);
  return kFootprintCell_m / std::sqrt(Quantile(std::move(counts), kFullCell));
}

double SeenWidth_m(std::span<const Eigen::Vector3f> points, const Vector3& viewpoint) {
  if (points.empty()) return 0;
  const std::vector<Vector2> places = PlacesAcross(points, viewpoint);
  const double per_m2 = Density_per_m2(places);
  double widest_m = 0;
  std::vector<double> away_m;
  for (std::size_t k = 0; k < places.size(); k += Stride(places)) {
    AwayFrom(places, k, away_m);
    // Only discs matter that are wider than the widest so far and that all places together could
    // fill.
    const auto wide = std::partition(away_m.begin(), away_m.end(), [&](double away) {
      return IsFull(static_cast<double>(places.size()), away, per_m2);
    });
    const auto wider =
        std::partition(away_m.begin(), wide, [&](double away) { return 2 * away <= widest_m; });
    std::sort(wider, wide);
    for (auto disc = wide; disc != wider;) {
      const std::ptrdiff_t within = --disc - away_m.begin();
      if (within < kMinPointsPerCell) break;
      if (!IsFull(static_cast<double>(within), *disc, per_m2)) continue;
      widest_m = 2 * *disc;
      break;
    }
  }
  return widest_m;
}

std::vector<char> MarkWideParts(std::span<const Eigen::Vector3f> points, const Vector3& viewpoint,
                                double diameter_m, double beside_m) {
  std::vector<char> as_wide(points.size(), 0);
  if (points.empty()) return as_wide;
  const std::vector<Vector2> places = PlacesAcross(points, viewpoint);
  const double per_m2 = Density_per_m2(places), radius_m = 0.5 * diameter_m;
  std::vector<double> away_m;
  for (std::size_t k = 0; k < places.size(); k += Stride(places)) {
    AwayFrom(places, k, away_m);
    if (!IsFull(CountWithin(away_m, radius_m), radius_m, per_m2)) continue;
    for (std::size_t i = 0; i < places.size(); ++i) as_wide[i] |= away_m[i] <= radius_m + beside_m;
  }
  return as_wide;
}

}  // namespace cwm::perception
