#include "clients/cpp/call_error.h"

#include <gmock/gmock.h>

#include "cwm/v1/error_details.pb.h"

namespace cwm::client {
namespace {

template <class Message>
void Pack(const Message& message, const std::string& name, cwm::v1::Status& status) {
  auto& any = *status.add_details();
  any.set_type_url("type.googleapis.com/google.rpc." + name);
  any.set_value(message.SerializeAsString());
}

TEST(CallError, KeepsCodeMessageReasonFieldsAndRetry) {
  cwm::v1::ErrorInfo info;
  info.set_reason("QUEUE_FULL");
  (*info.mutable_metadata())["queue"] = "ingest";
  cwm::v1::BadRequest request;
  request.add_field_violations()->set_field("box.size_x_m");
  request.mutable_field_violations(0)->set_description("is -1, must be positive");
  cwm::v1::RetryInfo retry;
  retry.mutable_retry_delay()->set_seconds(2);
  retry.mutable_retry_delay()->set_nanos(500'000'000);
  cwm::v1::Status packed;
  Pack(info, "ErrorInfo", packed);
  Pack(request, "BadRequest", packed);
  Pack(retry, "RetryInfo", packed);

  const absl::Status status = StatusFromGrpc(
      grpc::Status(grpc::StatusCode::RESOURCE_EXHAUSTED, "busy", packed.SerializeAsString()));
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(status.message(), "busy");
  const ErrorDetails details = DetailsOf(status);
  EXPECT_EQ(details.reason, "QUEUE_FULL");
  EXPECT_EQ(details.metadata.at("queue"), "ingest");
  ASSERT_EQ(details.fields.size(), 1u);
  EXPECT_EQ(details.fields[0].field, "box.size_x_m");
  EXPECT_EQ(details.fields[0].description, "is -1, must be positive");
  EXPECT_EQ(details.retry_after_s, 2.5);
  // People read all of it in the text of the status.
  const std::string text = status.ToString();
  for (const char* part : {"RESOURCE_EXHAUSTED: busy", "[reason='QUEUE_FULL']",
                           "box.size_x_m='is -1, must be positive'", "[metadata queue='ingest']",
                           "[retry_after_s='2.5']"}) {
    EXPECT_THAT(text, ::testing::HasSubstr(part));
  }
  EXPECT_THAT(text, ::testing::Not(::testing::HasSubstr("type.googleapis.com")));

  const Error error = ErrorFromStatus(status);
  EXPECT_EQ(error.code(), ErrorCode::kResourceExhausted);
  EXPECT_STREQ(error.what(), "busy; box.size_x_m: is -1, must be positive (QUEUE_FULL)");
  EXPECT_EQ(StatusFromError(error), status);
}

TEST(CallError, KeepsTheOrderOfManyFields) {
  ErrorDetails given;
  for (int i = 0; i < 30; ++i) given.fields.push_back({"rows", std::to_string(i)});
  const ErrorDetails read =
      DetailsOf(MakeStatus(absl::StatusCode::kInvalidArgument, "many", given));
  ASSERT_EQ(read.fields.size(), given.fields.size());
  for (std::size_t i = 0; i < given.fields.size(); ++i) {
    EXPECT_EQ(read.fields[i].field, "rows");
    EXPECT_EQ(read.fields[i].description, given.fields[i].description);
  }
}

TEST(CallError, LivesWithoutAndWithBrokenDetails) {
  EXPECT_TRUE(StatusFromGrpc(grpc::Status::OK).ok());
  EXPECT_EQ(DetailsOf(StatusFromGrpc(grpc::Status(grpc::StatusCode::NOT_FOUND, "x"))).reason, "");
  const auto broken =
      StatusFromGrpc(grpc::Status(grpc::StatusCode::NOT_FOUND, "x", "\xff\xff\xff"));
  EXPECT_EQ(DetailsOf(broken).reason, "");
  EXPECT_EQ(broken.code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace cwm::client
