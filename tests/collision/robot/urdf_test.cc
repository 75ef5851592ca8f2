#include "collision/robot/urdf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/collision/mesh_files/mesh_bytes.h"
#include "tests/collision/robot/robot_text.h"

namespace cwm::collision {
namespace {

using testing::BoxMesh;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::JointText;
using testing::Links;
using testing::NoMeshes;
using testing::Robot;

constexpr double kRounding = 1e-15;

RobotDescription Read(const std::string& elements, const MeshSource& meshes = NoMeshes) {
  auto robot = ReadUrdf(Robot(elements), meshes);
  EXPECT_TRUE(robot.ok()) << robot.status();
  return robot.ok() ? *std::move(robot) : RobotDescription();
}

// The only collision of the only link.
CollisionGeometry ReadCollision(const std::string& elements, const MeshSource& meshes = NoMeshes) {
  const RobotDescription robot =
      Read("<link name=\"a\"><collision>" + elements + "</collision></link>", meshes);
  EXPECT_EQ(robot.links.size(), 1u);
  EXPECT_EQ(robot.links[0].collisions.size(), 1u);
  return robot.links[0].collisions[0];
}

Joint ReadJoint(const std::string& kind, const std::string& more) {
  const RobotDescription robot = Read(Links("ab") + JointText("j", kind, "a", "b", more));
  EXPECT_EQ(robot.joints.size(), 1u);
  return robot.joints.empty() ? Joint() : robot.joints[0];
}

TEST(Urdf, ReadsEveryShape) {
  const auto shape = [](const std::string& text) {
    return ReadCollision("<geometry>" + text + "</geometry>").shape;
  };
  EXPECT_EQ(shape("<box size=\" 1 2\t3\n\"/>"), Shape(Box{{1, 2, 3}}));
  EXPECT_EQ(shape("<sphere radius=\"0.5\"/>"), Shape(Sphere{0.5}));
  EXPECT_EQ(shape("<cylinder radius=\"5e-1\" length=\"+2\"/>"), Shape(Cylinder{0.5, 2}));
  EXPECT_EQ(shape("<capsule radius=\"0.5\" length=\"2\"/>"), Shape(Capsule{0.5, 2}));
}

absl::StatusOr<std::string> Tetrahedron(std::string_view) {
  return "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
}

// Each geometry keeps its pose; its size is multiplied about its own origin.
TEST(Urdf, ScalesTheGeometryOfLinks) {
  const auto shape_of = [](const std::string& text, double scale) {
    const auto robot =
        ReadUrdf(Robot("<link name=\"a\"><collision><origin xyz=\"1 2 3\"/><geometry>" + text +
                       "</geometry></collision></link>"),
                 Tetrahedron, {}, {}, {{"a", scale}, {"*", 7}});
    EXPECT_TRUE(robot.ok()) << robot.status();
    const CollisionGeometry& geometry = robot->links[0].collisions[0];
    EXPECT_EQ(geometry.X_LG.translation(), Vector3(1, 2, 3));
    return geometry.shape;
  };
  EXPECT_EQ(shape_of("<box size=\"1 2 3\"/>", 2), Shape(Box{{2, 4, 6}}));
  EXPECT_EQ(shape_of("<sphere radius=\"0.5\"/>", 0.5), Shape(Sphere{0.25}));
  EXPECT_EQ(shape_of("<cylinder radius=\"0.5\" length=\"2\"/>", 2), Shape(Cylinder{1, 4}));
  EXPECT_EQ(shape_of("<capsule radius=\"0.5\" length=\"2\"/>", 2), Shape(Capsule{1, 4}));
  const Mesh mesh = std::get<Mesh>(shape_of("<mesh filename=\"b.obj\" scale=\"1 -1 2\"/>", 3));
  const Mesh plain = std::get<Mesh>(shape_of("<mesh filename=\"b.obj\" scale=\"3 -3 6\"/>", 1));
  EXPECT_EQ(mesh.mesh->vertices, plain.mesh->vertices);
  EXPECT_EQ(mesh.mesh->triangles, plain.mesh->triangles);
  EXPECT_EQ(mesh.watertight, plain.watertight);
}

TEST(Urdf, ScalesLinksThatAreNotNamedByTheOthersScale) {
  const std::string ball =
      testing::Ball("a") + testing::Ball("b") + JointText("j", "fixed", "a", "b", "");
  const auto robot = *ReadUrdf(Robot(ball), NoMeshes, {}, {}, {{"*", 2}, {"b", 3}});
  EXPECT_EQ(robot.links[0].collisions[0].shape, Shape(Sphere{0.2}));
  EXPECT_NEAR(std::get<Sphere>(robot.links[1].collisions[0].shape).radius_m, 0.3, kRounding);
}

TEST(Urdf, AJointThatFollowsAnUnknownOneMovesByItself) {
  const RobotDescription robot =
      Read(Links("ab") + JointText("j", "revolute", "a", "b",
                                   "<limit lower=\"-1\" upper=\"1\"/><mimic joint=\"x\"/>"));
  ASSERT_EQ(robot.joints.size(), 1u);
  EXPECT_FALSE(robot.joints[0].mimic);
  ASSERT_EQ(robot.left_out.size(), 1u);
  EXPECT_THAT(robot.left_out[0], HasSubstr("urdf: joint \"j\": mimic joint is \"x\""));
  EXPECT_THAT(robot.left_out[0], HasSubstr("moves by itself"));
}

TEST(Urdf, OfSeveralAxesTheFirstCounts) {
  const RobotDescription robot =
      Read(Links("ab") +
           JointText("j", "continuous", "a", "b", "<axis xyz=\"0 0 1\"/><axis xyz=\"0 1 0\"/>"));
  ASSERT_EQ(robot.joints.size(), 1u);
  EXPECT_EQ(robot.joints[0].axis_J, Vector3::UnitZ());
  EXPECT_THAT(robot.left_out,
              ElementsAre("urdf: joint \"j\": has 2 elements <axis>; the first counts, remove the "
                          "others"));
}

TEST(Urdf, ARobotWithoutANameIsCalledRobot) {
  const auto robot = ReadUrdf("<robot name=\"\"><link name=\"a\"/></robot>", NoMeshes);
  ASSERT_TRUE(robot.ok()) << robot.status();
  EXPECT_EQ(robot->name, "robot");
  EXPECT_EQ(robot->left_out.size(), 1u);
  EXPECT_FALSE(ReadUrdf("<robot><link name=\"a\"/></robot>", NoMeshes).ok()) << "no name at all";
}

TEST(Urdf, EndsBeforeTrailingZeroBytes) {
  const auto robot = ReadUrdf(Robot(Links("a")) + std::string(2, '\0'), NoMeshes);
  ASSERT_TRUE(robot.ok()) << robot.status();
  EXPECT_EQ(robot->links.size(), 1u);
  EXPECT_FALSE(ReadUrdf(std::string(3, '\0'), NoMeshes).ok());
  EXPECT_FALSE(ReadUrdf("", NoMeshes).ok());
}

TEST(Urdf, KeepsCollisionsInOrderWithTheirNamesAndLeavesVisualsOut) {
  const RobotDescription robot = Read(R"(<link name="a">
    <visual><geometry><mesh filename="package://never/read.stl"/></geometry></visual>
    <collision name="first"><geometry><sphere radius="1"/></geometry></collision>
    <inertial><mass value="garbage"/></inertial>
    <collision><geometry><sphere radius="2"/></geometry></collision></link>)");
  ASSERT_EQ(robot.links.size(), 1u);
  ASSERT_EQ(robot.links[0].collisions.size(), 2u);
  EXPECT_EQ(robot.links[0].collisions[0].name, "first");
  EXPECT_EQ(robot.links[0].collisions[1].name, "");
  EXPECT_EQ(robot.links[0].collisions[1].shape, Shape(Sphere{2}));
}

TEST(Urdf, TurnsByRollPitchYawAboutFixedAxesInThatOrder) {
  const CollisionGeometry geometry = ReadCollision(
      "<origin xyz=\"1 2 3\" rpy=\"0.3 -0.7 1.1\"/><geometry><sphere radius=\"1\"/></geometry>");
  // The matrix of the URDF documentation, Rz(yaw) Ry(pitch) Rx(roll), written out.
  const double cr = std::cos(0.3), sr = std::sin(0.3), cp = std::cos(-0.7), sp = std::sin(-0.7);
  const double cy = std::cos(1.1), sy = std::sin(1.1);
  Matrix3 R;
  R << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,  //
      sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,   //
      -sp, cp * sr, cp * cr;
  EXPECT_TRUE(geometry.X_LG.linear().isApprox(R, kRounding));
  EXPECT_EQ(geometry.X_LG.translation(), Vector3(1, 2, 3));
}

TEST(Urdf, LeavesWhatAnOriginDoesNotSayAtZero) {
  const char kSphere[] = "<geometry><sphere radius=\"1\"/></geometry>";
  EXPECT_TRUE(ReadCollision(kSphere).X_LG.isApprox(Pose::Identity(), 0));
  EXPECT_TRUE(ReadCollision(std::string("<origin/>") + kSphere).X_LG.isApprox(Pose::Identity(), 0));
  const Pose X = ReadCollision(std::string("<origin xyz=\"1 0 0\"/>") + kSphere).X_LG;
  EXPECT_TRUE(X.isApprox(MakeTranslation(1, 0, 0), 0));
}

TEST(Urdf, ReadsEveryKindOfJoint) {
  for (const JointKind kind : {JointKind::kFixed, JointKind::kRevolute, JointKind::kContinuous,
                               JointKind::kPrismatic, JointKind::kPlanar, JointKind::kFloating}) {
    const Joint joint = ReadJoint(std::string(NameOf(kind)),
                                  "<origin xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"2\"/>");
    EXPECT_EQ(joint.kind, kind);
    EXPECT_EQ(joint.name, "j");
    EXPECT_EQ(joint.parent, "a");
    EXPECT_EQ(joint.child, "b");
    EXPECT_EQ(joint.X_PJ.translation(), Vector3(0, 0, 1));
    const bool limited = kind == JointKind::kRevolute || kind == JointKind::kPrismatic;
    EXPECT_EQ(joint.limits.lower, limited ? std::optional<double>(-1) : std::nullopt);
    EXPECT_EQ(joint.limits.upper, limited ? std::optional<double>(2) : std::nullopt);
  }
}

TEST(Urdf, MakesAxesUnitsAndTakesXWhereNoneIsGiven) {
  const std::string limit = "<limit lower=\"0\" upper=\"1\"/>";
  EXPECT_EQ(ReadJoint("revolute", limit).axis_J, Vector3::UnitX());
  EXPECT_TRUE(ReadJoint("revolute", limit + "<axis xyz=\"0 3 4\"/>")
                  .axis_J.isApprox(Vector3(0, 0.6, 0.8), kRounding));
  for (const char* length : {"1e-300", "1e300"}) {
    EXPECT_TRUE(ReadJoint("prismatic", limit + "<axis xyz=\"0 0 -" + length + "\"/>")
                    .axis_J.isApprox(-Vector3::UnitZ(), kRounding))
        << length;
  }
}

TEST(Urdf, PassesOverAnAxisOfZeroWhereTheJointHasNone) {
  EXPECT_EQ(ReadJoint("fixed", "<axis xyz=\"0 0 0\"/>").kind, JointKind::kFixed);
  EXPECT_EQ(ReadJoint("floating", "<axis xyz=\"0 0 0\"/>").kind, JointKind::kFloating);
}

TEST(Urdf, ReadsVelocityAndEffortAndTakesZeroForALimitThatIsNotSaid) {
  const Joint joint = ReadJoint("revolute", "<limit upper=\"2\" velocity=\"2.5\" effort=\"87\"/>");
  EXPECT_EQ(joint.limits.lower, 0.0);
  EXPECT_EQ(joint.limits.upper, 2.0);
  EXPECT_EQ(joint.limits.max_velocity, 2.5);
  EXPECT_EQ(joint.limits.max_effort, 87.0);
  EXPECT_EQ(ReadJoint("continuous", "").limits.max_velocity, std::nullopt);
}

TEST(Urdf, ReadsMimicsAndPassesOverThatOfAFixedJoint) {
  const std::string limit = "<limit lower=\"-1\" upper=\"1\"/>";
  const RobotDescription robot =
      Read(Links("abcd") + JointText("j", "revolute", "a", "b") +
           JointText("k", "prismatic", "a", "c",
                     limit + "<mimic joint=\"j\" multiplier=\"-2\" offset=\"0.5\"/>") +
           JointText("l", "fixed", "a", "d", "<mimic joint=\"j\"/>"));
  ASSERT_EQ(robot.joints.size(), 3u);
  EXPECT_FALSE(robot.joints[0].mimic.has_value());
  ASSERT_TRUE(robot.joints[1].mimic.has_value());
  EXPECT_EQ(robot.joints[1].mimic->joint, "j");
  EXPECT_EQ(robot.joints[1].mimic->multiplier, -2);
  EXPECT_EQ(robot.joints[1].mimic->offset, 0.5);
  EXPECT_FALSE(robot.joints[2].mimic.has_value());
}

TEST(Urdf, ScalesMeshesAndKeepsOutsideOutWhereTheScaleMirrors) {
  const MeshSource box = [](std::string_view) {
    return absl::StatusOr<std::string>(testing::BinaryStl(BoxMesh({1, 2, 4})));
  };
  for (const auto& [scale, volume_m3] :
       {std::pair("1 1 1", 8.0), {"0.5 1 1", 4.0}, {"-1 1 1", 8.0}, {"-1 -1 -0.5", 4.0}}) {
    const CollisionGeometry geometry =
        ReadCollision(std::string("<geometry><mesh filename=\"package://p/box.stl\" scale=\"") +
                          scale + "\"/></geometry>",
                      box);
    const Mesh& mesh = std::get<Mesh>(geometry.shape);
    EXPECT_TRUE(mesh.watertight) << scale;
    EXPECT_EQ(SignedVolume_m3(*mesh.mesh), volume_m3) << scale;
  }
}

TEST(Urdf, AsksForEachMeshOnceAndSharesIt) {
  std::vector<std::string> requested;
  const MeshSource box = [&](std::string_view uri) {
    requested.emplace_back(uri);
    return absl::StatusOr<std::string>(testing::BinaryStl(BoxMesh({1, 1, 1})));
  };
  const auto collision = [](const std::string& uri, const std::string& scale) {
    return "<collision><geometry><mesh filename=\"" + uri + "\"" + scale +
           "/></geometry></collision>";
  };
  const RobotDescription robot =
      Read("<link name=\"a\">" + collision("x.stl", "") + collision("y.STL", "") +
               collision("x.stl", "") + collision("x.stl", " scale=\"2 2 2\"") + "</link>",
           box);
  EXPECT_THAT(requested, ElementsAre("x.stl", "y.STL"));
  const auto mesh = [&](int i) { return std::get<Mesh>(robot.links[0].collisions[i].shape).mesh; };
  EXPECT_EQ(mesh(0), mesh(2));
  EXPECT_NE(mesh(0), mesh(3));
  EXPECT_EQ(SignedVolume_m3(*mesh(3)), 8);
}

TEST(Urdf, TellsOpenMeshesFromClosedOnes) {
  const MeshSource open = [](std::string_view) {
    TriangleMesh mesh = BoxMesh({1, 1, 1});
    mesh.triangles.pop_back();
    return absl::StatusOr<std::string>(testing::Obj(mesh));
  };
  const CollisionGeometry geometry =
      ReadCollision("<geometry><mesh filename=\"file:///a.obj\"/></geometry>", open);
  EXPECT_FALSE(std::get<Mesh>(geometry.shape).watertight);
}

TEST(Urdf, TakesFiveHundredLinksInAnyOrder) {
  std::string links, joints;
  for (int i = 0; i < 500; ++i) {
    const std::string name = "link" + std::to_string(i);
    links = "<link name=\"" + name + "\"/>\n" + links;
    if (i == 0) continue;
    joints =
        JointText("j" + std::to_string(i), "continuous", "link" + std::to_string(i - 1), name, "") +
        joints;
  }
  const RobotDescription robot = Read(joints + links);
  EXPECT_EQ(robot.links.size(), 500u);
  EXPECT_EQ(robot.links.front().name, "link499");  // as in the file
  EXPECT_EQ(robot.joints.size(), 499u);
}

TEST(Urdf, TakesCommentsBeforeTheRootAndNamesBeyondAscii) {
  const auto robot = ReadUrdf(
      "<?xml version=\"1.0\"?><!-- <!DOCTYPE none> --><robot name=\"gr\xc3\xbc\xc3\x9f\">"
      "<link name=\"base link\"/></robot>",
      NoMeshes);
  ASSERT_TRUE(robot.ok()) << robot.status();
  EXPECT_EQ(robot->name, "gr\xc3\xbc\xc3\x9f");
  EXPECT_EQ(robot->links[0].name, "base link");
}

}  // namespace
}  // namespace cwm::collision
