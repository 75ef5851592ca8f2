// Small requests that refer to large meshes many times.
#include <string>

#include "gtest/gtest.h"
#include "tests/server/core/spindle.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

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
