// Walls that face the sensor, with a gap, a step or a bend in their middle.
#include "perception/segmentation/surface_planes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "perception/cloud/tolerances.h"
#include "tests/perception/segmentation/drawn_image.h"

namespace cwm::perception {
namespace {

constexpr DrawnFormat kPlanesFormat{.width = 60, .height = 30, .focal_px = 525};
constexpr float kPlanesDepth_m = 0.8f;
constexpr int kMiddleRow = 15, kMiddleColumn = 30;

bool IsMiddle(int row, int column) { return row == kMiddleRow && column == kMiddleColumn; }

SurfacePlanes PlanesOfDrawn(const MeasuredPoints& measured) {
  std::vector<float> range_m;
  for (const Eigen::Vector3f& p : measured.oriented.points) range_m.push_back(p.norm());
  return PlanesOfSurface(measured, range_m, {});
}

// A wall whose middle pixel does not return.
MeasuredPoints WallWithAGap() {
  return DrawnImage(kPlanesFormat,
                    [](int v, int u) { return IsMiddle(v, u) ? std::nanf("") : kPlanesDepth_m; });
}

TEST(PlanesOfSurface, HoldWhatIsMeasuredAndNothingWhereNothingIsKnown) {
  MeasuredPoints measured = WallWithAGap();
  measured.oriented.normals[0].setZero();
  const SurfacePlanes planes = PlanesOfDrawn(measured);
  EXPECT_EQ(planes.width, kPlanesFormat.width);
  EXPECT_EQ(planes.height, kPlanesFormat.height);
  EXPECT_FLOAT_EQ(planes.sample_angle_rad, std::sqrt(12.0f) * planes.pixel_angle_rad);
  const float x = 10 / kPlanesFormat.focal_px * kPlanesDepth_m;
  EXPECT_FLOAT_EQ(planes.x.Row(kMiddleRow)[40], x);
  EXPECT_FLOAT_EQ(planes.y.Row(kMiddleRow)[40], 0);
  EXPECT_FLOAT_EQ(planes.z.Row(kMiddleRow)[40], kPlanesDepth_m);
  EXPECT_FLOAT_EQ(planes.range_m.Row(kMiddleRow)[40], std::hypot(x, kPlanesDepth_m));
  EXPECT_FLOAT_EQ(planes.normal_z.Row(kMiddleRow)[40], -1);
  EXPECT_NEAR(planes.sigma_m.Row(kMiddleRow)[40], 0.0012 + 0.0019 * 0.4 * 0.4, 1e-6);  // a Kinect's
  for (const ImagePlane* plane : {&planes.x, &planes.normal_z, &planes.range_m, &planes.sigma_m}) {
    EXPECT_TRUE(std::isnan(plane->Row(kMiddleRow)[kMiddleColumn]));
    EXPECT_TRUE(std::isnan(plane->Row(0)[-1]));
    EXPECT_TRUE(std::isnan(plane->Row(0)[kPlanesFormat.width]));
  }
  EXPECT_FALSE(std::isnan(planes.x.Row(0)[0]));
  EXPECT_TRUE(std::isnan(planes.normal_x.Row(0)[0]));
}

// One bit for each of kNeighbourOffsets: the row above, left and right, the row below.
TEST(LinkRow, LinksAllThatIsBesideButWhatIsNotThere) {
  const SurfacePlanes planes = PlanesOfDrawn(WallWithAGap());
  RowLinks middle(planes.width), above(planes.width), top(planes.width);
  LinkRow(planes, kMiddleRow, middle);
  LinkRow(planes, kMiddleRow - 1, above);
  LinkRow(planes, 0, top);
  EXPECT_EQ(middle.linked[10], 0xff);
  EXPECT_EQ(middle.linked[kMiddleColumn], 0);
  EXPECT_EQ(middle.linked[kMiddleColumn - 1], 0xff & ~(1 << 4));  // not right of it
  EXPECT_EQ(middle.linked[kMiddleColumn + 1], 0xff & ~(1 << 3));  // not left of it
  EXPECT_EQ(above.linked[kMiddleColumn], 0xff & ~(1 << 6));       // not below it
  EXPECT_EQ(top.linked[0], 1 << 4 | 1 << 6 | 1 << 7);
  EXPECT_EQ(top.linked[59], 1 << 3 | 1 << 5 | 1 << 6);
  for (std::size_t u = 0; u < 60; ++u) EXPECT_EQ(middle.steps[u], 0) << u;
}

// Noise explains 6 mm; up to 14.5 mm is no jump.
TEST(LinkRow, EndsAtAStepThatItTellsFromNoiseAndFromAJump) {
  struct Step {
    float step_m;
    bool is_linked, is_step;
  };
  for (const Step& step :
       {Step{0.004f, true, false}, {0.012f, false, true}, {0.05f, false, false}}) {
    const SurfacePlanes planes = PlanesOfDrawn(DrawnImage(kPlanesFormat, [&](int, int u) {
      return u < kMiddleColumn ? kPlanesDepth_m : kPlanesDepth_m - step.step_m;
    }));
    RowLinks row(planes.width);
    LinkRow(planes, kMiddleRow, row);
    const int right = 1 << 2 | 1 << 4 | 1 << 7, left = 1 << 0 | 1 << 3 | 1 << 5;
    EXPECT_EQ(row.linked[kMiddleColumn - 2], 0xff) << step.step_m;
    EXPECT_EQ(row.linked[kMiddleColumn - 1], step.is_linked ? 0xff : 0xff & ~right) << step.step_m;
    EXPECT_EQ(row.linked[kMiddleColumn], step.is_linked ? 0xff : 0xff & ~left) << step.step_m;
    EXPECT_EQ(row.steps[kMiddleColumn - 1] != 0, step.is_step) << step.step_m;
    EXPECT_EQ(row.steps[kMiddleColumn] != 0, step.is_step) << step.step_m;
    EXPECT_EQ(row.steps[kMiddleColumn - 2], 0) << step.step_m;
  }
}

// Two faces that lean by 15 degrees to either side of the middle column, towards the sensor if
// `turn` is 1. The middle pixel does not return.
SurfacePlanes BentWall(float turn) {
  const float slope = turn * std::tan(15 * static_cast<float>(kDegree));
  MeasuredPoints measured = DrawnImage(kPlanesFormat, [&](int v, int u) {
    if (IsMiddle(v, u)) return std::nanf("");
    const float away = static_cast<float>(std::abs(u - kMiddleColumn)) / kPlanesFormat.focal_px;
    return kPlanesDepth_m / (1 + slope * away);
  });
  for (std::size_t i = 0; i < measured.oriented.size(); ++i) {
    const float side = ColumnOf(measured, i) < kMiddleColumn ? 1 : -1;
    measured.oriented.normals[i] = Eigen::Vector3f(side * slope, 0, -1).normalized();
  }
  return PlanesOfDrawn(measured);
}

TEST(CreaseRow, TellsWhereTheSurfaceTurnsTowardsTheViewerByMoreThanTheAngle) {
  std::vector<std::uint8_t> crease;
  const auto angle_rad = [](float degrees) { return degrees * static_cast<float>(kDegree); };
  CreaseRow(BentWall(1), kMiddleRow, angle_rad(28), crease);
  EXPECT_NE(crease[kMiddleColumn - 1], 0);
  EXPECT_NE(crease[kMiddleColumn + 1], 0);
  EXPECT_EQ(crease[kMiddleColumn], 0) << "where there is no point";
  EXPECT_EQ(crease[kMiddleColumn - 10], 0) << "farther off than a normal's neighbourhood reaches";
  EXPECT_EQ(crease[kMiddleColumn + 10], 0);
  CreaseRow(BentWall(1), kMiddleRow, angle_rad(32), crease);
  for (std::size_t u = 0; u < 60; ++u) EXPECT_EQ(crease[u], 0) << u;
  CreaseRow(BentWall(-1), kMiddleRow, angle_rad(28), crease);
  for (std::size_t u = 0; u < 60; ++u) EXPECT_EQ(crease[u], 0) << "away from the viewer " << u;
}

}  // namespace
}  // namespace cwm::perception
