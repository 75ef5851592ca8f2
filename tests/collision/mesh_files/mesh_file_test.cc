#include "collision/mesh_files/mesh_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "tests/collision/mesh_files/mesh_bytes.h"

namespace cwm::collision {
namespace {

using testing::BinaryStl;
using testing::BoxMesh;
using testing::Collada;
using testing::Glb;
using testing::Obj;
using testing::TextStl;

// derived: files have single precision, 2^-24 of a coordinate, and rotated nodes add another
// rounding.
constexpr double kRounding_m = 2 * 0x1p-24;

const Vector3 kSize_m(0.5, 0.25, 1);  // exact in single precision
const double kVolume_m3 = kSize_m.prod();

Eigen::AlignedBox3d BoundsOf(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d bounds;
  for (const Vector3& p : mesh.vertices) bounds.extend(p);
  return bounds;
}

TEST(MeshFile, ReadsEveryFormatAsTheSameClosedOutwardSolid) {
  const TriangleMesh box = BoxMesh(kSize_m);
  const std::map<std::string, std::string> files = {
      {"binary.stl", BinaryStl(box)},  {"text.STL", TextStl(box)},
      {"package://a/b.obj", Obj(box)}, {"file:///x/part.dae", Collada(box)},
      {"part.glb", Glb(box)},
  };
  for (const auto& [name, bytes] : files) {
    const auto mesh = ReadMeshFile(bytes, name);
    ASSERT_TRUE(mesh.ok()) << name << ": " << mesh.status();
    EXPECT_EQ(mesh->vertices.size(), 8u) << name;
    EXPECT_EQ(mesh->triangles.size(), 12u) << name;
    EXPECT_TRUE(IsWatertight(*mesh)) << name;
    EXPECT_NEAR(SignedVolume_m3(*mesh), kVolume_m3, kRounding_m) << name;
    EXPECT_EQ(BoundsOf(*mesh).min(), Vector3::Zero()) << name;
    EXPECT_EQ(BoundsOf(*mesh).max(), kSize_m) << name;
  }
}

TEST(MeshFile, TakesABinaryStlWhoseHeaderBeginsLikeText) {
  std::string bytes = BinaryStl(BoxMesh(kSize_m));
  bytes.replace(0, 5, "solid");
  const auto mesh = ReadMeshFile(bytes, "part.stl");
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(mesh->triangles.size(), 12u);
}

TEST(MeshFile, KeepsAnOpenMeshOpen) {
  TriangleMesh box = BoxMesh(kSize_m);
  box.triangles.pop_back();
  const auto mesh = ReadMeshFile(BinaryStl(box), "part.stl");
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(mesh->triangles.size(), 11u);
  EXPECT_FALSE(IsWatertight(*mesh));
}

TEST(MeshFile, DropsTrianglesThatUseAPlaceTwiceAndKeepsSlivers) {
  TriangleMesh mesh = BoxMesh(kSize_m);
  mesh.triangles.push_back({3, 3, 7});
  const Vector3 middle = (mesh.vertices[1] + mesh.vertices[2]) / 2;
  mesh.vertices.push_back(middle);
  mesh.triangles[0] = {0, 2, 8};  // the diagonal of the face is split on one side only
  mesh.triangles.push_back({0, 8, 1});
  mesh.triangles.push_back({8, 2, 1});  // closes the gap without an area
  const auto read = ReadMeshFile(BinaryStl(mesh), "part.stl");
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->triangles.size(), 14u);
  EXPECT_TRUE(IsWatertight(*read));
}

double AreaOf(const TriangleMesh& mesh) {
  double area_m2 = 0;
  for (const auto& t : mesh.triangles) {
    const Vector3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    area_m2 += (b - a).cross(c - a).norm() / 2;
  }
  return area_m2;
}

TEST(MeshFile, CutsPolygonsIntoTrianglesThatCoverThem) {
  // A square with a notch to its centre, starting at the corner beside the notch; a fan would leave
  // the square.
  const auto mesh = ReadMeshFile(
      "v 2 2 1\nv 1 1 1\nv 0 2 1\nv 0 0 1\nv 2 0 1\nf -5 -4/1 -3//1 -2/1/1 -1 # notch\n",
      "notch.obj");
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(mesh->triangles.size(), 3u);
  EXPECT_NEAR(AreaOf(*mesh), 3, 1e-12);
  for (const auto& t : mesh->triangles) {
    const Vector3 &a = mesh->vertices[t[0]], &b = mesh->vertices[t[1]], &c = mesh->vertices[t[2]];
    EXPECT_GT((b - a).cross(c - a).z(), 0);  // oriented like the polygon
  }
}

TEST(MeshFile, JoinsLinesOfAnObjThatGoOn) {
  const auto mesh = ReadMeshFile("v 0 0 \\\r\n0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 \\\n3", "a.obj");
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(mesh->triangles.size(), 1u);
}

TEST(MeshFile, LeavesLinesAndPointsOut) {
  const auto mesh =
      ReadMeshFile("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 9 9 9\nf 1 2 3\nl 1 4\np 4\n", "part.obj");
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(mesh->triangles.size(), 1u);
  EXPECT_EQ(mesh->vertices.size(), 3u);
}

TEST(MeshFile, AppliesTheUnitOfAColladaFileAndTurnsNoAxisUp) {
  for (const char* up : {"X_UP", "Y_UP", "Z_UP"}) {
    const auto mesh =
        ReadMeshFile(Collada(BoxMesh(kSize_m * 1000), {.unit_m = "0.001", .up_axis = up}), "a.dae");
    ASSERT_TRUE(mesh.ok()) << up << ": " << mesh.status();
    EXPECT_TRUE(BoundsOf(*mesh).max().isApprox(kSize_m, 2 * kRounding_m)) << up;
  }
}

TEST(UpAxis, IsWhatAColladaFileSaysAndYOfGlb) {
  const TriangleMesh box = BoxMesh(kSize_m);
  EXPECT_EQ(UpAxisOf(Glb(box), "a.GLB").value(), UpAxis::kY);
  EXPECT_EQ(UpAxisOf(Obj(box), "a.obj").value(), UpAxis::kZ);
  EXPECT_EQ(UpAxisOf(Collada(box, {.up_axis = "X_UP"}), "a.dae").value(), UpAxis::kX);
  EXPECT_EQ(UpAxisOf(Collada(box, {.up_axis = " Y_UP\n"}), "a.dae").value(), UpAxis::kY);
  EXPECT_EQ(UpAxisOf(Collada(box, {.up_axis = "Z_UP"}), "a.dae").value(), UpAxis::kZ);
  EXPECT_EQ(UpAxisOf("<COLLADA/>", "a.dae").value(), UpAxis::kY);
  EXPECT_FALSE(UpAxisOf("not xml", "a.dae").ok());
  EXPECT_EQ(std::string(UpAxisOf(Collada(box, {.up_axis = "UP"}), "a.dae").status().message()),
            "Collada: asset: up_axis: holds \"UP\", must be X_UP, Y_UP or Z_UP");
}

// From the drawing in Collada's specification: Y_UP looks along -z with x to the right, X_UP along
// -z with y to the left.
TEST(UpAxis, IsTurnedToZWithoutMirroring) {
  const TriangleMesh axes{.vertices = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .triangles = {{0, 1, 2}}};
  using Vertices = std::vector<Vector3>;
  EXPECT_EQ(RotateToZUp(UpAxis::kZ, axes).vertices, axes.vertices);
  EXPECT_EQ(RotateToZUp(UpAxis::kY, axes).vertices, (Vertices{{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}));
  EXPECT_EQ(RotateToZUp(UpAxis::kX, axes).vertices, (Vertices{{0, 0, 1}, {-1, 0, 0}, {0, -1, 0}}));
  for (const UpAxis up : {UpAxis::kX, UpAxis::kY, UpAxis::kZ}) {
    EXPECT_NEAR(SignedVolume_m3(RotateToZUp(up, BoxMesh(kSize_m))), kVolume_m3, 1e-15);
  }
}

TEST(MeshFile, AppliesTheTransformsOfNodesBelowEachOther) {
  // Scaled by a half, then translated: the inner node acts first.
  const char kNodes[] =
      "<node id=\"a\"><matrix>1 0 0 2 0 1 0 0 0 0 1 0 0 0 0 1</matrix><node id=\"b\"><matrix>"
      "0.5 0 0 0 0 0.5 0 0 0 0 0.5 0 0 0 0 1</matrix><instance_geometry url=\"#part\"/></node>"
      "</node>";
  const auto mesh = ReadMeshFile(Collada(BoxMesh(kSize_m), {.scene_nodes = kNodes}), "a.dae");
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(BoundsOf(*mesh).min(), Vector3(2, 0, 0));
  EXPECT_EQ(BoundsOf(*mesh).max(), Vector3(2, 0, 0) + kSize_m / 2);
}

TEST(MeshFile, KeepsOutsideOutWhereANodeMirrors) {
  const auto mesh = ReadMeshFile(
      Collada(BoxMesh(kSize_m), {.matrix = "-1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"}), "a.dae");
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(BoundsOf(*mesh).min().x(), -kSize_m.x());
  EXPECT_NEAR(SignedVolume_m3(*mesh), kVolume_m3, kRounding_m);
}

TEST(MeshFile, JoinsPartsThatSeveralNodesPlaceSideBySide) {
  const auto two = ReadMeshFile(
      Glb(testing::GlbJson(BoxMesh(kSize_m), R"([{"mesh":0},{"mesh":0,"translation":[4,0,0]}])",
                           "[0,1]"),
          testing::GlbBinary(BoxMesh(kSize_m))),
      "two.glb");
  ASSERT_TRUE(two.ok()) << two.status();
  EXPECT_EQ(two->triangles.size(), 24u);
  EXPECT_EQ(BoundsOf(*two).max().x(), 4 + kSize_m.x());
  EXPECT_EQ(ComponentPoints(*two).size(), 2u);
}

TEST(MeshFile, TakesColladaNodesThatAreUsedTwice) {
  const auto mesh = ReadMeshFile(
      Collada(BoxMesh(kSize_m),
              {.scene_nodes = "<node id=\"a\"><instance_node url=\"#l\"/></node><node id=\"b\">"
                              "<translate>3 0 0</translate><instance_node url=\"#l\"/></node>",
               .library_nodes = "<node id=\"l\"><instance_geometry url=\"#part\"/></node>"}),
      "a.dae");
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(mesh->triangles.size(), 24u);
}

}  // namespace
}  // namespace cwm::collision
