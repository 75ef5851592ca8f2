#include "perception/surface/surface_reconstruction.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "collision/geometry/validation.h"

namespace cwm::perception {
namespace {

constexpr double kTolerance_m = 0.010;  // coverage: max(10 mm, 3 sigma), sensor_noise.h
constexpr float kSigma_m = 0.001F;
const Vector3 kViewpoint(0, 0, 1);

OrientedPoints PointsOf(std::vector<Eigen::Vector3f> positions) {
  OrientedPoints points;
  points.points = std::move(positions);
  points.normals.assign(points.points.size(), Eigen::Vector3f::Zero());
  points.sigma_m.assign(points.points.size(), kSigma_m);
  points.normal_sigma_rad.assign(points.points.size(), 0.2F);
  for (std::uint32_t i = 0; i < points.points.size(); ++i) points.cloud_index.push_back(i);
  points.viewpoint = kViewpoint;
  return points;
}

// The cap of a sphere of 8 cm radius around the origin that a sensor above it sees: `count` points,
// displaced along the radius by uniform noise of kSigma_m.
OrientedPoints SpherePatch(int count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1.0p-53; };
  std::vector<Eigen::Vector3f> positions;
  for (int i = 0; i < count; ++i) {
    const double z = 0.5 + 0.5 * uniform();  // polar angles up to 60 degrees
    const double angle = 2 * std::numbers::pi * uniform();
    const double radius_m = 0.08 + kSigma_m * std::sqrt(12.0) * (uniform() - 0.5);
    const double across = std::sqrt(1 - z * z);
    positions.push_back(
        (radius_m * Vector3(across * std::cos(angle), across * std::sin(angle), z)).cast<float>());
  }
  return PointsOf(std::move(positions));
}

// The reference: the distance from the nearest of all triangles by dense sampling of barycentric
// coordinates. An upper bound that is at most one sampling step too large.
constexpr int kOracleSteps = 12;
double DistanceByOracle(const TriangleMesh& mesh, const Vector3& p) {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const auto& [a, b, c] : mesh.triangles) {
    if ((mesh.vertices[a] - p).norm() > nearest_m + 0.05) continue;
    for (int i = 0; i <= kOracleSteps; ++i) {
      for (int j = 0; i + j <= kOracleSteps; ++j) {
        const double u = static_cast<double>(i) / kOracleSteps;
        const double v = static_cast<double>(j) / kOracleSteps;
        const Vector3 q =
            (1 - u - v) * mesh.vertices[a] + u * mesh.vertices[b] + v * mesh.vertices[c];
        nearest_m = std::min(nearest_m, (q - p).norm());
      }
    }
  }
  return nearest_m;
}

struct TriangleQuality {
  double smallest_angle_rad = std::numbers::pi;
  int facing_away = 0;
};

TriangleQuality Inspect(const TriangleMesh& mesh, const Vector3& viewpoint) {
  TriangleQuality quality;
  for (const auto& triangle : mesh.triangles) {
    std::array<Vector3, 3> corner;
    for (int i = 0; i < 3; ++i) corner[i] = mesh.vertices[triangle[i]];
    for (int i = 0; i < 3; ++i) {
      const Vector3 e = (corner[(i + 1) % 3] - corner[i]).normalized();
      const Vector3 f = (corner[(i + 2) % 3] - corner[i]).normalized();
      quality.smallest_angle_rad =
          std::min(quality.smallest_angle_rad, std::acos(std::clamp(e.dot(f), -1.0, 1.0)));
    }
    const Vector3 normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    if (normal.dot(viewpoint - corner[0]) < 0) ++quality.facing_away;
  }
  return quality;
}

// Checks the properties that every surface has, whatever the points.
void ExpectSound(const OrientedPoints& points, const Surface& surface,
                 const SurfaceOptions& options) {
  const auto violation = FindViolation(surface.mesh);
  EXPECT_FALSE(violation) << violation->field << " " << violation->value << " " << violation->rule;
  EXPECT_LE(surface.mesh.triangles.size(), static_cast<std::size_t>(options.max_triangles));
  const TriangleQuality quality = Inspect(surface.mesh, points.viewpoint);
  EXPECT_EQ(quality.facing_away, 0);
  // An altitude of 8 % of the longest edge means angles of at least atan(0.08) = 4.5 degrees.
  EXPECT_GE(quality.smallest_angle_rad, std::atan(0.08) * (1 - 1e-6));
  EXPECT_TRUE(std::is_sorted(surface.explained.begin(), surface.explained.end()));
  EXPECT_EQ(std::adjacent_find(surface.explained.begin(), surface.explained.end()),
            surface.explained.end());
}

TEST(SurfaceReconstruction, CoversEveryPointOfASphereWithinTolerance) {
  const OrientedPoints points = SpherePatch(6000, 1);
  const Surface surface = ReconstructSurface(points, {});
  ExpectSound(points, surface, {});
  EXPECT_EQ(surface.explained.size(), points.size());
  for (std::size_t i = 0; i < points.size(); i += 20) {
    EXPECT_LE(DistanceByOracle(surface.mesh, points.points[i].cast<double>()), kTolerance_m) << i;
  }
}

TEST(SurfaceReconstruction, LiesOnTheSphereThatWasMeasured) {
  const Surface surface = ReconstructSurface(SpherePatch(6000, 2), {});
  double squares = 0;
  double area_m2 = 0;
  for (const Vector3& p : surface.mesh.vertices) squares += std::pow(p.norm() - 0.08, 2);
  for (const auto& [a, b, c] : surface.mesh.triangles) {
    const auto& v = surface.mesh.vertices;
    area_m2 += 0.5 * (v[b] - v[a]).cross(v[c] - v[a]).norm();
  }
  // Vertices are means of several points, so more accurate than one point.
  EXPECT_LT(std::sqrt(squares / surface.mesh.vertices.size()), kSigma_m);
  // The cap's area is 2 pi r^2 (1 - cos 60). Chords and the ragged border cost less than a tenth of
  // it, and no triangles overlap.
  const double cap_m2 = std::numbers::pi * 0.08 * 0.08;
  EXPECT_GT(area_m2, 0.9 * cap_m2);
  EXPECT_LT(area_m2, 1.05 * cap_m2);
}

TEST(SurfaceReconstruction, HasNoRepeatedTriangle) {
  Surface surface = ReconstructSurface(SpherePatch(6000, 3), {});
  for (auto& triangle : surface.mesh.triangles) std::sort(triangle.begin(), triangle.end());
  auto& triangles = surface.mesh.triangles;
  ASSERT_GT(triangles.size(), 1000U);
  std::sort(triangles.begin(), triangles.end());
  EXPECT_EQ(std::adjacent_find(triangles.begin(), triangles.end()), triangles.end());
}

TEST(SurfaceReconstruction, GivesTheSameBytesTwice) {
  const OrientedPoints points = SpherePatch(4000, 4);
  const Surface once = ReconstructSurface(points, {});
  const Surface again = ReconstructSurface(points, {});
  ASSERT_GT(once.mesh.triangles.size(), 1000U);
  EXPECT_EQ(once.mesh, again.mesh);
  EXPECT_EQ(once.explained, again.explained);
}

TEST(SurfaceReconstruction, WidensTheSpacingUntilTheCapHolds) {
  const OrientedPoints points = SpherePatch(6000, 5);
  const SurfaceOptions options{.max_triangles = 300};
  const Surface surface = ReconstructSurface(points, options);
  ExpectSound(points, surface, options);
  EXPECT_GT(surface.mesh.triangles.size(), 100U);
  // The sagitta of a triangle of 2 cm on this sphere is below a millimetre: nothing is lost.
  EXPECT_GE(surface.explained.size(), points.size() * 99 / 100);
}

// A sample of the points determines how much wider the spacing must be.
TEST(SurfaceReconstruction, WidensTheSpacingOfManyPointsNoFartherThanTheCapAsks) {
  const OrientedPoints points = SpherePatch(200'000, 5);
  const SurfaceOptions options{.max_triangles = 300};
  const Surface surface = ReconstructSurface(points, options);
  ExpectSound(points, surface, options);
  EXPECT_GT(surface.mesh.triangles.size(), 100U);
  EXPECT_GE(surface.explained.size(), points.size() * 99 / 100);
}

TEST(SurfaceReconstruction, CoversALonelyPointByOneSmallTriangle) {
  const OrientedPoints points = PointsOf({{0.1F, 0.2F, 0.3F}});
  const Surface surface = ReconstructSurface(points, {});
  ExpectSound(points, surface, {});
  ASSERT_EQ(surface.mesh.triangles.size(), 1U);
  EXPECT_THAT(surface.explained, ::testing::ElementsAre(0U));
  for (const Vector3& p : surface.mesh.vertices) {
    EXPECT_LE((p - points.points[0].cast<double>()).norm(), SurfaceOptions{}.spacing_m);
  }
}

TEST(SurfaceReconstruction, CoversEqualPointsAtTheViewpointItself) {
  const OrientedPoints points =
      PointsOf(std::vector<Eigen::Vector3f>(1000, kViewpoint.cast<float>()));
  const Surface surface = ReconstructSurface(points, {});
  ExpectSound(points, surface, {});
  EXPECT_EQ(surface.mesh.triangles.size(), 1U);
  EXPECT_EQ(surface.explained.size(), points.size());
}

TEST(SurfaceReconstruction, CoversPointsOnALine) {
  std::vector<Eigen::Vector3f> line;
  for (int i = 0; i < 2000; ++i) line.emplace_back(0.0001F * static_cast<float>(i), 0.F, 0.F);
  const OrientedPoints points = PointsOf(std::move(line));
  const Surface surface = ReconstructSurface(points, {});
  ExpectSound(points, surface, {});
  EXPECT_EQ(surface.explained.size(), points.size());
}

TEST(SurfaceReconstruction, CoversAMillionDuplicatesOfAFewPoints) {
  std::vector<Eigen::Vector3f> positions;
  for (int i = 0; i < 1000000; ++i) {
    positions.emplace_back(0.002F * static_cast<float>(i % 10), 0.002F * static_cast<float>(i % 7),
                           0.F);
  }
  const OrientedPoints points = PointsOf(std::move(positions));
  const Surface surface = ReconstructSurface(points, {});
  ExpectSound(points, surface, {});
  EXPECT_EQ(surface.explained.size(), points.size());
}

TEST(SurfaceReconstruction, StaysBoundedForPointsWithoutASurface) {
  std::mt19937_64 random(6);
  std::vector<Eigen::Vector3f> positions;
  for (int i = 0; i < 50000; ++i) {
    Eigen::Vector3f p;
    for (int axis = 0; axis < 3; ++axis) p[axis] = static_cast<float>(random() >> 40) * 0x1.0p-24F;
    positions.push_back(p);
  }
  const OrientedPoints points = PointsOf(std::move(positions));
  const SurfaceOptions options{.max_triangles = 2000};
  const Surface surface = ReconstructSurface(points, options);
  ExpectSound(points, surface, options);
  EXPECT_FALSE(surface.mesh.triangles.empty());
}

TEST(SurfaceReconstruction, SurvivesSmallAndFarClustersOfAnyShape) {
  std::mt19937_64 random(7);
  const auto uniform = [&] { return static_cast<float>(random() >> 40) * 0x1.0p-24F; };
  for (int round = 0; round < 300; ++round) {
    const std::size_t count = 1 + random() % 60;
    const Eigen::Vector3f extent_m =
        Eigen::Vector3f{uniform(), uniform(), uniform()}.array().pow(3) * 0.2F;
    const float far_m = std::pow(10.F, 4 * uniform() - 2);
    std::vector<Eigen::Vector3f> positions;
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::Vector3f p{uniform(), uniform(), uniform()};
      positions.push_back(Eigen::Vector3f::Constant(far_m) + extent_m.cwiseProduct(p));
    }
    const OrientedPoints points = PointsOf(std::move(positions));
    const Surface surface = ReconstructSurface(points, {});
    ExpectSound(points, surface, {});
    EXPECT_EQ(surface.explained.size(), points.size()) << "round " << round;
  }
}

TEST(SurfaceReconstruction, OfNothingIsNothing) {
  const Surface surface = ReconstructSurface(PointsOf({}), {});
  EXPECT_TRUE(surface.mesh.triangles.empty());
  EXPECT_TRUE(surface.explained.empty());
}

// Half a metre square of points that scatter by 2 cm: most of them are alone in a cell of 4 mm.
TEST(SurfaceReconstruction, VerticesAreNoNearerThanTheNoise) {
  constexpr float kCoarseSigma_m = 0.02F;
  std::mt19937_64 random(5);
  std::normal_distribution<float> noise(0, kCoarseSigma_m);
  std::uniform_real_distribution<float> place(0, 0.5F);
  std::vector<Eigen::Vector3f> positions;
  for (int i = 0; i < 20'000; ++i)
    positions.emplace_back(place(random), place(random), noise(random));
  OrientedPoints points = PointsOf(std::move(positions));
  points.sigma_m.assign(points.size(), kCoarseSigma_m);
  const Surface surface = ReconstructSurface(points, {});
  // Cells of sigma in six layers, 25 x 25 each; two triangles per vertex.
  EXPECT_LT(surface.mesh.triangles.size(), 2u * 6 * 25 * 25);
  // Within 3 sigma, apart from 0.3 % of a normal distribution and the mesh's own error.
  EXPECT_GT(surface.explained.size(), 0.99 * 20'000);
}

}  // namespace
}  // namespace cwm::perception
