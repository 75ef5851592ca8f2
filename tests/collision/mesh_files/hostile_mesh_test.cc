// Mesh files that would crash, starve or mislead a reader.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "collision/mesh_files/mesh_file.h"
#include "tests/collision/mesh_files/mesh_bytes.h"

namespace cwm::collision {
namespace {

using testing::BinaryStl;
using testing::BoxMesh;
using testing::Collada;
using testing::Glb;
using testing::GlbBinary;
using testing::GlbJson;
using ::testing::HasSubstr;
using testing::Obj;
using testing::TextStl;

const TriangleMesh kBox = BoxMesh({1, 1, 1});

std::string RefusalOf(const std::string& bytes, const std::string& name,
                      const MeshFileLimits& limits = {}) {
  const auto mesh = ReadMeshFile(bytes, name, limits);
  return mesh.ok() ? "" : std::string(mesh.status().message());
}

std::string Repeated(const std::string& text, int times) {
  std::string repeated;
  for (int i = 0; i < times; ++i) repeated += text;
  return repeated;
}

std::string GlbWith(const std::string& from, const std::string& to) {
  const std::string json = GlbJson(kBox);
  EXPECT_THAT(json, HasSubstr(from));
  return Glb(absl::StrReplaceAll(json, {{from, to}}), GlbBinary(kBox));
}

TEST(HostileMesh, OtherEndingsAreRefused) {
  for (const char* name : {"part.ply", "part.gltf", "part", "stl", "part.stl.zip", ""}) {
    EXPECT_EQ(RefusalOf(BinaryStl(kBox), name), "must end in .stl, .obj, .dae or .glb") << name;
  }
}

TEST(HostileMesh, ContentOfAnotherFormatIsNotGuessed) {
  EXPECT_NE(RefusalOf(Obj(kBox), "part.stl"), "");
  EXPECT_NE(RefusalOf(BinaryStl(kBox), "part.obj"), "");
  EXPECT_NE(RefusalOf(Obj(kBox), "part.dae"), "");
  EXPECT_NE(RefusalOf(Collada(kBox), "part.glb"), "");
  EXPECT_NE(RefusalOf("ply\nformat ascii 1.0\n", "part.obj"), "");
}

TEST(HostileMesh, EmptyFilesAndFilesWithoutTrianglesAreRefused) {
  for (const char* name : {"a.stl", "a.obj", "a.dae", "a.glb"}) {
    EXPECT_EQ(RefusalOf("", name), "must not be empty");
  }
  EXPECT_NE(RefusalOf(BinaryStl({}), "a.stl"), "");
  EXPECT_NE(RefusalOf("solid nothing\nendsolid nothing\n", "a.stl"), "");
  EXPECT_NE(RefusalOf("v 0 0 0\nv 1 0 0\nl 1 2\n", "a.obj"), "");
  EXPECT_NE(RefusalOf(Collada(kBox, {.scene_nodes = "<node id=\"bare\"/>"}), "a.dae"), "");
  EXPECT_EQ(RefusalOf(Glb(GlbJson(kBox, "[{}]"), GlbBinary(kBox)), "a.glb"), "must have triangles");
}

TEST(HostileMesh, AnStlThatIsCutShortOrLiesAboutItsLengthIsRefused) {
  const std::string stl = BinaryStl(kBox);
  EXPECT_THAT(RefusalOf(stl.substr(0, 300), "a.stl"), HasSubstr("is 300 bytes long"));
  EXPECT_THAT(RefusalOf(stl + "x", "a.stl"), HasSubstr("12 triangles"));
  std::string lies = stl;
  std::memset(lies.data() + 80, 0xff, 4);
  EXPECT_THAT(RefusalOf(lies, "a.stl"), HasSubstr("4294967295 triangles"));
}

TEST(HostileMesh, LimitsAreSaidInTheRefusal) {
  EXPECT_THAT(RefusalOf(BinaryStl(kBox), "a.stl", {.max_bytes = 683}),
              HasSubstr("is 684 bytes long, must be at most 683"));
  EXPECT_EQ(RefusalOf(BinaryStl(kBox), "a.stl", {.max_bytes = 684}), "");
  for (const auto& [name, bytes] : {std::pair("a.stl", BinaryStl(kBox)),
                                    {"a.obj", Obj(kBox)},
                                    {"a.dae", Collada(kBox)},
                                    {"a.glb", Glb(kBox)}}) {
    EXPECT_THAT(RefusalOf(bytes, name, {.max_triangles = 11}),
                HasSubstr("must have at most 11 triangles"))
        << name;
    EXPECT_EQ(RefusalOf(bytes, name, {.max_triangles = 12}), "") << name;
  }
  EXPECT_THAT(RefusalOf(Collada(kBox), "a.dae", {.max_collada_bytes = 100}),
              HasSubstr("must be at most 100"));
}

TEST(HostileMesh, VerticesThatAreNotFiniteAreRefused) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  for (const float value : {nan, inf, -inf}) {
    std::string stl = BinaryStl(kBox);
    std::memcpy(stl.data() + 84 + 12, &value, sizeof(value));
    EXPECT_THAT(RefusalOf(stl, "a.stl"), HasSubstr("triangle 0 has the corner ("));
    EXPECT_THAT(RefusalOf(stl, "a.stl"), HasSubstr("must have finite vertices"));
    std::string binary = GlbBinary(kBox);
    std::memcpy(binary.data(), &value, sizeof(value));
    EXPECT_THAT(RefusalOf(Glb(GlbJson(kBox), binary), "a.glb"),
                HasSubstr("must have finite vertices"));
  }
}

TEST(HostileMesh, FacesOfVerticesThatAreNotThereAreRefused) {
  EXPECT_EQ(RefusalOf("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "a.obj"),
            "line 4: corner \"9\" must be one of the 3 vertices that come before the face");
  EXPECT_NE(RefusalOf("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -9\n", "a.obj"), "");
  TriangleMesh wild = kBox;
  wild.triangles[0][0] = 8;
  EXPECT_NE(RefusalOf(Collada(wild), "a.dae"), "");
  EXPECT_NE(RefusalOf(Glb(wild), "a.glb"), "");
}

TEST(HostileMesh, TextThatIsNoNumberIsRefusedWithItsLine) {
  EXPECT_EQ(RefusalOf("v 0 0 0\nv 1 x 0\n", "a.obj"), "line 2: a vertex must have three numbers");
  EXPECT_EQ(RefusalOf("v 0 0 0\nv 1 0\n", "a.obj"), "line 2: a vertex must have three numbers");
  EXPECT_EQ(RefusalOf("v 0 0 0\nv 1 0 0\nf 1 2\n", "a.obj"),
            "line 3: faces must have 3 to 4096 corners");
  EXPECT_EQ(RefusalOf("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "a.obj"),
            "line 4: triangle 0 has the corner (0, 0, nan), must have finite vertices");
  EXPECT_EQ(RefusalOf("solid\nfacet\nvertex 0 0\n", "a.stl"), "line 3: must have three numbers");
  EXPECT_EQ(RefusalOf("solid\nvertex 0 0 0\n", "a.stl"), "line 2: must be one of three of a facet");
  EXPECT_EQ(RefusalOf("solid\nfacet\nvertex 0 0 0\nendfacet\n", "a.stl"),
            "line 4: must be part of a facet with three vertices");
  EXPECT_EQ(RefusalOf("solid\nfacet\nvertex 0 0 0\n", "a.stl"), "must close its last facet");
}

TEST(HostileMesh, ColladaListsMustHoldNumbersAndCountsFitTheFile) {
  const std::string collada = Collada(kBox);
  const auto with = [&](const std::string& from, const std::string& to) {
    EXPECT_THAT(collada, HasSubstr(from));
    return RefusalOf(absl::StrReplaceAll(collada, {{from, to}}), "a.dae");
  };
  EXPECT_THAT(with("<p>0 2 1", "<p>0z2 1"), HasSubstr("holds \"0z2\", must hold indices"));
  EXPECT_THAT(with("<p>0 2 1", "<p>0 -2 1"), HasSubstr("must hold indices"));
  EXPECT_THAT(with("<p>0 2 1", "<p>0 2<!-- --> 1"), HasSubstr("must hold plain text alone"));
  EXPECT_THAT(with("\"pa\" count=\"24\">0 0", "\"pa\" count=\"24\">0 nan"),
              HasSubstr("must hold finite numbers"));
  EXPECT_THAT(with("#pa\" count=\"8\"", "#pa\" count=\"4000000000\""),
              HasSubstr("must fit the 24 numbers"));
  EXPECT_THAT(with("offset=\"0\"", "offset=\"64\""), HasSubstr("must be below 64"));
  EXPECT_THAT(with("<p>0 2 1", "<p>0 2"), HasSubstr("holds 35 indices, must hold 33"));
  EXPECT_THAT(with("meter=\"1\"", "meter=\"0\""), HasSubstr("must be positive"));
}

TEST(HostileMesh, NoOtherFileIsRead) {
  const std::string there = GlbWith(R"("buffers":[{)", R"("buffers":[{"uri":"/etc/passwd",)");
  EXPECT_EQ(RefusalOf(there, "a.glb"), "its buffer must be its own binary chunk");
  // A missing material file of an OBJ is ignored.
  EXPECT_EQ(RefusalOf("mtllib /etc/passwd\n" + Obj(kBox), "a.obj"), "");
}

TEST(HostileMesh, ColladaNodesThatHoldThemselvesAreRefused) {
  EXPECT_THAT(RefusalOf(Collada(kBox, {.scene_nodes = "<node id=\"a\"><instance_node url=\"#a\"/>"
                                                      "</node>"}),
                        "a.dae"),
              HasSubstr("nor in a circle"));
  EXPECT_THAT(
      RefusalOf(Collada(kBox, {.scene_nodes = "<node id=\"a\"><instance_node url=\"#b\"/></node>",
                               .library_nodes = "<node id=\"b\"><node id=\"c\">"
                                                "<instance_node url=\"#a\"/></node></node>"}),
                "a.dae"),
      HasSubstr("nor in a circle"));
}

TEST(HostileMesh, ColladaNodesThatUnfoldWithoutEndAreRefused) {
  std::string library;
  for (int i = 0; i < 40; ++i) {
    absl::StrAppend(&library, "<node id=\"n", i, "\">",
                    Repeated(absl::StrCat("<instance_node url=\"#n", i + 1, "\"/>"), 2), "</node>");
  }
  library += "<node id=\"n40\"/>";
  const std::string scene = "<node><instance_node url=\"#n0\"/></node>";
  EXPECT_THAT(RefusalOf(Collada(kBox, {.scene_nodes = scene, .library_nodes = library}), "a.dae"),
              HasSubstr("unfold"));
}

TEST(HostileMesh, DeepXmlIsRefused) {
  const std::string deep = Repeated("<node>", 100'000) + Repeated("</node>", 100'000);
  EXPECT_THAT(RefusalOf(Collada(kBox, {.scene_nodes = deep}), "a.dae"),
              HasSubstr("deeper than 100"));
  EXPECT_THAT(RefusalOf("<!DOCTYPE COLLADA [<!ENTITY a \"b\">]>" + Collada(kBox), "a.dae"),
              HasSubstr("DOCTYPE"));
}

TEST(HostileMesh, GlbNodesThatHoldThemselvesOrUnfoldWithoutEndAreRefused) {
  const auto with_nodes = [](const std::string& nodes) {
    return RefusalOf(Glb(GlbJson(kBox, nodes), GlbBinary(kBox)), "a.glb");
  };
  EXPECT_THAT(with_nodes(R"([{"children":[0],"mesh":0}])"), HasSubstr("circle"));
  EXPECT_THAT(with_nodes(R"([{"children":[7],"mesh":0}])"), HasSubstr("must be nodes"));
  EXPECT_THAT(with_nodes(R"([{"children":["a"],"mesh":0}])"), HasSubstr("must be nodes"));
  std::string doubling, deep;
  for (int i = 1; i <= 40; ++i) absl::StrAppend(&doubling, "{\"children\":[", i, ",", i, "]},");
  EXPECT_THAT(with_nodes("[" + doubling + "{\"mesh\":0}]"), HasSubstr("unfold"));
  for (int i = 1; i <= 50'000; ++i) absl::StrAppend(&deep, "{\"children\":[", i, "]},");
  EXPECT_THAT(with_nodes("[" + deep + "{\"mesh\":0}]"), HasSubstr("deeper than 100"));
}

TEST(HostileMesh, GlbAccessorsThatLeaveTheFileAreRefused) {
  EXPECT_THAT(RefusalOf(GlbWith(R"("count":8)", R"("count":9)"), "a.glb"), HasSubstr("accessor"));
  EXPECT_THAT(RefusalOf(GlbWith(R"("count":36)", R"("count":4000000000)"), "a.glb"),
              HasSubstr("accessor"));
  EXPECT_THAT(RefusalOf(GlbWith(R"("count":36)", R"("count":-1)"), "a.glb"), HasSubstr("accessor"));
  EXPECT_THAT(RefusalOf(GlbWith(R"("byteOffset":96)", R"("byteOffset":97)"), "a.glb"),
              HasSubstr("bufferView"));
  EXPECT_THAT(RefusalOf(GlbWith(R"("byteLength":240)", R"("byteLength":241)"), "a.glb"),
              HasSubstr("binary chunk"));
  EXPECT_THAT(RefusalOf(GlbWith(R"("bufferView":0,)", ""), "a.glb"), HasSubstr("accessor"));
  EXPECT_THAT(RefusalOf(GlbWith(R"("bufferView":0,)", R"("bufferView":0,"sparse":{},)"), "a.glb"),
              HasSubstr("sparse"));
  EXPECT_THAT(RefusalOf(GlbWith(R"("indices":1)", R"("indices":1,"mode":1)"), "a.glb"),
              HasSubstr("must be triangles"));
  EXPECT_THAT(RefusalOf(GlbWith(R"("POSITION":0)", R"("POSITION":1)"), "a.glb"),
              HasSubstr("three floats"));
}

TEST(HostileMesh, GlbContainersThatLieAreRefused) {
  const std::string glb = Glb(kBox);
  for (const std::size_t length : {4, 11, 19, 100, 600}) {
    EXPECT_NE(RefusalOf(glb.substr(0, length), "a.glb"), "") << length;
  }
  std::string version = glb;
  version[4] = 1;
  EXPECT_THAT(RefusalOf(version, "a.glb"), HasSubstr("must be glTF 2"));
  EXPECT_THAT(RefusalOf(Glb("not json", ""), "a.glb"), HasSubstr("JSON object"));
  EXPECT_THAT(RefusalOf(Glb("[1]", ""), "a.glb"), HasSubstr("JSON object"));
  const std::string deep = Repeated("[", 100'000) + Repeated("]", 100'000);
  EXPECT_THAT(RefusalOf(GlbWith(R"("scene":0)", R"("x":)" + deep), "a.glb"),
              HasSubstr("deeper than 64"));
  EXPECT_THAT(
      RefusalOf(GlbWith(R"("scene":0)", R"("scene":0,"nodes":[{"children":[0]}])"), "a.glb"),
      HasSubstr("key twice"));
}

// Every input gives a mesh with valid indices, or an error.
TEST(HostileMesh, FilesWithBytesChangedAtRandomAreReadOrRefused) {
  std::mt19937 random(7);
  for (const auto& [name, bytes] : {std::pair("a.stl", BinaryStl(kBox)),
                                    {"b.stl", TextStl(kBox)},
                                    {"a.obj", Obj(kBox)},
                                    {"a.dae", Collada(kBox)},
                                    {"a.glb", Glb(kBox)}}) {
    for (int round = 0; round < 300; ++round) {
      std::string changed = bytes;
      for (int i = 0; i < 1 + round % 5; ++i) {
        changed[random() % changed.size()] = static_cast<char>(random() % 256);
      }
      if (round % 10 == 0) changed.resize(random() % changed.size());
      const auto mesh = ReadMeshFile(changed, name);
      if (!mesh.ok()) continue;
      for (const auto& triangle : mesh->triangles) {
        for (const std::uint32_t v : triangle) ASSERT_LT(v, mesh->vertices.size());
      }
    }
  }
}

}  // namespace
}  // namespace cwm::collision
