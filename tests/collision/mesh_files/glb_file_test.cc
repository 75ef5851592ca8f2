// GLB files beyond the features that all formats share: modes, transforms, refusals.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "collision/mesh_files/mesh_file.h"
#include "tests/collision/mesh_files/mesh_bytes.h"

namespace cwm::collision {
namespace {

using testing::BoxMesh;
using testing::Glb;
using testing::GlbBinary;
using testing::GlbJson;
using ::testing::HasSubstr;

const TriangleMesh kBox = BoxMesh({1, 1, 1});

absl::StatusOr<TriangleMesh> ReadBoxWith(const std::string& from, const std::string& to) {
  const std::string json = GlbJson(kBox);
  EXPECT_THAT(json, HasSubstr(from));
  return ReadMeshFile(Glb(absl::StrReplaceAll(json, {{from, to}}), GlbBinary(kBox)), "a.glb");
}

std::string RefusalWith(const std::string& from, const std::string& to) {
  const auto mesh = ReadBoxWith(from, to);
  return mesh.ok() ? "" : std::string(mesh.status().message());
}

// Reads the first `count` indices of 0, 1, 2, ... in the given mode, or, if `indices` is false, the
// vertices without indices.
absl::StatusOr<TriangleMesh> ReadInMode(int mode, int count, bool indices = true) {
  TriangleMesh mesh;
  for (int i = 0; i < 12; ++i) mesh.vertices.emplace_back(i / 2, i % 2, 0);  // a band
  for (std::uint32_t i = 0; i < 12; i += 3) mesh.triangles.push_back({i, i + 1, i + 2});
  const std::string list =
      indices ? absl::StrCat("\"indices\":1,\"mode\":", mode) : absl::StrCat("\"mode\":", mode);
  const std::string json = absl::StrReplaceAll(
      GlbJson(mesh), {{"\"indices\":1", list},
                      {"\"count\":12,\"type\":\"SCALAR\"",
                       absl::StrCat("\"count\":", count, ",\"type\":\"SCALAR\"")},
                      {"\"count\":12,\"type\":\"VEC3\"",
                       absl::StrCat("\"count\":", indices ? 12 : count, ",\"type\":\"VEC3\"")}});
  return ReadMeshFile(Glb(json, GlbBinary(mesh)), "a.glb");
}

double UpwardArea(const TriangleMesh& mesh) {
  double area = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vector3& p = mesh.vertices[a];
    area += (mesh.vertices[b] - p).cross(mesh.vertices[c] - p).z() / 2;
  }
  return area;
}

// All triangles of a strip along the band of 5 squares have the same orientation only if every
// second one is reversed, as section 3.7.2.1 says.
TEST(GlbFile, ReadsStripsWithEverySecondTriangleTurnedRound) {
  for (const bool indices : {true, false}) {
    const auto strip = ReadInMode(5, 12, indices);
    ASSERT_TRUE(strip.ok()) << strip.status();
    EXPECT_EQ(strip->triangles.size(), 10u);
    EXPECT_EQ(UpwardArea(*strip), -5);
  }
}

// A fan around the band's first corner.
TEST(GlbFile, ReadsFansAroundTheirFirstCorner) {
  const auto fan = ReadInMode(6, 4);
  ASSERT_TRUE(fan.ok()) << fan.status();
  EXPECT_EQ(fan->triangles.size(), 2u);
  EXPECT_EQ(fan->vertices[fan->triangles[0][0]], Vector3(0, 0, 0));
  EXPECT_EQ(fan->vertices[fan->triangles[1][0]], Vector3(0, 0, 0));
  EXPECT_EQ(UpwardArea(*fan), -0.5 + 0.5);  // (0 0, 0 1, 1 0) down, (0 0, 1 0, 1 1) up
}

TEST(GlbFile, RefusesPrimitivesOfTooFewCorners) {
  for (const bool indices : {true, false}) {
    for (const int mode : {5, 6}) {
      for (const int count : {1, 2}) {
        const auto mesh = ReadInMode(mode, count, indices);
        EXPECT_EQ(mesh.status().message(),
                  absl::StrCat("a primitive has ", count, " corners, must have at least 3"));
      }
      EXPECT_TRUE(ReadInMode(mode, 3, indices).ok());
    }
    for (const int count : {1, 2, 4, 11}) {
      const auto mesh = ReadInMode(4, count, indices);
      EXPECT_EQ(mesh.status().message(),
                absl::StrCat("a primitive has ", count, " corners, must have a multiple of 3"));
    }
  }
}

TEST(GlbFile, AppliesTheTransformsOfNodesInTheStandardsOrder) {
  // Scaled by 2 along x, rotated by 90 degrees about z, then translated: x becomes y.
  const std::string half = absl::StrCat(std::sqrt(0.5));
  const std::string parts = absl::StrCat(R"([{"mesh":0,"translation":[5,6,7],"rotation":[0,0,)",
                                         half, ",", half, R"(],"scale":[2,1,1]}])");
  const std::string matrix =
      R"([{"mesh":0,"matrix":[0,2,0,0,-1,0,0,0,0,0,1,0,5,6,7,1]}])";  // the same, column-major
  for (const std::string& nodes : {parts, matrix}) {
    const auto mesh = ReadMeshFile(Glb(GlbJson(kBox, nodes), GlbBinary(kBox)), "a.glb");
    ASSERT_TRUE(mesh.ok()) << mesh.status();
    Eigen::AlignedBox3d bounds;
    for (const Vector3& p : mesh->vertices) bounds.extend(p);
    EXPECT_TRUE(bounds.min().isApprox(Vector3(4, 6, 7), 1e-6)) << bounds.min().transpose();
    EXPECT_TRUE(bounds.max().isApprox(Vector3(5, 8, 8), 1e-6)) << bounds.max().transpose();
    EXPECT_NEAR(SignedVolume_m3(*mesh), 2, 1e-6);
  }
}

TEST(GlbFile, KeepsOutsideOutWhereANodeMirrors) {
  const auto mesh = ReadMeshFile(
      Glb(GlbJson(kBox, R"([{"children":[1],"scale":[-1,1,1]},{"mesh":0}])"), GlbBinary(kBox)),
      "a.glb");
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_NEAR(SignedVolume_m3(*mesh), 1, 1e-6);
}

TEST(GlbFile, ReadsTheSceneThatIsToBeShownAndNothingElse) {
  const auto mesh = ReadBoxWith(
      R"("scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[)",
      R"("scene":1,"scenes":[{"nodes":[1]},{"nodes":[0]}],"nodes":[{"mesh":0},{"mesh":1}],)"
      R"("images":[{"uri":"../x.png"}],"cameras":7,"skins":[{}],"animations":[{"channels":[{}]}],)"
      R"("meshes":[)");
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(mesh->triangles.size(), 12u);
}

TEST(GlbFile, RefusesWhatWouldPutSurfacesElsewhere) {
  EXPECT_EQ(RefusalWith(R"({"mesh":0})", R"({"mesh":0,"skin":0})"), "skins are not understood");
  EXPECT_THAT(RefusalWith(R"("indices":1)", R"("indices":1,"targets":[])"),
              HasSubstr("without morph targets"));
  EXPECT_THAT(RefusalWith(R"("scene":0)",
                          R"("extensionsRequired":["KHR_draco_mesh_compression"],"scene":0)"),
              HasSubstr("KHR_draco_mesh_compression"));
  EXPECT_THAT(
      RefusalWith(R"("scene":0)", R"("extensionsUsed":["EXT_mesh_gpu_instancing"],"scene":0)"),
      HasSubstr("EXT_mesh_gpu_instancing"));
  EXPECT_EQ(
      RefusalWith(R"("scene":0)", R"("extensionsRequired":["KHR_materials_unlit"],"scene":0)"), "");
}

TEST(GlbFile, RefusesNumbersThatAreNotWhatTheyMustBe) {
  EXPECT_THAT(RefusalWith(R"({"mesh":0})", R"({"mesh":0,"translation":[0,0]})"),
              HasSubstr("the translation of a node must be 3 finite numbers"));
  EXPECT_THAT(RefusalWith(R"({"mesh":0})", R"({"mesh":0,"scale":[1,"1",1]})"),
              HasSubstr("3 finite"));
  EXPECT_THAT(RefusalWith(R"({"mesh":0})", R"({"mesh":0,"rotation":[0,0,0,0]})"),
              HasSubstr("must be a unit quaternion"));
  EXPECT_THAT(
      RefusalWith(R"({"mesh":0})", R"({"mesh":0,"matrix":[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]})"),
      HasSubstr("last row 0 0 0 1"));
  EXPECT_THAT(RefusalWith(R"({"mesh":0})", R"({"mesh":1})"), HasSubstr("meshes that there are"));
  EXPECT_THAT(RefusalWith(R"({"mesh":0})", R"({"mesh":-1})"), HasSubstr("meshes that there are"));
  EXPECT_THAT(RefusalWith(R"({"mesh":0})", R"({"mesh":0,"children":7})"),
              HasSubstr("must be a list"));
  EXPECT_THAT(RefusalWith(R"([{"mesh":0}])", R"([7])"), HasSubstr("must be a JSON object"));
  EXPECT_THAT(RefusalWith(R"("scene":0)", R"("scene":1)"), HasSubstr("scene that is to be shown"));
  EXPECT_THAT(RefusalWith(R"("indices":1)", R"("indices":0)"), HasSubstr("unsigned integers"));
  EXPECT_THAT(RefusalWith(R"("componentType":5125)", R"("componentType":5126)"),
              HasSubstr("unsigned integers"));
  EXPECT_THAT(RefusalWith(R"("indices":1)", R"("indices":9)"), HasSubstr("unsigned integers"));
  for (const char* stride : {"0", "2", "253", "4000000000", "-4", "\"12\""}) {
    EXPECT_THAT(RefusalWith(R"("byteLength":96})",
                            absl::StrCat(R"("byteLength":96,"byteStride":)", stride, "}")),
                HasSubstr("accessor"))
        << stride;
  }
  EXPECT_THAT(RefusalWith(R"("byteOffset":0,)", R"("byteOffset":4294967295,)"),
              HasSubstr("bufferView"));
}

}  // namespace
}  // namespace cwm::collision
