// Bytes that are not a message of the method's type, for every method.
#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <grpcpp/generic/generic_stub.h>
#include <gtest/gtest.h>

#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

using ::testing::HasSubstr;

constexpr char kNoMessage[] = "\xff\xff\xff";  // the beginning of a tag

class MalformedRequestTest : public RunningServer {
 protected:
  // The result of a call that sends these messages and then closes.
  struct Answer {
    grpc::Status status;
    std::vector<std::string> messages;
  };
  Answer Send(const std::string& method, const std::vector<std::string>& messages) {
    Call call;
    grpc::CompletionQueue queue;
    const auto wait = [&queue] {
      void* tag = nullptr;
      bool ok = false;
      return queue.Next(&tag, &ok) && ok;
    };
    const auto stream = stub_.PrepareCall(&call, method, &queue);
    stream->StartCall(nullptr);
    bool is_open = wait();
    for (const std::string& message : messages) {
      if (!is_open) break;  // refused already
      const grpc::Slice slice(message);
      stream->Write(grpc::ByteBuffer(&slice, 1), nullptr);
      is_open = wait();
    }
    if (is_open) {
      stream->WritesDone(nullptr);
      wait();
    }
    Answer answer;
    for (grpc::ByteBuffer read;;) {
      stream->Read(&read, nullptr);
      if (!wait()) break;
      grpc::Slice slice;
      EXPECT_TRUE(read.DumpToSingleSlice(&slice).ok());
      answer.messages.emplace_back(reinterpret_cast<const char*>(slice.begin()), slice.size());
    }
    stream->Finish(&answer.status, nullptr);
    wait();
    return answer;
  }
  static void ExpectMalformed(const grpc::Status& status, const std::string& method) {
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << status.error_message();
    EXPECT_THAT(status.error_message(), HasSubstr(method));
    const Details details = DetailsIn(status);
    EXPECT_EQ(details.info.reason(), "MALFORMED_REQUEST");
    EXPECT_EQ(details.info.domain(), "cwm");
    EXPECT_EQ(details.info.metadata().at("method"), method);
  }

  grpc::GenericStub stub_{Dial()};
};

TEST_F(MalformedRequestTest, IsRefusedByEveryMethodWithItsName) {
  PutBox("a", 0);
  int methods = 0;
  for (const char* name : {"cwm.v1.AdminService", "cwm.v1.PerceptionService", "cwm.v1.QueryService",
                           "cwm.v1.RobotService", "cwm.v1.WorldService"}) {
    const auto* service =
        google::protobuf::DescriptorPool::generated_pool()->FindServiceByName(name);
    ASSERT_NE(service, nullptr);
    for (int i = 0; i < service->method_count(); ++i) {
      const std::string method = std::string("/") + name + "/" + service->method(i)->name();
      SCOPED_TRACE(method);
      const Answer answer = Send(method, {kNoMessage});
      ExpectMalformed(answer.status, method);
      EXPECT_THAT(answer.status.error_message(),
                  HasSubstr(service->method(i)->input_type()->full_name()));
      EXPECT_TRUE(answer.messages.empty());
      ++methods;
    }
  }
  EXPECT_GT(methods, 20);
  ExpectRevision(1);
}

TEST_F(MalformedRequestTest, AnUploadEndsAtOnceWhateverCameBefore) {
  v1::IngestCloudRequest cloud;
  cloud.mutable_header()->set_total_bytes(12);
  cloud.mutable_header()->set_point_count(1);
  cloud.mutable_header()->mutable_layout()->set_point_step(12);
  const char* const names[] = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis) {
    v1::CloudField* field = cloud.mutable_header()->mutable_layout()->add_fields();
    field->set_name(names[axis]);
    field->set_offset(4 * axis);
    field->set_type(v1::FIELD_TYPE_F32);
  }
  v1::LoadRobotRequest robot;
  robot.mutable_header()->set_name("r");
  robot.mutable_header()->set_urdf("<robot name=\"r\"><link name=\"a\"/></robot>");
  v1::WriteGeometryRequest geometry;
  geometry.mutable_header()->set_format(v1::GEOMETRY_FORMAT_POINTS_F32);
  geometry.mutable_header()->set_total_bytes(12);
  const std::pair<const char*, std::string> uploads[] = {
      {"/cwm.v1.PerceptionService/IngestCloud", cloud.SerializeAsString()},
      {"/cwm.v1.RobotService/LoadRobot", robot.SerializeAsString()},
      {"/cwm.v1.WorldService/WriteGeometry", geometry.SerializeAsString()}};
  for (const auto& [method, header] : uploads) {
    SCOPED_TRACE(method);
    EXPECT_EQ(Send(method, {header}).status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
    EXPECT_NE(ReasonIn(Send(method, {header}).status), "MALFORMED_REQUEST");
    ExpectMalformed(Send(method, {header, kNoMessage}).status, method);
  }
}

TEST_F(MalformedRequestTest, AStreamAnswersWhatCameBeforeAndEndsWithTheRefusal) {
  PutBox("a", 0);
  v1::StreamQueriesRequest query;
  query.set_id(7);
  *query.mutable_check_collisions()->mutable_subject() = SphereAt({0});
  const std::string good = query.SerializeAsString();
  const std::string method = "/cwm.v1.QueryService/StreamQueries";
  // The last message may be read before, while or after the bad one is refused.
  for (int repetition = 0; repetition < 100; ++repetition) {
    const Answer answer = Send(method, {good, kNoMessage, good});
    ExpectMalformed(answer.status, method);
    ASSERT_EQ(answer.messages.size(), 1U);
    v1::StreamQueriesResponse response;
    ASSERT_TRUE(response.ParseFromString(answer.messages[0]));
    EXPECT_EQ(response.id(), 7);
    EXPECT_FALSE(response.has_error());
  }
  EXPECT_TRUE(Send(method, {good}).status.ok());
}

TEST_F(MalformedRequestTest, AMethodThatIsNotThereStaysUnimplemented) {
  EXPECT_EQ(Send("/cwm.v1.WorldService/Nothing", {kNoMessage}).status.error_code(),
            grpc::StatusCode::UNIMPLEMENTED);
}

// The stream keeps its request, and a client may have hundreds of streams.
TEST_F(MalformedRequestTest, RequestsOfStreamsThatAreLargeAreRefused) {
  const std::string large(std::size_t{1} << 20, 'a');
  const auto expect_refused = [](const grpc::Status& status) {
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
    EXPECT_EQ(ReasonIn(status), "REQUEST_TOO_LARGE") << status.error_message();
  };
  Call watching, reading, exporting;
  v1::WatchWorldRequest watch;
  watch.set_world(large);
  expect_refused(world_->WatchWorld(&watching, watch)->Finish());
  v1::ReadGeometryRequest read;
  read.set_hash(large);
  expect_refused(world_->ReadGeometry(&reading, read)->Finish());
  v1::ExportWorldRequest to_export;
  to_export.set_robot(large);
  expect_refused(world_->ExportWorld(&exporting, to_export)->Finish());
}

}  // namespace
}  // namespace cwm::server
