#include "collision/geometry/validation.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>

#include "collision/geometry/tessellate.h"

namespace cwm {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::string FieldOf(const Shape& shape) {
  const std::optional<Violation> violation = FindViolation(shape);
  return violation ? violation->field : "";
}

TEST(Validation, NamesTheFirstFieldThatBreaksARule) {
  EXPECT_EQ(FieldOf(Sphere{1}), "");
  EXPECT_EQ(FieldOf(Sphere{-1}), "radius_m");
  EXPECT_EQ(FieldOf(Sphere{1e7}), "radius_m");
  EXPECT_EQ(FieldOf(Box{{1, kNan, 1}}), "size_y_m");
  EXPECT_EQ(FieldOf(Cone{0, 0, 1}), "radius_bottom_m");
  EXPECT_EQ(FieldOf(Cone{1, 0, 1}), "");
  EXPECT_EQ(FieldOf(Plate{{{0, 0}, {1, 0}}, {}, 1}), "outline");
  EXPECT_EQ(FieldOf(Plate{{{0, 0}, {1, 0}, {0, kNan}}, {}, 1}), "outline[2].y");
  EXPECT_EQ(FieldOf(Plate{{{0, 0}, {1, 0}, {0, 1}}, {{{5, 5}, {6, 5}, {5, 6}}}, 1}), "holes");
  EXPECT_EQ(FieldOf(Convex{}), "hull");
  EXPECT_EQ(FindViolation(Shape(Sphere{kNan}))->value, "nan");
}

TEST(Validation, FindsBadTriangles) {
  TriangleMesh mesh = Tessellate(Box{{1, 1, 1}});
  EXPECT_FALSE(FindViolation(mesh));
  mesh.triangles[3] = {0, 1, 99};
  EXPECT_EQ(FindViolation(mesh)->field, "triangles[3]");
  mesh.triangles[3] = {0, 1, 1};
  EXPECT_EQ(FindViolation(mesh)->field, "triangles[3]");
  mesh.triangles.clear();
  EXPECT_EQ(FindViolation(mesh)->field, "triangles");
}

TEST(Validation, AcceptsHullsAndRefusesDents) {
  TriangleMesh hull = Tessellate(Capsule{0.5, 1}, 0.01);
  for (Vector3& v : hull.vertices) v = v.cast<float>().cast<double>();
  EXPECT_FALSE(FindViolation(Shape(Convex{std::make_shared<const TriangleMesh>(hull)})));
  hull.vertices[10] *= 0.9;
  EXPECT_TRUE(FindViolation(Shape(Convex{std::make_shared<const TriangleMesh>(hull)})));
}

}  // namespace
}  // namespace cwm
