// Pieces made by hand, in the form that the joining rules take.
#pragma once

#include <cmath>
#include <functional>
#include <utility>

#include "perception/segmentation/piece_summaries.h"

namespace cwm::perception {

// Pieces seen from the origin of the level frame, with 4 mm between points and without noise.
class PiecesByHand {
 public:
  static constexpr double kSpacing_m = 0.004;
  static constexpr float kDirections_rad = 0.006f;  // of the sight map: the nearest are 0.8 m away

  // All of these add a piece and return its number.

  // A piece without points, as a support is.
  std::size_t AddEmpty() { return Append({}); }

  // The upright rectangle at x = `x_m` that faces the sensor, turned about its vertical centre
  // line.
  std::size_t AddFront(double x_m, const Vector2& y_m, const Vector2& z_m, double turn_rad = 0) {
    const double middle_m = y_m.mean();
    const Vector3 normal(-std::cos(turn_rad), std::sin(turn_rad), 0);
    return Add({y_m.y() - y_m.x(), z_m.y() - z_m.x()}, [&](double u, double v) {
      const double y = Between(y_m, u);
      return Point{{x_m + (y - middle_m) * std::tan(turn_rad), y, Between(z_m, v)}, normal};
    });
  }

  // The rectangle at z = `z_m` that faces up.
  std::size_t AddLevel(double z_m, const Vector2& x_m, const Vector2& y_m) {
    return Add({x_m.y() - x_m.x(), y_m.y() - y_m.x()}, [&](double u, double v) {
      return Point{{Between(x_m, u), Between(y_m, v), z_m}, Vector3::UnitZ()};
    });
  }

  // An upright round wall around (1, 0), with angles from the direction to the sensor: its outside
  // if `outward` is 1, its inside if it is -1.
  std::size_t AddWall(double radius_m, const Vector2& angle_rad, const Vector2& z_m,
                      double outward) {
    return Add({radius_m * (angle_rad.y() - angle_rad.x()), z_m.y() - z_m.x()},
               [&](double u, double v) {
                 const double angle = Between(angle_rad, u);
                 const Vector3 away(-std::cos(angle), std::sin(angle), 0);
                 return Point{Vector3(1, 0, Between(z_m, v)) + radius_m * away, outward * away};
               });
  }

  const OrientedPoints& nodes() const { return nodes_; }
  const PieceSummaries& views() const { return views_; }

 private:
  struct Point {
    Vector3 place, normal;
  };

  static double Between(const Vector2& ends, double share) {
    return ends.x() + share * (ends.y() - ends.x());
  }

  std::size_t Append(PieceSummary piece) {
    views_.pieces.push_back(std::move(piece));
    return views_.pieces.size() - 1;
  }

  // Adds points at shares of both lengths.
  std::size_t Add(const Vector2& lengths_m, const std::function<Point(double, double)>& point_at) {
    const auto columns = std::lround(lengths_m.x() / kSpacing_m);
    const auto rows = std::lround(lengths_m.y() / kSpacing_m);
    const auto stride = (columns * rows + long{kMaxSamples} - 1) / long{kMaxSamples};
    PieceSummary piece;
    for (long k = 0; k < columns * rows; ++k) {
      const Point point =
          point_at((static_cast<double>(k / rows) + 0.5) / static_cast<double>(columns),
                   (static_cast<double>(k % rows) + 0.5) / static_cast<double>(rows));
      if (k % stride == 0) piece.sample.push_back(static_cast<std::uint32_t>(nodes_.size()));
      nodes_.points.push_back(point.place.cast<float>());
      nodes_.normals.push_back(point.normal.cast<float>());
      nodes_.sigma_m.push_back(0.0015f);
      piece.bounds.extend(point.place);
      piece.area_m2 += kSpacing_m * kSpacing_m;
      ++piece.node_count;
    }
    piece.low_z_m = piece.bounds.min().z();
    piece.high_z_m = piece.bounds.max().z();
    return Append(std::move(piece));
  }

  OrientedPoints nodes_;
  PieceSummaries views_;
};

}  // namespace cwm::perception
