#include "clients/formats/glb.h"

#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

namespace cwm::formats {
namespace {

// The four corners and four triangles of Tetrahedron(): three numbers of four bytes each.
constexpr std::size_t kPositionBytes = 48, kIndexBytes = 48;

using nlohmann::json;

const MeshFile& Tetrahedron() {
  static const MeshFile mesh{.vertices = {{0, 0, 0.5}, {1, 0, 0.5}, {0, 2, 0.5}, {0, 0, -0.25}},
                             .triangles = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}}};
  return mesh;
}

std::uint32_t WordAt(const std::string& bytes, std::size_t offset) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + offset, sizeof(word));
  return word;
}

// A reader by section 4.4 of the glTF 2.0 specification.
struct Container {
  json description;
  std::string binary;
};

Container Open(const std::string& glb) {
  EXPECT_EQ(glb.substr(0, 4), "glTF");
  EXPECT_EQ(WordAt(glb, 4), 2U);
  EXPECT_EQ(WordAt(glb, 8), glb.size());
  const std::uint32_t json_bytes = WordAt(glb, 12);
  EXPECT_EQ(glb.substr(16, 4), "JSON");
  EXPECT_EQ(json_bytes % 4, 0U);
  const std::size_t second = 20 + json_bytes;
  EXPECT_EQ(glb.substr(second + 4, 4), std::string("BIN\0", 4));
  EXPECT_EQ(WordAt(glb, second) % 4, 0U);
  EXPECT_EQ(second + 8 + WordAt(glb, second), glb.size());
  return {json::parse(glb.substr(20, json_bytes)), glb.substr(second + 8)};
}

TEST(Glb, HoldsTheVerticesAndTrianglesThatItDescribes) {
  const Container glb = Open(FormatGlbMesh(Tetrahedron()));
  const json& positions = glb.description.at("accessors").at(0);
  const json& indices = glb.description.at("accessors").at(1);
  EXPECT_EQ(positions.at("count"), 4);
  EXPECT_EQ(positions.at("min"), json({0.0, 0.0, -0.25}));
  EXPECT_EQ(positions.at("max"), json({1.0, 2.0, 0.5}));
  EXPECT_EQ(indices.at("count"), 12);
  EXPECT_EQ(glb.description.at("buffers").at(0).at("byteLength"), glb.binary.size());
  const json& views = glb.description.at("bufferViews");
  float last_z = 0;
  std::memcpy(&last_z, glb.binary.data() + kPositionBytes - sizeof(last_z), sizeof(last_z));
  EXPECT_EQ(last_z, -0.25F);
  const std::size_t first_index = views.at(1).at("byteOffset");
  EXPECT_EQ(first_index, kPositionBytes);
  EXPECT_EQ(
      std::memcmp(glb.binary.data() + first_index, Tetrahedron().triangles.data(), kIndexBytes), 0);
}

TEST(Glb, TurnsTheWorldsUpIntoThatOfGltf) {
  const json node = Open(FormatGlbMesh(Tetrahedron())).description.at("nodes").at(0);
  const std::vector<double> q = node.at("rotation");  // x y z w
  ASSERT_EQ(q.size(), 4U);
  // The image of (0, 0, 1), from the rotation matrix of a unit quaternion.
  const double kSinglePrecision = 1e-7;
  EXPECT_NEAR(2 * (q[0] * q[2] + q[1] * q[3]), 0, kSinglePrecision);
  EXPECT_NEAR(2 * (q[1] * q[2] - q[0] * q[3]), 1, kSinglePrecision);
  EXPECT_NEAR(1 - 2 * (q[0] * q[0] + q[1] * q[1]), 0, kSinglePrecision);
}

}  // namespace
}  // namespace cwm::formats
