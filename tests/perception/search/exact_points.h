// Points of known surfaces, without noise and evenly spread, for the tests of the search and of
// fits.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "perception/cloud/oriented_points.h"
#include "perception/search/any_model.h"
#include "perception/search/model_points.h"

namespace cwm::perception {

struct ExactPoints {
  static constexpr double kPitch_m = 0.003;  // between neighbours
  // The claimed accuracy: gates are 3 mm and 15 degrees wide.
  static constexpr float kSigma_m = 0.001f, kNormalSigma_rad = 0.02f;

  OrientedPoints seen;

  void Add(const Vector3& p, const Vector3& n) {
    seen.points.push_back(p.cast<float>());
    seen.normals.push_back(n.cast<float>());
    seen.sigma_m.push_back(kSigma_m);
    seen.normal_sigma_rad.push_back(kNormalSigma_rad);
    seen.cloud_index.push_back(static_cast<std::uint32_t>(seen.cloud_index.size()));
  }

  // Adds `first` by `second` points along the two directions across the normal (BasisFromZ).
  void AddGrid(const Vector3& middle, const Vector3& normal, int first, int second) {
    const Matrix3 basis = BasisFromZ(normal);
    for (int i = 0; i < first; ++i) {
      for (int k = 0; k < second; ++k) {
        Add(middle + kPitch_m * ((i - 0.5 * (first - 1)) * basis.col(0) +
                                 (k - 0.5 * (second - 1)) * basis.col(1)),
            normal);
      }
    }
  }

  // Adds a level disc that faces up.
  void AddDisc(const Vector3& middle, double radius_m, int count) {
    for (int k = 0; k < count; ++k) {
      const double away_m = radius_m * std::sqrt((k + 0.5) / count);
      Add(middle + away_m * Level(k * kGolden_rad), Vector3::UnitZ());
    }
  }

  // Adds the cap of the sphere around its top, up to `half_rad` from it.
  void AddCap(const SphereModel& sphere, double half_rad, int count) {
    for (int k = 0; k < count; ++k) {
      const double rise = 1 - (k + 0.5) / count * (1 - std::cos(half_rad));
      const Vector3 outward =
          std::sqrt(1 - rise * rise) * Level(k * kGolden_rad) + rise * Vector3::UnitZ();
      Add(sphere.center + sphere.radius_m * outward, outward);
    }
  }

  // Adds rows of the wall from half of its height below the reference point to half above it, each
  // an arc around the direction +x. The axis is z.
  void AddWall(const ConeModel& wall, int rows, double arc_rad) {
    const int columns = ColumnsOf(wall, arc_rad);
    for (int i = 0; i < rows; ++i) {
      const double height_m = kPitch_m * (i - 0.5 * (rows - 1));
      for (int k = 0; k < columns; ++k) {
        const double turn_rad = arc_rad * (k / (columns - 1.0) - 0.5);
        const Vector3 p =
            wall.point + height_m * Vector3::UnitZ() + wall.RadiusAt_m(height_m) * Level(turn_rad);
        Add(p, wall.FacingSign() * wall.Normal(p));
      }
    }
  }
  static int ColumnsOf(const ConeModel& wall, double arc_rad) {
    return static_cast<int>(std::lround(wall.radius_m * arc_rad / kPitch_m)) + 1;
  }

  // The search input made of all points.
  ModelPoints Model() const { return SubsampleForSearch(seen, seen.size()); }

 private:
  // The golden angle: points on rings of equal area that are turned by it from one to the next are
  // spread evenly.
  static constexpr double kGolden_rad = std::numbers::pi * 2 * (2 - std::numbers::phi);

  static Vector3 Level(double turn_rad) { return {std::cos(turn_rad), std::sin(turn_rad), 0}; }
};

}  // namespace cwm::perception
