#include "server/core/geometry_store.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "proto/transfer/sha256.h"
#include "server/core/error.h"

namespace cwm::server {
namespace {

constexpr std::int64_t kRoomy = 1 << 20;

TriangleMesh Tetrahedron(double edge_m = 1) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {edge_m, 0, 0}, {0, edge_m, 0}, {0, 0, edge_m}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

std::string Labels(std::size_t count) { return std::string(4 * count, '\1'); }

TEST(MeshEncoding, LiesAsDocumented) {
  const std::string bytes = EncodeMesh(Tetrahedron());
  ASSERT_EQ(bytes.size(), 8u + 4 * 24 + 4 * 12);
  EXPECT_EQ(bytes.substr(0, 8), std::string("\4\0\0\0\4\0\0\0", 8));
  double x_of_second = 0;
  std::memcpy(&x_of_second, bytes.data() + 8 + 24, sizeof(double));
  EXPECT_EQ(x_of_second, 1);
  EXPECT_EQ(bytes.substr(8 + 4 * 24, 12), std::string("\0\0\0\0\2\0\0\0\1\0\0\0", 12));
}

TEST(MeshEncoding, IsUndoneByDecoding) {
  const auto decoded = DecodeMesh(EncodeMesh(Tetrahedron()));
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(*decoded, Tetrahedron());
}

TEST(MeshEncoding, HashIsThatOfTheBytes) {
  const auto mesh = std::make_shared<const TriangleMesh>(Tetrahedron());
  EXPECT_EQ(HashOf(mesh), Sha256Hex(EncodeMesh(*mesh)));
  EXPECT_EQ(HashOf(mesh), HashOf(std::make_shared<const TriangleMesh>(Tetrahedron())));
}

// Allocators reuse the address of a freed mesh for the next one.
TEST(MeshEncoding, HashOfAnAddressUsedAgainIsThatOfTheNewMesh) {
  for (int i = 1; i <= 1000; ++i) {
    const auto mesh = std::make_shared<const TriangleMesh>(Tetrahedron(i));
    ASSERT_EQ(HashOf(mesh), Sha256Hex(EncodeMesh(*mesh)));
  }
}

TEST(GeometryStore, StoresTheSameBytesOnce) {
  GeometryStore store(kRoomy);
  const std::string bytes = EncodeMesh(Tetrahedron());
  const auto first = store.Put(BlobFormat::kMeshF64, bytes);
  const auto second = store.Put(BlobFormat::kMeshF64, bytes);
  ASSERT_TRUE(first.ok() && second.ok());
  EXPECT_FALSE(first->already_known);
  EXPECT_TRUE(second->already_known);
  EXPECT_EQ(first->hash, second->hash);
  EXPECT_EQ(first->hash, Sha256Hex(bytes));
  const auto blob = store.Get(first->hash);
  ASSERT_TRUE(blob.ok());
  EXPECT_EQ(*(*blob)->bytes, bytes);
  EXPECT_EQ(*(*blob)->mesh, Tetrahedron());
}

TEST(GeometryStore, RefusesMalformedMeshesByName) {
  TriangleMesh bad_index = Tetrahedron();
  bad_index.triangles[2][1] = 4;
  TriangleMesh not_finite = Tetrahedron();
  not_finite.vertices[1].y() = std::numeric_limits<double>::quiet_NaN();
  TriangleMesh none = Tetrahedron();
  none.triangles.clear();
  TriangleMesh twice = Tetrahedron();
  twice.triangles[0] = {1, 1, 2};
  std::string lying = EncodeMesh(Tetrahedron());
  lying[0] = '\5';  // one vertex more than the data has
  std::string huge = EncodeMesh(Tetrahedron());
  huge.replace(0, 8, std::string(8, '\xff'));
  const std::string whole = EncodeMesh(Tetrahedron());
  GeometryStore store(kRoomy);
  for (const std::string& bytes :
       {std::string(), std::string(7, '\0'), whole.substr(0, whole.size() - 1), whole + "x", lying,
        huge, EncodeMesh(bad_index), EncodeMesh(not_finite), EncodeMesh(none), EncodeMesh(twice)}) {
    const auto stored = store.Put(BlobFormat::kMeshF64, bytes);
    ASSERT_EQ(stored.status().code(), absl::StatusCode::kInvalidArgument) << stored.status();
    const ErrorDetails details = DetailsOf(stored.status());
    EXPECT_EQ(details.reason, "INVALID_FIELD");
    ASSERT_EQ(details.fields.size(), 1u);
    EXPECT_EQ(details.fields[0].field.substr(0, 4), "mesh");
    EXPECT_FALSE(store.Get(Sha256Hex(bytes)).ok());
  }
}

TEST(GeometryStore, RefusesLabelsThatAreNoNumbers) {
  GeometryStore store(kRoomy);
  const auto stored = store.Put(BlobFormat::kLabelsU32, "12345");
  EXPECT_EQ(DetailsOf(stored.status()).reason, "INVALID_FIELD");
}

TEST(GeometryStore, RefusesWhatCanNeverFit) {
  GeometryStore small(100, {.max_mesh_triangles = 3});
  const auto bytes = small.Put(BlobFormat::kLabelsU32, Labels(26));
  EXPECT_EQ(bytes.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(DetailsOf(bytes.status()).reason, "GEOMETRY_TOO_LARGE");
  EXPECT_TRUE(small.Put(BlobFormat::kLabelsU32, Labels(25)).ok());
  const auto triangles = small.Put(BlobFormat::kMeshF64, EncodeMesh(Tetrahedron()));
  EXPECT_EQ(triangles.status().code(), absl::StatusCode::kResourceExhausted);
}

TEST(GeometryStore, UnknownHashesAreNotFound) {
  GeometryStore store(kRoomy);
  const auto blob = store.Get("abc");
  EXPECT_EQ(blob.status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(DetailsOf(blob.status()).reason, "GEOMETRY_UNKNOWN");
  EXPECT_EQ(DetailsOf(blob.status()).metadata.at("hash"), "abc");
}

TEST(GeometryStore, LetsGoOfTheLeastRecentlyUsed) {
  GeometryStore store(std::int64_t{4} * 30);
  const std::string a = store.Put(BlobFormat::kLabelsU32, Labels(10))->hash;
  const std::string b = store.Put(BlobFormat::kLabelsU32, Labels(11))->hash;
  ASSERT_TRUE(store.Get(a).ok());  // now b is the oldest
  const std::string c = store.Put(BlobFormat::kLabelsU32, Labels(12))->hash;
  EXPECT_TRUE(store.Get(a).ok());
  EXPECT_FALSE(store.Get(b).ok());
  EXPECT_TRUE(store.Get(c).ok());
}

TEST(GeometryStore, WhatIsPutForAHolderGoesWithIt) {
  GeometryStore store(kRoomy);
  auto held = store.PutTemporary(BlobFormat::kPointsF32, std::string(12, '\1'));
  ASSERT_TRUE(held.ok()) << held.status();
  const std::string hash = held->hash;
  EXPECT_EQ((*store.Get(hash))->format, BlobFormat::kPointsF32);
  auto other = *held;
  held->hold.reset();
  EXPECT_TRUE(store.Get(hash).ok()) << "one of two copies is left";
  other.hold.reset();
  EXPECT_FALSE(store.Get(hash).ok());
}

TEST(GeometryStore, WhatOthersPutTooStays) {
  GeometryStore store(kRoomy);
  for (const bool first : {true, false}) {
    const std::string bytes = Labels(first ? 10 : 20);
    std::string hash;
    if (first) hash = store.Put(BlobFormat::kLabelsU32, bytes)->hash;
    {
      const auto held = store.PutTemporary(BlobFormat::kLabelsU32, bytes);
      const auto again = store.PutTemporary(BlobFormat::kLabelsU32, bytes);
      if (!first) hash = store.Put(BlobFormat::kLabelsU32, bytes)->hash;
      EXPECT_EQ(held->hash, hash);
    }
    EXPECT_TRUE(store.Get(hash).ok()) << first;
  }
}

TEST(GeometryStore, AHolderOfWhatHadToGoTakesNothingFromWhoPutItAnew) {
  GeometryStore store(std::int64_t{4} * 30);
  auto held = store.PutTemporary(BlobFormat::kLabelsU32, Labels(20));
  ASSERT_TRUE(store.Put(BlobFormat::kLabelsU32, Labels(25)).ok());  // needs the memory
  EXPECT_FALSE(store.Get(held->hash).ok());
  ASSERT_TRUE(store.Put(BlobFormat::kLabelsU32, Labels(20)).ok());
  held->hold.reset();
  EXPECT_TRUE(store.Get(held->hash).ok());
}

TEST(GeometryStore, HoldersMayOutliveIt) {
  std::shared_ptr<const void> hold;
  {
    GeometryStore store(kRoomy);
    hold = store.PutTemporary(BlobFormat::kLabelsU32, Labels(1))->hold;
  }
  hold.reset();
}

TEST(GeometryStore, PointsHaveThreeNumbers) {
  GeometryStore store(kRoomy);
  const auto stored = store.Put(BlobFormat::kPointsF32, std::string(16, '\1'));
  EXPECT_EQ(stored.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(stored.status().message().find("has 16 bytes, must be a multiple of 12"),
            std::string::npos)
      << stored.status();
}

TEST(GeometryStore, KeepsTheMeshesThatObjectsUse) {
  GeometryStore store(600);  // room for one tetrahedron: bytes and mesh, 304 each
  const std::string hash = store.Put(BlobFormat::kMeshF64, EncodeMesh(Tetrahedron()))->hash;
  std::shared_ptr<const TriangleMesh> used = (*store.Get(hash))->mesh;
  const std::string other = store.Put(BlobFormat::kMeshF64, EncodeMesh(Tetrahedron(2)))->hash;
  EXPECT_TRUE(store.Get(other).ok());
  const auto blob = store.Get(hash);
  ASSERT_TRUE(blob.ok());
  EXPECT_EQ((*blob)->mesh, used);
  EXPECT_EQ(Sha256Hex(*(*blob)->bytes), hash);
}

TEST(GeometryStore, ForgetsAMeshWithItsLastUser) {
  GeometryStore store(kRoomy);
  auto mesh = std::make_shared<const TriangleMesh>(Tetrahedron(3));
  const std::string hash = store.RegisterMesh(mesh);
  ASSERT_TRUE(store.Get(hash).ok());
  EXPECT_EQ(*(*store.Get(hash))->bytes, EncodeMesh(*mesh));
  mesh.reset();
  EXPECT_FALSE(store.Get(hash).ok());
}

TEST(GeometryStore, KnowsAMeshWhileAnyOfItsEqualsLives) {
  GeometryStore store(kRoomy);
  auto first = std::make_shared<const TriangleMesh>(Tetrahedron(5));
  auto second = std::make_shared<const TriangleMesh>(Tetrahedron(5));
  const std::string hash = store.RegisterMesh(first);
  EXPECT_EQ(store.RegisterMesh(second), hash);
  first.reset();
  EXPECT_TRUE(store.Get(hash).ok());
  second.reset();
  EXPECT_FALSE(store.Get(hash).ok());
}

// A client that writes a mesh that an object already uses will read it after the object is gone.
TEST(GeometryStore, HoldsWhatWasWrittenThoughItWasOfferedBefore) {
  GeometryStore store(kRoomy);
  auto mesh = std::make_shared<const TriangleMesh>(Tetrahedron(4));
  store.RegisterMesh(mesh);
  const auto stored = store.Put(BlobFormat::kMeshF64, EncodeMesh(*mesh));
  EXPECT_TRUE(stored->already_known);
  mesh.reset();
  EXPECT_TRUE(store.Get(stored->hash).ok());
}

TEST(GeometryStore, BytesThatCameAsLabelsServeAsAMeshOnceTheyComeAsOne) {
  GeometryStore store(1 << 20);
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  const std::string bytes = EncodeMesh(mesh);
  const std::string hash = store.Put(BlobFormat::kLabelsU32, bytes)->hash;
  EXPECT_EQ((*store.Get(hash))->mesh, nullptr);
  const auto again = store.Put(BlobFormat::kMeshF64, bytes);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_TRUE(again->already_known);
  ASSERT_NE((*store.Get(hash))->mesh, nullptr);
  EXPECT_EQ((*store.Get(hash))->mesh->triangles, mesh.triangles);
  ASSERT_TRUE(store.Put(BlobFormat::kLabelsU32, bytes).ok());
  EXPECT_NE((*store.Get(hash))->mesh, nullptr) << "and stay one";
}

TEST(GeometryStore, WhatIsKnownIsPutAgainByItsHashAlone) {
  GeometryStore store(1 << 20);
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  const std::string hash = store.Put(BlobFormat::kLabelsU32, EncodeMesh(mesh))->hash;
  const auto again = store.Renew(BlobFormat::kMeshF64, hash);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_TRUE(again->already_known);
  EXPECT_NE((*store.Get(hash))->mesh, nullptr);
  EXPECT_EQ(store.Renew(BlobFormat::kMeshF64, "nothing").status().code(),
            absl::StatusCode::kNotFound);
  const std::string labels = store.Put(BlobFormat::kLabelsU32, "1234")->hash;
  EXPECT_EQ(store.Renew(BlobFormat::kMeshF64, labels).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(GeometryStore, EncodesTheMeshOfAnObjectOnceForAllWhoReadIt) {
  GeometryStore store(kRoomy);
  const auto mesh = std::make_shared<const TriangleMesh>(Tetrahedron());
  const std::string hash = store.RegisterMesh(mesh);
  const auto first = store.Get(hash);
  const auto second = store.Get(hash);
  ASSERT_TRUE(first.ok() && second.ok());
  EXPECT_EQ((*first)->bytes, (*second)->bytes) << "the same bytes in memory";
  EXPECT_EQ((*first)->mesh, mesh);
  EXPECT_EQ(store.encoded_count(), 1);
}

TEST(GeometryStore, AKeptEncodingKeepsNoMeshAlive) {
  GeometryStore store(kRoomy);
  auto mesh = std::make_shared<const TriangleMesh>(Tetrahedron());
  const std::weak_ptr<const TriangleMesh> weak = mesh;
  const std::string hash = store.RegisterMesh(mesh);
  ASSERT_TRUE(store.Get(hash).ok());
  mesh = nullptr;
  EXPECT_TRUE(weak.expired());
  EXPECT_FALSE(store.Get(hash).ok());
}

std::shared_ptr<const collision::PreparedModel> PreparedOf(std::vector<Shape> shapes) {
  auto model = std::make_shared<HybridModel>();
  for (Shape& shape : shapes) model->shapes.push_back({.shape = std::move(shape)});
  return collision::Prepare(std::move(model));
}

TEST(GeometryStore, MakesTheSurfaceOfAModelOnceAndNamesItsBytes) {
  GeometryStore store(kRoomy);
  const auto model = PreparedOf({Box{{1, 2, 3}}, Sphere{0.1}});
  const auto surface = store.SurfaceOf(model);
  ASSERT_TRUE(surface.ok()) << surface.status();
  EXPECT_EQ((*surface)->hash, Sha256Hex((*surface)->bytes));
  EXPECT_GT((*surface)->max_deviation_m, 0);
  const auto mesh = DecodeMesh((*surface)->bytes);
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(mesh->vertices[7], Vector3(0.5, 1, 1.5));
  EXPECT_EQ(*store.SurfaceOf(model), *surface) << "the same in memory";
  EXPECT_EQ(store.encoded_count(), 1);
  // Equal models have equal bytes.
  EXPECT_EQ((*store.SurfaceOf(PreparedOf({Box{{1, 2, 3}}, Sphere{0.1}})))->hash, (*surface)->hash);
  EXPECT_EQ(store.encoded_count(), 2);
}

TEST(GeometryStore, SaysWhyAModelHasNoSurface) {
  GeometryStore store(kRoomy, {.max_mesh_triangles = 20});
  const auto ground = store.SurfaceOf(PreparedOf({HalfSpace{}}));
  EXPECT_EQ(ground.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(DetailsOf(ground.status()).reason, "SURFACE_UNBOUNDED");
  EXPECT_TRUE(store.SurfaceOf(PreparedOf({Box{{1, 1, 1}}})).ok());
  const auto boxes = store.SurfaceOf(PreparedOf({Box{{1, 1, 1}}, Box{{2, 2, 2}}}));
  EXPECT_EQ(boxes.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(DetailsOf(boxes.status()).reason, "GEOMETRY_TOO_LARGE");
}

}  // namespace
}  // namespace cwm::server
