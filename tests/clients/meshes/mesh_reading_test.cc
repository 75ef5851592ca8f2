#include "clients/meshes/mesh_reading.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "clients/formats/file_bytes.h"
#include "clients/formats/ply.h"
#include "tests/support/process.h"

namespace cwm::meshes {
namespace {

using ::testing::HasSubstr;
using testing::ScratchDirectory;

// A tetrahedron with a right angle at the origin and legs of 1 m has a sixth of a cubic metre.
constexpr double kVolume_m3 = 1.0 / 6;
constexpr const char* kObj =
    "# a tetrahedron\n"
    "o tetrahedron\n"
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    "vn 0 0 1\n"
    "f 1 3 2\nf 1/1 2/1 4/1\nf 1//1 4//1 3//1\nf -3/1/1 -2/1/1 -1/1/1\n";

struct Facet {
  float normal[3];
  float corners[3][3];
};
constexpr Facet kFacets[] = {{{0, 0, -1}, {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}}},
                             {{0, -1, 0}, {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}}},
                             {{-1, 0, 0}, {{0, 0, 0}, {0, 0, 1}, {0, 1, 0}}},
                             {{1, 1, 1}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};

std::string BinaryStl() {
  std::string bytes(80, ' ');
  bytes.replace(0, 5, "solid");  // some writers begin binary files like this, too
  const std::uint32_t count = 4;
  bytes.append(reinterpret_cast<const char*>(&count), sizeof count);
  for (const Facet& facet : kFacets) {
    bytes.append(reinterpret_cast<const char*>(&facet), sizeof facet);
    bytes.append(2, '\0');
  }
  return bytes;
}

std::string TextStl() {
  std::string text = "solid tetrahedron of mine\n";
  for (const Facet& facet : kFacets) {
    text += "  facet normal 0 0 0\n    outer loop\n";
    for (const auto& corner : facet.corners) {
      text += "      vertex " + std::to_string(corner[0]) + " " + std::to_string(corner[1]) + " " +
              std::to_string(corner[2]) + "\n";
    }
    text += "    endloop\n  endfacet\n";
  }
  return text + "endsolid tetrahedron of mine\n";
}

std::string Ply() {
  return formats::FormatPlyMesh({.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                 .triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}});
}

absl::StatusOr<TriangleMesh> ReadBytes(const std::string& name, const std::string& bytes) {
  const ScratchDirectory scratch;
  const std::string path = scratch / name;
  if (absl::Status status = formats::WriteFileBytes(path, bytes); !status.ok()) return status;
  return ReadMesh(path);
}

TEST(ReadMesh, ReadsTheSameSolidFromEveryFormat) {
  for (const auto& [name, bytes] : {std::pair<std::string, std::string>{"a.obj", kObj},
                                    {"a.stl", BinaryStl()},
                                    {"a.STL", TextStl()},
                                    {"a.ply", Ply()}}) {
    const auto mesh = ReadBytes(name, bytes);
    ASSERT_TRUE(mesh.ok()) << mesh.status();
    EXPECT_EQ(mesh->vertices.size(), 4U) << name;
    EXPECT_TRUE(IsWatertight(*mesh)) << name;
    EXPECT_NEAR(SignedVolume_m3(*mesh), kVolume_m3, 1e-12) << name;
  }
}

TEST(ReadMesh, LeavesOutTrianglesThatCollapse) {
  const auto mesh = ReadBytes("a.obj", std::string(kObj) + "v 0 0 0\nf 1 5 2\n");
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(mesh->triangles.size(), 4U);
}

TEST(ReadMesh, RefusesBrokenFilesByLineFieldAndRule) {
  struct Case {
    std::string name, bytes, says;
  };
  const std::string text_stl = TextStl();
  const std::string four_corners =
      std::string(text_stl).insert(text_stl.find("    endloop"), "      vertex 0 0 0\n");
  for (const Case& broken : {
           Case{"a.obj", "v 0 0 0\nv 1 0\n", "a.obj: line 2: a vertex must have three numbers"},
           Case{"a.obj", "v 0 x 0\n", "a.obj: line 1: a vertex must have three numbers"},
           Case{"a.obj", "v 0 0 0\nf 1 2 3\n",
                "line 2: corner \"2\" must be one of the 1 vertices"},
           Case{"a.obj", "", "a.obj: must not be empty"},
           Case{"a.stl", "solid x\nfacet\nvertex 0 0 0\nendfacet\nendsolid\n",
                "a.stl: line 4: must be part of a facet with three vertices"},
           Case{"a.stl", four_corners, "a.stl: line 7: must be one of three of a facet"},
           Case{"a.stl", BinaryStl().substr(0, 200), "a.stl: must have triangles"},
           Case{"a.ply", "ply\n", "a.ply"},
           Case{"a.dae", "<xml>", "a.dae: Collada: line 1"},
           Case{"a.fbx", "Kaydara", "the ending is .fbx, must be .stl, .obj, .dae, .glb or .ply"},
       }) {
    const auto mesh = ReadBytes(broken.name, broken.bytes);
    EXPECT_EQ(mesh.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(mesh.status().message()), HasSubstr(broken.says));
  }
  EXPECT_FALSE(ReadMesh("no/such/mesh.ply").ok());
}

}  // namespace
}  // namespace cwm::meshes
