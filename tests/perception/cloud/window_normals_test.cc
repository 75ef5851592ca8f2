#include "perception/cloud/window_normals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "perception/cloud/normals.h"

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

// At 0.8 m pixels are 1.52 mm apart; the radius of seven sigma is 4.6 pixels.
constexpr int kColumnCount = 21, kRowCount = 16, kMiddleColumn = 10, kMiddleRow = 8;
constexpr float kPixelAngle_rad = 1 / 525.0f, kFaceDepth_m = 0.8f, kRangeSigma_m = 0.001f;
constexpr float kWindowRadius_m = 0.007f;
constexpr float kNoPoint = std::numeric_limits<float>::quiet_NaN();

// depth_m(column, row) returns z at the end of the pixel's ray.
template <class Depth>
PointPlanes PlanesWith(const Depth& depth_m, float sigma_m = kRangeSigma_m) {
  PointPlanes planes{.width = kColumnCount,
                     .height = kRowCount,
                     .pixel_angle_rad = kPixelAngle_rad,
                     .x = {kColumnCount, kRowCount},
                     .y = {kColumnCount, kRowCount},
                     .z = {kColumnCount, kRowCount},
                     .sigma_m = {kColumnCount, kRowCount}};
  for (int row = 0; row < kRowCount; ++row) {
    for (int column = 0; column < kColumnCount; ++column) {
      const float z = depth_m(column, row);
      if (std::isnan(z)) continue;
      planes.x.Row(row)[column] = z * kPixelAngle_rad * static_cast<float>(column - kMiddleColumn);
      planes.y.Row(row)[column] = z * kPixelAngle_rad * static_cast<float>(row - kMiddleRow);
      planes.z.Row(row)[column] = z;
      planes.sigma_m.Row(row)[column] = sigma_m;
    }
  }
  return planes;
}

float FacingSensor(int, int) { return kFaceDepth_m; }

RowNormals NormalsOfRow(const PointPlanes& planes, int row) {
  RowNormals normals(kColumnCount);
  EstimateRow(planes, row, normals);
  return normals;
}

Vector3f NormalAt(const RowNormals& normals, int column) {
  const auto at = static_cast<std::size_t>(column);
  return {normals.x[at], normals.y[at], normals.z[at]};
}

TEST(EstimateRow, FindsASlantedPlaneUpToTheEdgesOfTheImage) {
  const Vector3f normal = Vector3f(0.5f, -0.3f, -0.8f).normalized();
  const PointPlanes planes = PlanesWith([&normal](int column, int row) {
    const Vector3f ray(kPixelAngle_rad * static_cast<float>(column - kMiddleColumn),
                       kPixelAngle_rad * static_cast<float>(row - kMiddleRow), 1);
    return kFaceDepth_m * normal.z() / normal.dot(ray);
  });
  for (const int row : {0, kMiddleRow, kRowCount - 1}) {
    const RowNormals normals = NormalsOfRow(planes, row);
    for (int column = 0; column < kColumnCount; ++column) {
      EXPECT_LT((NormalAt(normals, column) - normal).norm(), 0.01f) << column << " " << row;
    }
  }
}

TEST(EstimateRow, TellsSigmaByThePointsThatErrByThemselves) {
  PointPlanes planes = PlanesWith(FacingSensor);
  // 9 x 9 pixels in the middle, 5 x 5 in a corner.
  EXPECT_NEAR(NormalsOfRow(planes, kMiddleRow).sigma_rad[kMiddleColumn],
              2 * kRangeSigma_m / (kWindowRadius_m * 9), 1e-5);
  EXPECT_NEAR(NormalsOfRow(planes, 0).sigma_rad[0], 2 * kRangeSigma_m / (kWindowRadius_m * 5),
              1e-5);
  // A sample of every second pixel has 5 x 5 of them; each stands for 4 pixels, and 12 pixels for
  // one independent error.
  planes.sample_px = std::sqrt(12.0f);
  const RowNormals normals = NormalsOfRow(planes, kMiddleRow);
  EXPECT_NEAR(normals.sigma_rad[kMiddleColumn],
              2 * kRangeSigma_m / (kWindowRadius_m * std::sqrt(25 * 4 / 12.0f)), 1e-5);
  EXPECT_LT((NormalAt(normals, kMiddleColumn) + Vector3f::UnitZ()).norm(), 1e-3f);
}

TEST(EstimateRow, LeavesOutWhatLiesBehindAJump) {
  const PointPlanes planes =
      PlanesWith([](int column, int) { return column < kMiddleColumn ? kFaceDepth_m : 0.85f; });
  const RowNormals normals = NormalsOfRow(planes, kMiddleRow);
  for (int column = 0; column < kColumnCount; ++column) {
    EXPECT_LT((NormalAt(normals, column) + Vector3f::UnitZ()).norm(), 1e-3f) << column;
  }
  // The window ends at the jump: it holds five columns of nine.
  EXPECT_NEAR(normals.sigma_rad[kMiddleColumn - 1],
              2 * kRangeSigma_m / (kWindowRadius_m * std::sqrt(45.0f)), 1e-5);
}

TEST(EstimateRow, KnowsNoNormalOfALineOrOfALonePoint) {
  const RowNormals line = NormalsOfRow(
      PlanesWith([](int, int row) { return row == kMiddleRow ? kFaceDepth_m : kNoPoint; }),
      kMiddleRow);
  for (int column = 0; column < kColumnCount; ++column) {
    EXPECT_TRUE(NormalAt(line, column).isZero()) << column;
  }
  const auto alone = [](int column, int row) {
    return column == kMiddleColumn && row == kMiddleRow ? kFaceDepth_m : kNoPoint;
  };
  const RowNormals point = NormalsOfRow(PlanesWith(alone), kMiddleRow);
  EXPECT_TRUE(NormalAt(point, kMiddleColumn).isZero());
  EXPECT_NEAR(point.sigma_rad[kMiddleColumn], 2.0f / 7, 1e-5);
  // A right angle is the largest error that a normal can have.
  const RowNormals vague = NormalsOfRow(PlanesWith(alone, 0.02f), kMiddleRow);
  EXPECT_EQ(vague.sigma_rad[kMiddleColumn], kUnknownSigma_rad);
}

}  // namespace
}  // namespace cwm::perception
