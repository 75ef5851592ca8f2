#include "proto/transfer/mesh_bytes.h"

#include <gtest/gtest.h>

#include <vector>

namespace cwm {
namespace {

struct Mesh {
  std::vector<std::array<double, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

const Mesh& TwoTriangles() {
  static const Mesh mesh{.vertices = {{0.5, 2, 3}, {4, 5, 6}, {7, 8, 1e-300}},
                         .triangles = {{0, 1, 2}, {2, 1, 0}}};
  return mesh;
}

TEST(MeshBytes, LieAsDocumented) {
  const std::string bytes = EncodeMesh(TwoTriangles());
  ASSERT_EQ(bytes.size(), 8U + 3 * 24 + 2 * 12);
  EXPECT_EQ(bytes.substr(0, 8), std::string("\3\0\0\0\2\0\0\0", 8));
  EXPECT_EQ(bytes.substr(8, 8), std::string("\0\0\0\0\0\0\xe0\x3f", 8));  // 0.5 in IEEE 754
  EXPECT_EQ(bytes.substr(8 + 3 * 24, 12), std::string("\0\0\0\0\1\0\0\0\2\0\0\0", 12));
}

TEST(MeshBytes, AreUndoneByReading) {
  const auto back = ReadMeshColumns<Mesh>(EncodeMesh(TwoTriangles()));
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(back->vertices, TwoTriangles().vertices);
  EXPECT_EQ(back->triangles, TwoTriangles().triangles);
}

TEST(MeshBytes, ThatDoNotFitTheirCountsAreRefusedAtEveryCut) {
  const std::string bytes = EncodeMesh(TwoTriangles());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(ReadMeshCounts(bytes.substr(0, size)).ok()) << "cut at " << size;
  }
  EXPECT_FALSE(ReadMeshCounts(bytes + '\0').ok());
  // Counts whose product would overflow 32 bits promise more than is there.
  EXPECT_FALSE(ReadMeshCounts(std::string(8, '\xff')).ok());
}

}  // namespace
}  // namespace cwm
