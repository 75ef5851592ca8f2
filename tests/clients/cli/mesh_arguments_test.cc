#include "clients/cli/mesh_arguments.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "clients/formats/ply.h"
#include "clients/meshes/mesh_reading.h"
#include "tests/collision/mesh_files/mesh_bytes.h"

namespace cwm::cli {
namespace {

using collision::UpAxis;
using collision::testing::BinaryStl;
using collision::testing::BoxMesh;
using collision::testing::Collada;
using collision::testing::Glb;
using collision::testing::Obj;
using collision::testing::TextStl;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

// Exactly representable in single precision.
const Vector3 kSize_m(0.5, 0.25, 1);
const TriangleMesh kBox = BoxMesh(kSize_m);

std::string Ply(const TriangleMesh& mesh) {
  formats::MeshFile file;
  // A vertex for each corner of each triangle, as many writers do it.
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t v : triangle) {
      file.vertices.push_back({mesh.vertices[v].x(), mesh.vertices[v].y(), mesh.vertices[v].z()});
    }
    const auto end = static_cast<std::uint32_t>(file.vertices.size());
    file.triangles.push_back({end - 3, end - 2, end - 1});
  }
  return formats::FormatPlyMesh(file);
}

const std::pair<std::string, std::string> kFiles[] = {
    {"a.stl", BinaryStl(kBox)}, {"b.STL", TextStl(kBox)}, {"a.obj", Obj(kBox)},
    {"a.dae", Collada(kBox)},   {"a.glb", Glb(kBox)},     {"a.ply", Ply(kBox)},
};

std::string Refusal(const std::string& bytes, const std::string& file,
                    const MeshArguments& arguments = {}) {
  return std::string(ParseMeshFile(bytes, file, arguments).status().message());
}

TEST(ParseMeshFile, ReadsTheSameSolidFromEveryFormat) {
  for (const auto& [file, bytes] : kFiles) {
    EXPECT_TRUE(meshes::IsMesh(bytes, file)) << file;
    const auto mesh = ParseMeshFile(bytes, file, {.scale = 2, .up = UpAxis::kZ});
    ASSERT_TRUE(mesh.ok()) << mesh.status();
    EXPECT_EQ(mesh->vertices.size(), 8U) << file;
    EXPECT_TRUE(IsWatertight(*mesh)) << file;
    EXPECT_EQ(SignedVolume_m3(*mesh), 8 * kSize_m.prod()) << file;
  }
}

TEST(ParseMeshFile, TurnsWhatTheFileCallsUp) {
  const auto height = [](const std::string& bytes, const std::string& file) {
    const auto mesh = ParseMeshFile(bytes, file, {});
    EXPECT_TRUE(mesh.ok()) << mesh.status();
    double highest_m = 0;
    for (const Vector3& p : mesh->vertices) highest_m = std::max(highest_m, p.z());
    return highest_m;
  };
  EXPECT_EQ(height(Glb(kBox), "a.glb"), kSize_m.y());
  EXPECT_EQ(height(Glb(kBox), "named_otherwise"), kSize_m.y());
  EXPECT_EQ(height(Collada(kBox, {.up_axis = "X_UP"}), "a.dae"), kSize_m.x());
  EXPECT_EQ(height(Collada(kBox), "a.dae"), kSize_m.z());
  EXPECT_EQ(height(BinaryStl(kBox), "a.stl"), kSize_m.z());
  EXPECT_EQ(height(Ply(kBox), "a.ply"), kSize_m.z());
}

TEST(ParseMeshFile, NamesTheFileAndTheRuleOfWhatItRefuses) {
  EXPECT_EQ(
      Refusal("1 2 3\n", "a.xyz"),
      "a.xyz: the ending is .xyz, must be .stl, .obj, .dae, .glb or .ply, where it is a mesh");
  EXPECT_EQ(Refusal("", "a.stl"), "a.stl: must not be empty");
  EXPECT_EQ(Refusal("v 0 0 0\nv 1 0\n", "dir/a.obj"),
            "dir/a.obj: line 2: a vertex must have three numbers");
  EXPECT_THAT(Refusal("ply\nformat ascii 1.0\n", "a.ply"), StartsWith("a.ply: "));
  EXPECT_THAT(Refusal(std::string("glTF\2\0\0\0", 8), "a.glb"), StartsWith("a.glb: "));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double scale : {0., -1., nan, std::numeric_limits<double>::infinity()}) {
    EXPECT_THAT(Refusal(BinaryStl(kBox), "a.stl", {.scale = scale}),
                AllOf(HasSubstr("--scale is "), HasSubstr("must be above 0")));
  }
  EXPECT_EQ(Refusal("v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n", "a.obj", {.scale = 1e308}),
            "a.obj: vertices must be finite after --scale 1e+308");
}

// Any input gives a mesh or an error that begins with the file's name.
TEST(ParseMeshFile, ReadsOrRefusesFilesWithBytesChangedAtRandom) {
  std::mt19937 random(5);
  for (const auto& [file, bytes] : kFiles) {
    for (int round = 0; round < 200; ++round) {
      std::string changed = bytes;
      for (int i = 0; i < 1 + round % 5; ++i) {
        changed[random() % changed.size()] = static_cast<char>(random() % 256);
      }
      if (round % 10 == 0) changed.resize(random() % changed.size());
      const auto mesh = ParseMeshFile(changed, file, {});
      if (!mesh.ok()) {
        ASSERT_THAT(std::string(mesh.status().message()), StartsWith(file + ": "));
        continue;
      }
      for (const auto& triangle : mesh->triangles) {
        for (const std::uint32_t v : triangle) ASSERT_LT(v, mesh->vertices.size());
      }
    }
  }
}

TEST(SizeWarning, IsForWhatMustBeInMillimetres) {
  EXPECT_EQ(SizeWarning(kBox, "a.stl"), std::nullopt);
  EXPECT_EQ(SizeWarning(BoxMesh({95, 80, 0.5}), "cup.stl"),
            "cup.stl: 95 m long, coordinates are metres: are these millimetres? --scale 0.001");
}

}  // namespace
}  // namespace cwm::cli
