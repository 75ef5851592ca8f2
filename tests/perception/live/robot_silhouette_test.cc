#include "perception/live/robot_silhouette.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <random>

#include "perception/simulation/ray_casting.h"
#include "tests/perception/live/robot_scene.h"

namespace cwm::perception {
namespace {

DepthCamera SmallCamera() {
  return {.pinhole = {100, 100, 79.5, 59.5}, .width = 160, .height = 120};
}

// The ray through the centre of a cell, with depth 1.
Vector3 CellRay(int column, int row) {
  const double u = kSilhouetteCell_px * column + 0.5, v = kSilhouetteCell_px * row + 0.5;
  return {(u - 79.5) / 100, (v - 59.5) / 100, 1};
}

TEST(RobotSilhouette, HasTheDepthThatRaysHit) {
  std::mt19937_64 random(1);
  const std::vector<Shape> shapes = {
      Box{{0.3, 0.1, 0.2}}, Cylinder{.radius_m = 0.1, .length_m = 0.3}, Sphere{.radius_m = 0.15}};
  std::vector<LinkSurface> surfaces;
  for (const Shape& shape : shapes) {
    const Placed<> placed{Pose::Identity(), shape};
    surfaces.emplace_back(std::span(&placed, 1));
  }
  // Round shapes are approximated within 0.5 mm, which moves an outline by less than a cell.
  constexpr double kTolerance_m = 0.004;
  int compared = 0, differ = 0;
  for (int i = 0; i < 30; ++i) {
    const Shape& shape = shapes[static_cast<std::size_t>(i) % shapes.size()];
    Pose X_CL = RandomPose(random, 0.2);
    X_CL.translation().z() += 0.9;
    RobotSilhouette silhouette;
    silhouette.Reset(SmallCamera());
    silhouette.Draw(surfaces[static_cast<std::size_t>(i) % shapes.size()], X_CL, 3);
    for (int row = 0; row < silhouette.rows(); ++row) {
      for (int column = 0; column < silhouette.columns(); ++column) {
        const Pose X_LC = X_CL.inverse();
        const auto hit = CastRay(shape, {.origin = X_LC.translation(),
                                         .direction = X_LC.linear() * CellRay(column, row)});
        const auto cell = static_cast<std::size_t>(row * silhouette.columns() + column);
        const float near_m = silhouette.near_m()[cell];
        EXPECT_EQ(silhouette.body()[cell], near_m == RobotSilhouette::kNothing_m ? -1 : 3);
        if (!hit && near_m == RobotSilhouette::kNothing_m) continue;
        ++compared;
        if (!hit || std::abs(near_m - hit->t) > kTolerance_m) ++differ;
      }
    }
  }
  EXPECT_GT(compared, 3000);
  EXPECT_LT(differ, compared / 50);  // along outlines
}

TEST(RobotSilhouette, ShowsTheNearerOfTwo) {
  RobotSilhouette silhouette;
  silhouette.Reset(SmallCamera());
  const Placed<> box{Pose::Identity(), Box{{0.2, 0.2, 0.2}}};
  const LinkSurface surface({&box, 1});
  for (const double z : {1.0, 0.6, 1.5}) {
    silhouette.Draw(surface, MakeTranslation(0, 0, z), static_cast<std::int16_t>(10 * z));
  }
  const auto middle = static_cast<std::size_t>(30 * silhouette.columns() + 40);
  EXPECT_NEAR(silhouette.near_m()[middle], 0.5, 1e-5);
  EXPECT_EQ(silhouette.body()[middle], 6);
}

TEST(RobotSilhouette, CutsWhatReachesBehindTheCamera) {
  RobotSilhouette silhouette;
  silhouette.Reset(SmallCamera());
  // A long bar beside the optical axis, from behind the camera to before it.
  const Placed<> bar{Pose::Identity(), Box{{0.1, 0.1, 4}}};
  silhouette.Draw(LinkSurface({&bar, 1}), MakeTranslation(0.15, 0, 0), 0);
  int drawn = 0;
  for (int row = 0; row < silhouette.rows(); ++row) {
    for (int column = 0; column < silhouette.columns(); ++column) {
      const Vector3 ray = CellRay(column, row);
      const auto hit = CastRay(bar.shape, {.origin = {-0.15, 0, 0}, .direction = ray});
      const bool is_certain = std::abs(ray.x() * 2 - 0.1) > 0.03;  // not at the bar's outline
      const auto cell = static_cast<std::size_t>(row * silhouette.columns() + column);
      if (!hit || !is_certain) continue;
      ++drawn;
      EXPECT_NEAR(silhouette.near_m()[cell], hit->t, 0.02 * hit->t);
    }
  }
  EXPECT_GT(drawn, 500);
}

TEST(RobotSilhouette, IsEmptyBehindTheCameraAndInsideASolid) {
  const Placed<> ball{Pose::Identity(), Sphere{.radius_m = 0.2}};
  const LinkSurface surface({&ball, 1});
  for (const double z : {-1.0, 0.0}) {
    RobotSilhouette silhouette;
    silhouette.Reset(SmallCamera());
    silhouette.Draw(surface, MakeTranslation(0, 0, z), 0);
    EXPECT_THAT(silhouette.near_m(), testing::Each(RobotSilhouette::kNothing_m)) << z;
  }
}

TEST(RobotSilhouette, CountsTheCellsToTheOutline) {
  std::mt19937_64 random(4);
  RobotSilhouette silhouette;
  silhouette.Reset(SmallCamera());
  const Placed<> box{Pose::Identity(), Box{{0.3, 0.2, 0.2}}};
  for (int i = 0; i < 3; ++i) {
    Pose X_CL = RandomPose(random, 0.3);
    X_CL.translation().z() += 1;
    silhouette.Draw(LinkSurface({&box, 1}), X_CL, 0);
  }
  const std::vector<std::int16_t> cells = silhouette.CellsToOutline();
  const int columns = silhouette.columns(), rows = silhouette.rows();
  for (int row = 0; row < rows; row += 3) {
    for (int column = 0; column < columns; column += 3) {
      int nearest = std::numeric_limits<int>::max();
      for (int r = 0; r < rows; ++r) {
        for (int c = 0; c < columns; ++c) {
          if (silhouette.body()[static_cast<std::size_t>(r * columns + c)] >= 0) continue;
          nearest = std::min(nearest, std::max(std::abs(r - row), std::abs(c - column)));
        }
      }
      EXPECT_EQ(cells[static_cast<std::size_t>(row * columns + column)], nearest);
    }
  }
}

TEST(DilateNearest, TakesTheLeastValueWithinARadius) {
  std::mt19937_64 random(5);
  constexpr int kColumns = 17, kRows = 11;
  for (const int radius : {0, 1, 2, 30}) {
    std::vector<float> values(kColumns * kRows, RobotSilhouette::kNothing_m);
    for (int i = 0; i < 12; ++i) {
      values[random() % values.size()] = 0.1F * static_cast<float>(random() % 100);
    }
    std::vector<float> dilated = values;
    DilateNearest(kColumns, radius, dilated);
    for (int row = 0; row < kRows; ++row) {
      for (int column = 0; column < kColumns; ++column) {
        float least = RobotSilhouette::kNothing_m;
        for (int r = std::max(0, row - radius); r <= std::min(kRows - 1, row + radius); ++r) {
          for (int c = std::max(0, column - radius); c <= std::min(kColumns - 1, column + radius);
               ++c) {
            least = std::min(least, values[static_cast<std::size_t>(r * kColumns + c)]);
          }
        }
        EXPECT_EQ(dilated[static_cast<std::size_t>(row * kColumns + column)], least);
      }
    }
  }
}

}  // namespace
}  // namespace cwm::perception
