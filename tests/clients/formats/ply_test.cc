#include "clients/formats/ply.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>

#include "tests/clients/formats/invalid_file.h"

namespace cwm::formats {
namespace {

using ::testing::HasSubstr;

const char kVertex[] = "property float x\nproperty float y\nproperty float z\n";
const char kFace[] = "property list uchar int vertex_indices\n";

std::string Ply(const std::string& format, const std::string& elements, const std::string& data) {
  return "ply\nformat " + format + " 1.0\ncomment by hand\n" + elements + "end_header\n" + data;
}

std::string Square(const std::string& faces) {
  return Ply("ascii", std::string("element vertex 4\n") + kVertex + "element face 1\n" + kFace,
             "0 0 0\n1 0 0\n1 1 0\n0 1 0\n" + faces);
}

double At(const CloudFile& cloud, std::size_t point, const std::string& field) {
  const CloudField& f = *cloud.Find(field);
  return ToDouble(&cloud.bytes[point * cloud.point_step + f.offset], f.type);
}

TEST(Ply, ReadsVerticesWithNormalsAndColoursAsACloud) {
  const auto cloud = ParsePlyCloud(
      Ply("ascii",
          std::string("element vertex 2\n") + kVertex +
              "property double nx\nproperty double ny\nproperty double nz\nproperty uchar red\n",
          "1 2 3 0 0 1 255\n4 5 nan 0 1 0 7\n"),
      "a.ply");
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_EQ(cloud->size(), 2);
  EXPECT_EQ(At(*cloud, 0, "x"), 1);
  EXPECT_EQ(At(*cloud, 0, "normal_z"), 1);
  EXPECT_EQ(At(*cloud, 1, "red"), 7);
  EXPECT_TRUE(std::isnan(At(*cloud, 1, "z")));
}

TEST(Ply, ReadsBothByteOrdersAlike) {
  const std::string elements =
      std::string("element vertex 1\n") + kVertex + "property short intensity\n";
  const float xyz[3] = {1.5f, -2.25f, 1e-3f};
  std::string little(reinterpret_cast<const char*>(xyz), sizeof(xyz));
  little += std::string("\x02\x01", 2);
  std::string big;
  for (int i = 0; i < 3; ++i) {
    for (int b = 3; b >= 0; --b) big += little[4 * i + b];
  }
  big += std::string("\x01\x02", 2);
  const auto a = ParsePlyCloud(Ply("binary_little_endian", elements, little), "little.ply");
  const auto b = ParsePlyCloud(Ply("binary_big_endian", elements, big), "big.ply");
  ASSERT_TRUE(a.ok()) << a.status();
  ASSERT_TRUE(b.ok()) << b.status();
  EXPECT_EQ(a->bytes, little);
  EXPECT_EQ(b->bytes, little);
  EXPECT_EQ(At(*b, 0, "intensity"), 258);
}

TEST(Ply, SplitsPolygonsIntoFansAndSkipsOtherElements) {
  const auto mesh =
      ParsePlyMesh(Ply("ascii",
                       std::string("element edge 1\nproperty int a\nproperty list uchar int rest\n"
                                   "element vertex 4\n") +
                           kVertex + "element face 1\nproperty uchar colour\n" + kFace,
                       "5 2 8 9\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n17 4 0 1 2 3\n"),
                   "fan.ply");
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  using Triangles = std::vector<std::array<std::uint32_t, 3>>;
  EXPECT_EQ(mesh->triangles, (Triangles{{0, 1, 2}, {0, 2, 3}}));
}

TEST(Ply, TellsMeshesFromCloudsByTheirFaces) {
  EXPECT_TRUE(HasPlyFaces(Square("3 0 1 2")));
  EXPECT_FALSE(HasPlyFaces(Ply("ascii", std::string("element vertex 1\n") + kVertex, "1 2 3\n")));
  EXPECT_FALSE(HasPlyFaces(
      Ply("ascii", std::string("element vertex 1\n") + kVertex + "element face 0\n" + kFace,
          "1 2 3\n")));
  EXPECT_FALSE(HasPlyFaces("ply\nelement face 3\n"));
}

TEST(Ply, MeshesSurviveARoundTripToTheLastBit) {
  const MeshFile mesh{.vertices = {{0.1, 1.0 / 3, -1e-300}, {1, 2, 3}, {4, 5, 6}},
                      .triangles = {{0, 1, 2}, {2, 1, 0}}};
  const auto back = ParsePlyMesh(FormatPlyMesh(mesh), "round.ply");
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(*back, mesh);
}

TEST(Ply, FailsCleanlyWhenCutAtAnyByte) {
  const MeshFile mesh{.vertices = {{0, 1, 2}, {1, 2, 3}, {4, 5, 6}}, .triangles = {{0, 1, 2}}};
  const std::string binary = FormatPlyMesh(mesh);
  for (std::size_t size = 0; size < binary.size(); ++size) {
    ASSERT_EQ(ParsePlyMesh(binary.substr(0, size), "cut.ply").status().code(),
              absl::StatusCode::kInvalidArgument)
        << "cut at " << size;
  }
  const std::string text = Square("3 0 1 2");
  for (std::size_t size = 0; size < text.size(); ++size) {
    ASSERT_EQ(ParsePlyMesh(text.substr(0, size), "cut.ply").status().code(),
              absl::StatusCode::kInvalidArgument)
        << "cut at " << size;
  }
}

class HostilePly : public ::testing::TestWithParam<InvalidFile> {};

TEST_P(HostilePly, IsRefusedNamingFileFieldAndRule) {
  ExpectRefusal(ParsePlyMesh(GetParam().text, "hostile.ply").status(), "hostile.ply", GetParam());
}

std::string Vertices(const std::string& count) {
  return "element vertex " + count + "\n" + kVertex;
}

INSTANTIATE_TEST_SUITE_P(
    InvalidFiles, HostilePly,
    ::testing::Values(
        InvalidFile{"Magic", "plx\n", "first line is plx", "must be \"ply\""},
        InvalidFile{"NoFormat", "ply\nelement vertex 0\nproperty float x\nend_header\n", "format",
                    "is missing"},
        InvalidFile{"UnknownFormat", Ply("middle_endian", Vertices("0"), ""),
                    "format is middle_endian", "must be, once, ascii"},
        InvalidFile{"NegativeCount", Ply("ascii", Vertices("-1"), ""),
                    "count of element vertex is -1", "at least 0"},
        InvalidFile{"CountOutOfRange", Ply("ascii", Vertices("99999999999999999999"), ""),
                    "count of element vertex is 9999", "must be an integer"},
        InvalidFile{"CountLargerThanData",
                    Ply("binary_little_endian", Vertices("1000000000000"), "123456789012"),
                    "count of element vertex is 1000000000000", "12 bytes are left"},
        InvalidFile{"TooMuchData", Square("3 0 1 2\n5 5"), "data is",
                    "must end with the last element"},
        InvalidFile{"UnknownType", Ply("ascii", "element vertex 1\nproperty real x\n", "1"),
                    "property x is real", "must be one of PLY"},
        InvalidFile{"FloatCountsAList",
                    Ply("ascii", "element face 1\nproperty list float int vertex_indices\n", "1"),
                    "vertex_indices is float", "an integer where it counts"},
        InvalidFile{"PropertyTwice",
                    Ply("ascii", "element vertex 1\nproperty float x\nproperty float x\n", "1 2"),
                    "property is x", "must not appear twice"},
        InvalidFile{"PropertyWithoutElement", Ply("ascii", "property float x\n", ""), "property",
                    "must follow an element"},
        InvalidFile{"ElementWithoutProperty", Ply("ascii", "element vertex 1\n", "1"),
                    "element vertex", "at least one property"},
        InvalidFile{"NoZ",
                    Ply("ascii", "element vertex 1\nproperty float x\nproperty float y\n", "1 2"),
                    "property z", "is missing"},
        InvalidFile{"NoVertices", Ply("ascii", "element other 1\nproperty float x\n", "1"),
                    "element vertex", "is missing"},
        InvalidFile{"ListInVertex",
                    Ply("ascii", "element vertex 1\nproperty list uchar float x\n", "1 2"),
                    "property is x", "must not be a list"},
        InvalidFile{"NoFaces", Ply("ascii", Vertices("1"), "1 2 3"), "element face",
                    "at least one face"},
        InvalidFile{"TwoCorners", Square("2 0 1"), "length of vertex_indices is 2", "at least 3"},
        InvalidFile{"LongFace", Square("200 0 1 2"), "length of vertex_indices is 200",
                    "no more than the data holds"},
        InvalidFile{"IndexTooLarge", Square("3 0 1 4"), "face corner 2 is 4", "one of 4 vertices"},
        InvalidFile{"NegativeIndex", Square("3 0 -1 2"), "face corner 1 is -1",
                    "one of 4 vertices"},
        InvalidFile{"NotANumber", Square("3 0 one 2"), "face 0 property vertex_indices",
                    "of type int32"},
        InvalidFile{"VertexNotFinite",
                    Ply("ascii", Vertices("3") + "element face 1\n" + kFace,
                        "0 0 0\n1 inf 0\n1 1 0\n3 0 1 2"),
                    "vertex 1 y", "must be a finite number"}),
    [](const ::testing::TestParamInfo<InvalidFile>& info) { return std::string(info.param.name); });

// Names are searched among all others, so a million of them would take minutes.
TEST(Ply, HasNoMorePropertiesAndElementsThanAScannerWrites) {
  std::string properties = "element vertex 1\n", elements;
  for (int i = 0; i < 1025; ++i) properties += "property float p" + std::to_string(i) + "\n";
  for (int i = 0; i < 257; ++i) elements += "element e" + std::to_string(i) + " 0\n";
  EXPECT_THAT(std::string(ParsePlyCloud(Ply("ascii", properties, ""), "a.ply").status().message()),
              HasSubstr("property is p1024, must be one of at most 1024 of an element"));
  EXPECT_THAT(std::string(ParsePlyCloud(Ply("ascii", elements, ""), "a.ply").status().message()),
              HasSubstr("element is e256, must be one of at most 256"));
}

}  // namespace
}  // namespace cwm::formats
