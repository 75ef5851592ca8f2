// Parsing of requests observes the time budget of their call.
#include "server/rpc/messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stop_token>
#include <string>

#include "cwm/v1/world.pb.h"
#include "server/core/limits.h"

namespace cwm::server {
namespace {

grpc::ByteBuffer BufferOf(const std::string& bytes) {
  const grpc::Slice slice(bytes);
  return grpc::ByteBuffer(&slice, 1);
}

v1::ApplyChangesRequest ManyMoves(int count) {
  v1::ApplyChangesRequest request;
  request.set_world("main");
  for (int k = 0; k < count; ++k) {
    v1::MoveObject& move = *request.add_changes()->mutable_move();
    move.set_name("object_" + std::to_string(k));
    move.mutable_x_world_object()->set_tx_m(k);
  }
  return request;
}

TEST(ParseRequest, FillsTheMessageAndFreesTheBytes) {
  const v1::ApplyChangesRequest sent = ManyMoves(5000);  // several pieces
  grpc::ByteBuffer bytes = BufferOf(sent.SerializeAsString());
  v1::ApplyChangesRequest received;
  WorkBudget unlimited;
  ASSERT_TRUE(ParseRequest(bytes, &received, &unlimited).ok());
  EXPECT_EQ(received.SerializeAsString(), sent.SerializeAsString());
  EXPECT_EQ(bytes.Length(), 0u);
  EXPECT_GE(unlimited.check_count(), 4);
}

TEST(ParseRequest, EndsWithTheCall) {
  const std::string sent = ManyMoves(5000).SerializeAsString();
  std::stop_source stop;
  stop.request_stop();
  WorkBudget cancelled(Clock::time_point::max(), stop.get_token());
  grpc::ByteBuffer bytes = BufferOf(sent);
  v1::ApplyChangesRequest received;
  EXPECT_TRUE(absl::IsCancelled(ParseRequest(bytes, &received, &cancelled)));
  EXPECT_EQ(cancelled.check_count(), 1);
  EXPECT_EQ(bytes.Length(), 0u);

  WorkBudget late(Clock::now() - std::chrono::seconds(1), std::stop_token());
  bytes = BufferOf(sent);
  EXPECT_TRUE(absl::IsDeadlineExceeded(ParseRequest(bytes, &received, &late)));
}

TEST(ParseRequest, DropsUnknownFieldsAtEveryDepth) {
  v1::ApplyChangesRequest sent = ManyMoves(2);
  const std::string clean = sent.SerializeAsString();
  const auto add_unknown = [](google::protobuf::Message& message) {
    message.GetReflection()->MutableUnknownFields(&message)->AddVarint(1000, 7);
  };
  add_unknown(sent);
  add_unknown(*sent.mutable_changes(1));
  add_unknown(*sent.mutable_changes(1)->mutable_move()->mutable_x_world_object());
  grpc::ByteBuffer bytes = BufferOf(sent.SerializeAsString());
  ASSERT_GT(bytes.Length(), clean.size());
  v1::ApplyChangesRequest received;
  WorkBudget unlimited;
  ASSERT_TRUE(ParseRequest(bytes, &received, &unlimited).ok());
  EXPECT_EQ(received.SerializeAsString(), clean);
}

}  // namespace
}  // namespace cwm::server
