// Small files that would become large, or take long. The size of the result is limited by the size
// of the file before it is allocated.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ctime>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "collision/mesh_files/mesh_file.h"
#include "tests/collision/mesh_files/expanding_collada.h"
#include "tests/collision/mesh_files/mesh_bytes.h"

namespace cwm::collision {
namespace {

using testing::BoxMesh;
using testing::Collada;
using testing::ExpandingCollada;
using testing::Glb;
using testing::GlbBinary;
using testing::GlbJson;
using ::testing::HasSubstr;

// chosen: each of the files below takes minutes, or all memory, without the limit that it tests,
// and some milliseconds with it; under sanitizers and on a busy machine still less than this.
constexpr double kMaxProcessor_s = 10;

class MeshExpansion : public ::testing::Test {
 protected:
  void TearDown() override {
    EXPECT_LT(static_cast<double>(std::clock() - start_) / CLOCKS_PER_SEC, kMaxProcessor_s);
  }

  static absl::Status Refusal(const std::string& bytes, const std::string& name) {
    return ReadMeshFile(bytes, name).status();
  }

 private:
  std::clock_t start_ = std::clock();
};

std::string Repeated(const std::string& text, int times) {
  std::string repeated;
  for (int i = 0; i < times; ++i) repeated += text;
  return repeated;
}

TEST_F(MeshExpansion, ColladaNodesThatUseAGeometryThousandsOfTimesAreRefused) {
  const std::string bytes = ExpandingCollada();
  EXPECT_LT(bytes.size(), 3'320u);
  const absl::Status status = Refusal(bytes, "a.dae");
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(status.message(),
            absl::StrCat("must have at most ", 12'000 + bytes.size() / 4,
                         " triangles: 12000 and one for each 4 of its ", bytes.size(), " bytes"));
}

TEST_F(MeshExpansion, GlbNodesThatUseAMeshThousandsOfTimesAreRefused) {
  const TriangleMesh box = BoxMesh({1, 1, 1});
  std::string nodes = "[";
  for (int i = 1; i <= 15; ++i) absl::StrAppend(&nodes, "{\"children\":[", i, ",", i, "]},");
  const std::string bytes = Glb(GlbJson(box, nodes + "{\"mesh\":0}]"), GlbBinary(box));
  const absl::Status status = Refusal(bytes, "a.glb");
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(status.message()), HasSubstr("one for each 4 of its"));
}

TEST_F(MeshExpansion, GlbPrimitivesThatShareTheirIndicesAreCountedEach) {
  TriangleMesh box = BoxMesh({1, 1, 1});
  for (int i = 0; i < 20; ++i) {
    for (int k = 0; k < 12; ++k) box.triangles.push_back(box.triangles[k]);
  }
  const std::string primitive = R"({"attributes":{"POSITION":0},"indices":1})";
  const std::string primitives = Repeated(primitive + ",", 2000) + primitive;
  const std::string bytes =
      Glb(absl::StrReplaceAll(GlbJson(box), {{primitive, primitives}}), GlbBinary(box));
  EXPECT_EQ(Refusal(bytes, "a.glb").code(), absl::StatusCode::kResourceExhausted);
}

TEST_F(MeshExpansion, FacesOfTwoBytesATriangleAreRefused) {
  const std::string face = "f" + Repeated(" 1 2 3", 20) + "\n";
  const absl::Status status =
      Refusal("v 0 0 0\nv 1 0 0\nv 0 1 0\n" + Repeated(face, 2000), "a.obj");
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(status.message()), HasSubstr("one for each 4 of its"));
}

// The work of ear clipping is the square of the corners: here 4096 squared per 20 kB.
TEST_F(MeshExpansion, ManyFacesOfManyCornersAreRefused) {
  std::string text, face = "f";
  for (int i = 0; i < 4096; ++i) {  // a comb: simple, and every second corner is blunt
    absl::StrAppend(&text, "v ", i, " ", i % 2 == 0 ? 5000 - i : 0, " ", 0, "\n");
    absl::StrAppend(&face, " ", i + 1);
  }
  const absl::Status status = Refusal(text + Repeated(face + "\n", 400), "a.obj");
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(status.message()), HasSubstr("so many faces of so many corners"));
}

std::string ColladaWithPrimitives(const std::string& primitives) {
  const std::string collada = Collada(BoxMesh({1, 1, 1}));
  const std::size_t begin = collada.find("<triangles"), end = collada.find("</mesh>");
  return collada.substr(0, begin) + primitives + collada.substr(end);
}

constexpr char kVertexInput[] = "<input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>";

// The counts would take the product of the lengths of both lists if they were kept.
TEST_F(MeshExpansion, ColladaPolylistsWithoutCornersAreRefused) {
  const std::string list =
      absl::StrCat("<polylist>", kVertexInput, "<vcount>", Repeated("0 ", 100'000), "</vcount>",
                   Repeated("<p/>", 100'000), "</polylist>");
  EXPECT_THAT(std::string(Refusal(ColladaWithPrimitives(list), "a.dae").message()),
              HasSubstr("3 to 4096 corners"));
}

TEST_F(MeshExpansion, ColladaPositionsAreReadOnceForAllPrimitives) {
  const std::string primitive = absl::StrCat("<triangles>", kVertexInput, "</triangles>");
  const std::string bytes =
      absl::StrReplaceAll(ColladaWithPrimitives(Repeated(primitive, 20'000)),
                          {{"</float_array>", Repeated("0 ", 200'000) + "</float_array>"}});
  EXPECT_EQ(std::string(Refusal(bytes, "a.dae").message()), "must have triangles");
}

TEST_F(MeshExpansion, ColladaTransformsThatAreReadOftenMustBeShort) {
  const std::string library =
      absl::StrCat("<node id=\"l\"><matrix>", Repeated("0 ", 1500), "</matrix></node>");
  const std::string bytes = Collada(
      BoxMesh({1, 1, 1}),
      {.scene_nodes = "<node><instance_node url=\"#l\"/></node>", .library_nodes = library});
  EXPECT_THAT(std::string(Refusal(bytes, "a.dae").message()),
              HasSubstr("bytes long, must be at most 2048"));
}

TEST_F(MeshExpansion, ElementsWithVeryManyAttributesAreRefused) {
  std::string node = "<node";
  for (int i = 0; i < 300'000; ++i) absl::StrAppend(&node, " a", i, "=\"\"");
  EXPECT_THAT(
      std::string(
          Refusal(Collada(BoxMesh({1, 1, 1}), {.scene_nodes = node + "/>"}), "a.dae").message()),
      HasSubstr("must have at most 32 attributes in an element"));
}

// Formerly each child stored the places of all elements above it: 7 kB for each 4 bytes.
TEST_F(MeshExpansion, DeepElementsWithManyChildrenTakeNoMoreThanFlatOnes) {
  const std::string open = "<node name=\"" + Repeated("n", 60) + "\">";
  const std::string deep = Repeated(open, 90) + Repeated("<a/>", 200'000) + Repeated("</node>", 90);
  EXPECT_EQ(
      std::string(Refusal(Collada(BoxMesh({1, 1, 1}), {.scene_nodes = deep}), "a.dae").message()),
      "must have triangles");
}

TEST_F(MeshExpansion, CallersWhoKnowTheirFilesMayWidenTheLimit) {
  const std::string bytes = ExpandingCollada(12);
  EXPECT_EQ(Refusal(bytes, "a.dae").code(), absl::StatusCode::kResourceExhausted);
  const auto mesh = ReadMeshFile(bytes, "a.dae", {.max_free_triangles = 1'000'000});
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(mesh->triangles.size(), 4u << 12);
}

}  // namespace
}  // namespace cwm::collision
