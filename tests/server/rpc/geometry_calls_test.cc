#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "proto/transfer/sha256.h"
#include "server/core/geometry_store.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

using ::testing::HasSubstr;

class GeometryTest : public RunningServer {
 protected:
  using Chunk = v1::WriteGeometryRequest::Chunk;

  static Chunk ChunkOf(const std::string& bytes, std::size_t offset, std::size_t size) {
    Chunk chunk;
    chunk.set_offset(static_cast<std::int64_t>(offset));
    chunk.set_data(bytes.substr(offset, size));
    return chunk;
  }
  static std::vector<Chunk> Chunks(const std::string& bytes) {
    constexpr std::size_t kChunk = 1 << 20;
    std::vector<Chunk> chunks;
    for (std::size_t at = 0; at < bytes.size(); at += kChunk) {
      chunks.push_back(ChunkOf(bytes, at, kChunk));
    }
    return chunks;
  }
  grpc::Status Write(const v1::WriteGeometryRequest::Header& header,
                     const std::vector<Chunk>& chunks, v1::WriteGeometryResponse* response) {
    Call call;
    const auto writer = world_->WriteGeometry(&call, response);
    v1::WriteGeometryRequest request;
    *request.mutable_header() = header;
    bool open = writer->Write(request);
    for (const Chunk& chunk : chunks) {
      *request.mutable_chunk() = chunk;
      open = open && writer->Write(request);
    }
    writer->WritesDone();
    return writer->Finish();
  }
  static v1::WriteGeometryRequest::Header HeaderOf(const std::string& bytes) {
    v1::WriteGeometryRequest::Header header;
    header.set_total_bytes(static_cast<std::int64_t>(bytes.size()));
    return header;
  }
};

TEST_F(GeometryTest, AMeshComesBackByItsHashInChunks) {
  const std::string bytes = EncodeMesh(Strip(100'000));
  ASSERT_GT(bytes.size(), std::size_t{3} << 20);
  v1::WriteGeometryResponse written;
  auto status = Write(HeaderOf(bytes), Chunks(bytes), &written);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(written.hash(), Sha256Hex(bytes));
  EXPECT_FALSE(written.already_known());
  Call call;
  v1::ReadGeometryRequest request;
  request.set_hash(written.hash());
  const auto reader = world_->ReadGeometry(&call, request);
  std::string received;
  v1::ReadGeometryResponse piece;
  while (reader->Read(&piece)) {
    EXPECT_EQ(piece.offset(), static_cast<std::int64_t>(received.size()));
    EXPECT_LE(piece.data().size(), std::size_t{1} << 20);
    received += piece.data();
  }
  EXPECT_TRUE(reader->Finish().ok());
  EXPECT_TRUE(piece.done());
  EXPECT_EQ(received, bytes);
  ASSERT_TRUE(Write(HeaderOf(bytes), Chunks(bytes), &written).ok());
  EXPECT_TRUE(written.already_known());
}

TEST_F(GeometryTest, AMeshOfAnObjectIsReadableByTheHashItShows) {
  const std::string bytes = EncodeMesh(Strip(4));
  v1::WriteGeometryResponse written;
  ASSERT_TRUE(Write(HeaderOf(bytes), Chunks(bytes), &written).ok());
  v1::ApplyChangesRequest request;
  v1::Object* object = request.add_changes()->mutable_put()->mutable_object();
  object->set_name("sheet");
  object->add_shapes()->mutable_mesh()->set_hash(written.hash());
  v1::ApplyChangesResponse applied;
  Call apply;
  auto status = world_->ApplyChanges(&apply, request, &applied);
  ASSERT_TRUE(status.ok()) << status.error_message();
  Call call;
  v1::GetObjectRequest get;
  get.set_name("sheet");
  v1::GetObjectResponse got;
  ASSERT_TRUE(world_->GetObject(&call, get, &got).ok());
  EXPECT_EQ(got.object().shapes(0).mesh().hash(), written.hash());
}

TEST_F(GeometryTest, BrokenUploadsAreRefusedByTheirField) {
  const std::string bytes = EncodeMesh(Strip(100));
  const std::size_t half = bytes.size() / 2;
  const Chunk first = ChunkOf(bytes, 0, half);
  const Chunk second = ChunkOf(bytes, half, bytes.size());
  v1::WriteGeometryResponse response;
  EXPECT_EQ(FieldIn(Write(HeaderOf(bytes), {second, first}, &response)), "chunk.offset");
  EXPECT_EQ(FieldIn(Write(HeaderOf(bytes), {first, first}, &response)), "chunk.offset");
  EXPECT_EQ(FieldIn(Write(HeaderOf(bytes), {first, second, second}, &response)), "chunk.offset");
  EXPECT_THAT(Write(HeaderOf(bytes), {first}, &response).error_message(),
              HasSubstr("must come after all"));
  auto lying = HeaderOf(bytes);
  lying.set_total_bytes(std::int64_t{1} << 60);
  EXPECT_EQ(FieldIn(Write(lying, {}, &response)), "header.total_bytes");
  auto wrong_hash = HeaderOf(bytes);
  wrong_hash.set_hash(std::string(64, '0'));
  EXPECT_EQ(FieldIn(Write(wrong_hash, {first, second}, &response)), "header.hash");
  EXPECT_TRUE(Write(HeaderOf(bytes), {first, second}, &response).ok());
}

TEST_F(GeometryTest, BrokenMeshesAreRefused) {
  v1::WriteGeometryResponse response;
  TriangleMesh bad_index = Strip(4);
  bad_index.triangles[0][2] = 99;
  TriangleMesh no_triangles = Strip(4);
  no_triangles.triangles.clear();
  TriangleMesh not_finite = Strip(4);
  not_finite.vertices[1].y() = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<std::string, std::string>> cases = {
      {EncodeMesh(bad_index), "mesh.triangles[0]"},
      {EncodeMesh(no_triangles), "mesh.triangles"},
      {EncodeMesh(not_finite), "mesh.vertices[1].y"},
      {"short", "mesh"},
  };
  for (const auto& [bytes, field] : cases) {
    const grpc::Status status = Write(HeaderOf(bytes), Chunks(bytes), &response);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << status.error_message();
    EXPECT_EQ(FieldIn(status), field) << status.error_message();
  }
}

TEST_F(GeometryTest, MeshesThatAreNoSolidsAreRefusedWhereASolidIsPut) {
  const std::string flat = EncodeMesh(Strip(4));
  v1::WriteGeometryResponse written;
  ASSERT_TRUE(Write(HeaderOf(flat), Chunks(flat), &written).ok());
  const auto put = [&](const std::string& hash) {
    v1::ApplyChangesRequest request;
    v1::Object* object = request.add_changes()->mutable_put()->mutable_object();
    object->set_name("hull");
    object->add_shapes()->mutable_convex()->set_hash(hash);
    v1::ApplyChangesResponse response;
    Call call;
    return world_->ApplyChanges(&call, request, &response);
  };
  const std::string field = "changes[0].put.object.shapes[0].convex.hash";
  EXPECT_EQ(FieldIn(put(written.hash())), field) << "a flat hull";
  const grpc::Status unknown = put(std::string(64, '0'));
  EXPECT_EQ(unknown.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(ReasonIn(unknown), "GEOMETRY_UNKNOWN");
  EXPECT_EQ(FieldIn(unknown), field);
}

TEST_F(GeometryTest, AKnownHashIsAnsweredWithoutTheData) {
  const std::string bytes = EncodeMesh(Strip(100));
  auto header = HeaderOf(bytes);
  v1::WriteGeometryResponse response;
  ASSERT_TRUE(Write(header, Chunks(bytes), &response).ok());
  header.set_hash(response.hash());
  {
    // No data and no half-close: the answer comes after the header alone.
    Call call(std::chrono::seconds(10));
    const auto writer = world_->WriteGeometry(&call, &response);
    v1::WriteGeometryRequest request;
    *request.mutable_header() = header;
    ASSERT_TRUE(writer->Write(request));
    const grpc::Status status = writer->Finish();
    ASSERT_TRUE(status.ok()) << status.error_message();
    EXPECT_TRUE(response.already_known());
    EXPECT_EQ(response.hash(), header.hash());
  }
  header.set_total_bytes(header.total_bytes() + 1);
  EXPECT_EQ(FieldIn(Write(header, {}, &response)), "header.total_bytes");
  // The data of an unknown blob is received as usual.
  const std::string other = EncodeMesh(Strip(50));
  header = HeaderOf(other);
  header.set_hash(Sha256Hex(other));
  ASSERT_TRUE(Write(header, Chunks(other), &response).ok());
  EXPECT_FALSE(response.already_known());
}

TEST_F(GeometryTest, BytesThatCameAsLabelsServeAsAMeshOnceTheyComeAsOne) {
  const std::string bytes = EncodeMesh(Strip(4));
  auto header = HeaderOf(bytes);
  header.set_format(v1::GEOMETRY_FORMAT_LABELS_U32);
  v1::WriteGeometryResponse response;
  ASSERT_TRUE(Write(header, Chunks(bytes), &response).ok());
  v1::ApplyChangesRequest put;
  v1::Object* object = put.add_changes()->mutable_put()->mutable_object();
  object->set_name("sheet");
  object->add_shapes()->mutable_mesh()->set_hash(response.hash());
  v1::ApplyChangesResponse applied;
  {
    Call call;
    EXPECT_EQ(FieldIn(world_->ApplyChanges(&call, put, &applied)),
              "changes[0].put.object.shapes[0].mesh.hash");
  }
  header.set_format(v1::GEOMETRY_FORMAT_MESH_F64);
  header.set_hash(response.hash());
  ASSERT_TRUE(Write(header, {}, &response).ok());
  Call call;
  EXPECT_TRUE(world_->ApplyChanges(&call, put, &applied).ok());
}

TEST_F(GeometryTest, AnUnknownHashIsNotFound) {
  Call call;
  v1::ReadGeometryRequest request;
  request.set_hash("nothing");
  const auto reader = world_->ReadGeometry(&call, request);
  v1::ReadGeometryResponse piece;
  EXPECT_FALSE(reader->Read(&piece));
  EXPECT_EQ(ReasonIn(reader->Finish()), "GEOMETRY_UNKNOWN");
}

}  // namespace
}  // namespace cwm::server
