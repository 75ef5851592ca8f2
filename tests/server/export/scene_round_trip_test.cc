// Every shape written in both formats and read back, compared by signed distances.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "clients/formats/scene_file.h"
#include "collision/geometry/signed_distance.h"
#include "server/export/moveit_scene.h"
#include "tests/server/export/world_of_all.h"

namespace cwm::server {
namespace {

using collision::WorldSnapshot;

Pose PoseFrom(const formats::ScenePose& pose) {
  const auto& q = pose.orientation_xyzw;
  const auto& p = pose.position_m;
  return MakePose({p[0], p[1], p[2]}, Quaternion(q[3], q[0], q[1], q[2]));
}

struct ToShape {
  Shape operator()(const formats::SceneBox& s) const {
    return Box{{s.size_m[0], s.size_m[1], s.size_m[2]}};
  }
  Shape operator()(const formats::SceneSphere& s) const { return Sphere{s.radius_m}; }
  Shape operator()(const formats::SceneCylinder& s) const {
    return Cylinder{s.radius_m, s.height_m};
  }
  Shape operator()(const formats::SceneCone& s) const { return Cone{s.radius_m, 0, s.height_m}; }
  Shape operator()(const formats::SceneHalfSpace&) const { return HalfSpace{}; }
  Shape operator()(const formats::MeshFile& s) const {
    TriangleMesh mesh;
    for (const auto& v : s.vertices) mesh.vertices.emplace_back(v[0], v[1], v[2]);
    mesh.triangles.assign(s.triangles.begin(), s.triangles.end());
    return MakeMesh(std::move(mesh));
  }
};

double DistanceIn(const formats::SceneObject& object, const Vector3& p_W) {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const formats::SceneShape& shape : object.shapes) {
    const Vector3 p = (PoseFrom(object.pose) * PoseFrom(shape.pose)).inverse() * p_W;
    nearest_m = std::min(nearest_m, SignedDistance_m(std::visit(ToShape{}, shape.shape), p));
  }
  return nearest_m;
}

constexpr std::int64_t kAnyTriangles = 1'000'000;

void ExpectSameGeometry(const WorldSnapshot& world, const std::string& text) {
  const auto scene = formats::ParseScene(text, "exported");
  ASSERT_TRUE(scene.ok()) << scene.status();
  ASSERT_EQ(scene->objects.size(), world.objects().size());
  std::mt19937 random(3);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  for (const formats::SceneObject& read : scene->objects) {
    const auto object = world.Find(read.id);
    ASSERT_NE(object, nullptr) << read.id;
    const auto cases = Cases();
    const auto known = std::find_if(cases.begin(), cases.end(), [&](const Case& c) {
      return c.name == read.id.substr(0, read.id.find('.'));
    });
    for (int i = 0; i < 40; ++i) {
      const Vector3 p(coordinate(random), coordinate(random), coordinate(random));
      EXPECT_NEAR(DistanceIn(read, p), DistanceInObject(*object, p), known->tolerance_m) << read.id;
    }
  }
}

TEST(SceneRoundTrip, KeepsEveryShapeWhereItIs) {
  const auto world = WorldOfAll();
  const auto scene = MakePlanningScene(*world, kAnyTriangles);
  ASSERT_TRUE(scene.ok()) << scene.status();
  ExpectSameGeometry(*world, FormatSceneText(*scene).value());
  ExpectSameGeometry(*world, FormatSceneYaml(*scene).value());
}

TEST(SceneRoundTrip, WritesTheSameBytesEveryTime) {
  const auto first = MakePlanningScene(*WorldOfAll(), kAnyTriangles);
  const auto second = MakePlanningScene(*WorldOfAll(), kAnyTriangles);
  EXPECT_EQ(FormatSceneText(*first).value(), FormatSceneText(*second).value());
  EXPECT_EQ(FormatSceneYaml(*first).value(), FormatSceneYaml(*second).value());
}

TEST(SceneRoundTrip, SaysWhatBecameAMesh) {
  const auto scene = MakePlanningScene(*WorldOfAll(), kAnyTriangles);
  EXPECT_THAT(scene->warnings,
              ::testing::UnorderedElementsAre(
                  ::testing::HasSubstr("Cup, Cup.2: a truncated cone is written as a mesh, up to"),
                  ::testing::HasSubstr("Capsule, Capsule.2: a capsule is written as a mesh, up to"),
                  ::testing::HasSubstr("Crooked, Crooked.2, WithHole, WithHole.2: a plate is"),
                  ::testing::HasSubstr("HalfSpace, HalfSpace.2: a half-space is written as")));
}

TEST(SceneRoundTrip, RefusesMoreTrianglesThanMayBe) {
  const auto scene = MakePlanningScene(*WorldOfAll(), 100);
  EXPECT_EQ(scene.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(scene.status().message()), ::testing::HasSubstr("at most 100"));
}

}  // namespace
}  // namespace cwm::server
