#include "clients/cpp/geometry_transfer.h"

#include <gtest/gtest.h>

#include "proto/transfer/mesh_bytes.h"

namespace cwm::client {
namespace {

TEST(MeshBlob, SurvivesARoundTrip) {
  const formats::MeshFile mesh{.vertices = {{0.1, 2, 3}, {4, 5, 6}, {7, 8, 1e-300}},
                               .triangles = {{0, 1, 2}, {2, 1, 0}}};
  const std::string bytes = EncodeMesh(mesh);
  EXPECT_EQ(bytes.size(), 8u + 3 * 24 + 2 * 12);
  const auto back = DecodeMesh(bytes);
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(*back, mesh);
}

TEST(MeshBlob, IsRefusedWhenCutAtAnyByteOrWithABadCorner) {
  const std::string bytes = EncodeMesh(
      formats::MeshFile{.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .triangles = {{0, 1, 2}}});
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    // Even an empty mesh must have its counts.
    EXPECT_FALSE(DecodeMesh(bytes.substr(0, size)).ok()) << "cut at " << size;
  }
  std::string bad = bytes;
  bad[bad.size() - 4] = 3;
  EXPECT_FALSE(DecodeMesh(bad).ok());
  EXPECT_FALSE(DecodeMesh(std::string(8, '\xff')).ok());
}

}  // namespace
}  // namespace cwm::client
