// Small requests that refer to large meshes many times.
#include <cmath>
#include <numbers>
#include <string>

#include "gtest/gtest.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

// A closed mesh of 2 * `sides` triangles.
TriangleMesh Spindle(std::uint32_t sides) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 1}, {0, 0, -1}};
  for (std::uint32_t i = 0; i < sides; ++i) {
    const double angle = 2 * std::numbers::pi * i / sides;
    mesh.vertices.emplace_back(std::cos(angle), std::sin(angle), 0);
    const std::uint32_t a = 2 + i, b = 2 + (i + 1) % sides;
    mesh.triangles.push_back({0, a, b});
    mesh.triangles.push_back({1, b, a});
  }
  return mesh;
}

class MentionsTest : public RunningServer {
 protected:
  static constexpr int kMentions = 600;  // 42 kB

  std::string Store(std::uint32_t sides) {
    const auto stored = application_.geometry.Put(BlobFormat::kMeshF64, EncodeMesh(Spindle(sides)));
    EXPECT_TRUE(stored.ok()) << stored.status();
    return stored->hash;
  }
  int Computed(const std::string& hash) {
    return application_.geometry.FindMesh(hash)->facts->computed();
  }

  static v1::ApplyChangesRequest PutOf(const std::string& hash) {
    v1::ApplyChangesRequest request;
    v1::Object& object = *request.add_changes()->mutable_put()->mutable_object();
    object.set_name("pile");
    for (int i = 0; i < kMentions; ++i) object.add_shapes()->mutable_mesh()->set_hash(hash);
    return request;
  }
};

TEST_F(MentionsTest, OfOneMeshInWritesAndQueriesPrepareItOnce) {
  const std::string hash = Store(10'000);
  for (int i = 0; i < 2; ++i) {
    Call call;
    v1::ApplyChangesResponse response;
    const grpc::Status status = world_->ApplyChanges(&call, PutOf(hash), &response);
    ASSERT_TRUE(status.ok()) << status.error_message();
    EXPECT_EQ(Computed(hash), 1);
  }
  v1::CheckCollisionsRequest request;
  v1::Subject::Shapes& shapes = *request.mutable_subject()->mutable_shapes();
  for (int i = 0; i < kMentions; ++i) shapes.add_shapes()->mutable_mesh()->set_hash(hash);
  shapes.mutable_x_world_body()->set_data(std::string(6 * sizeof(double), '\0') +
                                          std::string("\0\0\0\0\0\0\xf0\x3f", sizeof(double)));
  Call call;
  v1::CheckCollisionsResponse response;
  const grpc::Status status = query_->CheckCollisions(&call, request, &response);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(Computed(hash), 1);
}

// The next call completes a computation that was interrupted.
TEST_F(MentionsTest, PastItsDeadlineAWriteHasNoEffectAndTheNextOneHas) {
  const std::string hash = Store(50'000);
  Call hurried(std::chrono::milliseconds(20));
  v1::ApplyChangesResponse response;
  const grpc::Status late = world_->ApplyChanges(&hurried, PutOf(hash), &response);
  EXPECT_EQ(late.error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  Call call;
  const grpc::Status status = world_->ApplyChanges(&call, PutOf(hash), &response);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(response.revision(), 1);
}

}  // namespace
}  // namespace cwm::server
