// ReadGeometry of an object's full surface, over a real socket.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "collision/geometry/tessellate.h"
#include "proto/transfer/mesh_bytes.h"
#include "proto/transfer/sha256.h"
#include "server/core/geometry_store.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

using ::testing::HasSubstr;

struct Read {
  grpc::Status status;
  v1::GeometryHeader header;
  std::int64_t first_offset = -1;
  std::string bytes;
  int headers = 0;
  bool done = false;
};

class ObjectSurfaceTest : public RunningServer {
 protected:
  Read ReadOf(const v1::ReadGeometryRequest& request) {
    Call call;
    const auto reader = world_->ReadGeometry(&call, request);
    Read read;
    v1::ReadGeometryResponse piece;
    while (reader->Read(&piece)) {
      if (read.first_offset < 0) read.first_offset = piece.offset();
      EXPECT_EQ(piece.offset(), read.first_offset + static_cast<std::int64_t>(read.bytes.size()));
      if (piece.has_header()) ++read.headers;
      if (piece.has_header()) read.header = piece.header();
      read.bytes += piece.data();
      read.done = piece.done();
    }
    read.status = reader->Finish();
    return read;
  }
  static v1::ReadGeometryRequest SurfaceOf(const std::string& name, std::int64_t exact = -1) {
    v1::ReadGeometryRequest request;
    request.mutable_object()->set_name(name);
    if (exact >= 0) request.mutable_object()->mutable_at_revision()->set_exact(exact);
    return request;
  }
  std::int64_t Put(const v1::Object& object) {
    Call call;
    v1::ApplyChangesRequest request;
    *request.add_changes()->mutable_put()->mutable_object() = object;
    v1::ApplyChangesResponse response;
    const grpc::Status status = world_->ApplyChanges(&call, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response.revision();
  }
  // Puts an object whose mesh takes more than two chunks.
  std::int64_t PutBalls(const std::string& name) {
    v1::Object object;
    object.set_name(name);
    for (int i = 0; i < 60; ++i) {
      v1::ShapePart* part = object.add_shapes();
      part->mutable_x_object_shape()->set_tx_m(i);
      part->mutable_x_object_shape()->set_qw(1);
      part->mutable_sphere()->set_radius_m(0.4);
    }
    return Put(object);
  }
};

TEST_F(ObjectSurfaceTest, ComesInTheObjectsFrameWithWhatItIs) {
  const std::int64_t revision = PutBox("crate", 7);
  const Read read = ReadOf(SurfaceOf("crate"));
  ASSERT_TRUE(read.status.ok()) << read.status.error_message();
  EXPECT_TRUE(read.done);
  const auto mesh = DecodeMesh(read.bytes);
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(*mesh, Tessellate(Box{{0.2, 0.2, 0.2}}));
  EXPECT_EQ(read.header.hash(), Sha256Hex(read.bytes));
  EXPECT_EQ(read.header.vertex_count(), 8);
  EXPECT_EQ(read.header.triangle_count(), 12);
  EXPECT_EQ(read.header.revision(), revision);
  EXPECT_EQ(read.header.world_uid(), (*application_.worlds.Find("default"))->uid());
  EXPECT_EQ(read.header.x_world_object().tx_m(), 7);
  EXPECT_EQ(read.header.max_deviation_m(), 0);
}

TEST_F(ObjectSurfaceTest, JoinsShapesAndMeasuredSurfacesAndStatesItsDeviation) {
  TriangleMesh scrap;
  scrap.vertices = {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
  scrap.triangles = {{0, 1, 2}};
  const auto stored = application_.geometry.Put(BlobFormat::kMeshF64, EncodeMesh(scrap));
  v1::Object object;
  object.set_name("mug");
  object.add_shapes()->mutable_cylinder()->set_radius_m(0.04);
  object.mutable_shapes(0)->mutable_cylinder()->set_length_m(0.1);
  object.add_surfaces()->set_hash(stored->hash);
  Put(object);
  const Read read = ReadOf(SurfaceOf("mug"));
  ASSERT_TRUE(read.status.ok()) << read.status.error_message();
  const auto mesh = DecodeMesh(read.bytes);
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  const TriangleMesh cup = Tessellate(Cylinder{0.04, 0.1});
  ASSERT_EQ(mesh->vertices.size(), cup.vertices.size() + 3);
  EXPECT_EQ(mesh->vertices.back(), Vector3(0, 1, 1));
  EXPECT_EQ(read.header.max_deviation_m(), DeviationBound_m(Cylinder{0.04, 0.1}));
}

TEST_F(ObjectSurfaceTest, IsThatOfTheRevisionAskedFor) {
  const std::int64_t small = PutBox("thing", 0);
  v1::Object object;
  object.set_name("thing");
  object.add_shapes()->mutable_sphere()->set_radius_m(1);
  const std::int64_t round = Put(object);
  const Read then = ReadOf(SurfaceOf("thing", small));
  EXPECT_EQ(then.header.triangle_count(), 12);
  EXPECT_EQ(then.header.revision(), small);
  const Read now = ReadOf(SurfaceOf("thing", round));
  EXPECT_GT(now.header.triangle_count(), 100);
  const Read never = ReadOf(SurfaceOf("thing", round + 1));
  EXPECT_EQ(never.status.error_code(), grpc::StatusCode::OUT_OF_RANGE);
  EXPECT_EQ(ReasonIn(never.status), "REVISION_IN_FUTURE");
}

TEST_F(ObjectSurfaceTest, WaitsForTheRevisionAskedFor) {
  const std::int64_t revision = PutBox("first", 0);
  v1::ReadGeometryRequest request = SurfaceOf("second");
  request.mutable_object()->mutable_at_revision()->set_at_least(revision + 1);
  std::thread writer([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    PutBox("second", 1);
  });
  const Read read = ReadOf(request);
  writer.join();
  ASSERT_TRUE(read.status.ok()) << read.status.error_message();
  EXPECT_EQ(read.header.revision(), revision + 1);
}

TEST_F(ObjectSurfaceTest, GoesOnWhereAReplyBrokeOffWithoutBeingMadeAgain) {
  PutBalls("balls");
  const Read whole = ReadOf(SurfaceOf("balls"));
  ASSERT_TRUE(whole.status.ok()) << whole.status.error_message();
  ASSERT_GT(whole.bytes.size(), std::size_t{2} << 20);
  EXPECT_EQ(whole.headers, 1) << "in the first message alone";
  const std::int64_t made = application_.geometry.encoded_count();
  for (const std::int64_t offset : {std::int64_t{0}, std::int64_t{1}, std::int64_t{1} << 20,
                                    static_cast<std::int64_t>(whole.bytes.size()) - 1,
                                    static_cast<std::int64_t>(whole.bytes.size())}) {
    v1::ReadGeometryRequest request = SurfaceOf("balls");
    request.set_offset(offset);
    const Read rest = ReadOf(request);
    ASSERT_TRUE(rest.status.ok()) << rest.status.error_message();
    EXPECT_EQ(rest.first_offset, offset);
    EXPECT_EQ(rest.bytes, whole.bytes.substr(static_cast<std::size_t>(offset)));
    EXPECT_EQ(rest.header.hash(), whole.header.hash());
    EXPECT_TRUE(rest.done);
  }
  EXPECT_EQ(application_.geometry.encoded_count(), made);
  for (const std::int64_t beyond :
       {std::int64_t{-1}, static_cast<std::int64_t>(whole.bytes.size()) + 1}) {
    v1::ReadGeometryRequest request = SurfaceOf("balls");
    request.set_offset(beyond);
    const Read refused = ReadOf(request);
    EXPECT_EQ(refused.status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
    EXPECT_EQ(FieldIn(refused.status), "offset");
  }
}

TEST_F(ObjectSurfaceTest, ABlobByItsHashCanBeReadInRangesAsWell) {
  const auto stored =
      application_.geometry.Put(BlobFormat::kMeshF64, EncodeMesh(Tessellate(Box{{1, 1, 1}})));
  v1::ReadGeometryRequest request;
  request.set_hash(stored->hash);
  const Read whole = ReadOf(request);
  EXPECT_EQ(whole.header.hash(), stored->hash);
  EXPECT_EQ(whole.header.triangle_count(), 12);
  EXPECT_FALSE(whole.header.has_x_world_object());
  request.set_offset(100);
  EXPECT_EQ(ReadOf(request).bytes, whole.bytes.substr(100));
}

TEST_F(ObjectSurfaceTest, RefusalsNameWhatIsWrong) {
  PutBox("crate", 0);
  v1::ReadGeometryRequest neither;
  v1::ReadGeometryRequest both = SurfaceOf("crate");
  both.set_hash(std::string(64, '0'));
  for (const auto& request : {neither, both}) {
    const Read read = ReadOf(request);
    EXPECT_EQ(read.status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
    const Details details = DetailsIn(read.status);
    ASSERT_EQ(details.bad_request.field_violations_size(), 2) << read.status.error_message();
    EXPECT_EQ(details.bad_request.field_violations(0).field(), "hash");
    EXPECT_EQ(details.bad_request.field_violations(1).field(), "object");
    EXPECT_THAT(read.status.error_message(), HasSubstr("exactly one of hash and object"));
  }
  EXPECT_EQ(FieldIn(ReadOf(SurfaceOf("")).status), "object.name");
  const Read unknown = ReadOf(SurfaceOf("nothing"));
  EXPECT_EQ(unknown.status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(ReasonIn(unknown.status), "OBJECT_UNKNOWN");
  v1::ReadGeometryRequest elsewhere = SurfaceOf("crate");
  elsewhere.mutable_object()->set_world("nowhere");
  EXPECT_EQ(ReasonIn(ReadOf(elsewhere).status), "WORLD_UNKNOWN");
  v1::ReadGeometryRequest replaced = SurfaceOf("crate");
  replaced.mutable_object()->set_world_uid("another");
  EXPECT_EQ(ReasonIn(ReadOf(replaced).status), "WORLD_REPLACED");
  v1::ReadGeometryRequest negative = SurfaceOf("crate");
  negative.mutable_object()->mutable_at_revision()->set_at_least(-1);
  EXPECT_EQ(FieldIn(ReadOf(negative).status), "object.at_revision.at_least");
  v1::Object ground;
  ground.set_name("ground");
  ground.add_shapes()->mutable_half_space();
  Put(ground);
  const Read unbounded = ReadOf(SurfaceOf("ground"));
  EXPECT_EQ(unbounded.status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(ReasonIn(unbounded.status), "SURFACE_UNBOUNDED");
  EXPECT_THAT(unbounded.status.error_message(), HasSubstr("half-space"));
}

}  // namespace
}  // namespace cwm::server
