#include "server/rpc/status_conversion.h"

#include <gtest/gtest.h>

#include "server/core/error.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

TEST(StatusConversion, OkStaysOk) { EXPECT_TRUE(ToGrpcStatus(absl::OkStatus()).ok()); }

TEST(StatusConversion, EveryCodeKeepsItsNumber) {
  for (int code = 1; code <= 16; ++code) {
    const absl::Status status(static_cast<absl::StatusCode>(code), "why");
    const grpc::Status converted = ToGrpcStatus(status);
    EXPECT_EQ(static_cast<int>(converted.error_code()), code);
    EXPECT_EQ(converted.error_message(), "why");
    // Every error has a reason for programs.
    EXPECT_EQ(ReasonIn(converted), absl::StatusCodeToString(status.code()));
    v1::Status packed;
    ASSERT_TRUE(packed.ParseFromString(converted.error_details()));
    EXPECT_EQ(packed.code(), code);
    EXPECT_EQ(packed.message(), "why");
  }
}

TEST(StatusConversion, DetailsArePackedUnderTheTypesOfGoogleRpc) {
  const absl::Status status = MakeError(absl::StatusCode::kInvalidArgument, "bad",
                                        {.reason = "INVALID_FIELD",
                                         .fields = {{"a.b", "is 1, must be 2"}},
                                         .metadata = {{"key", "value"}},
                                         .retry_after_s = 1.5});
  const Details details = DetailsIn(ToGrpcStatus(status));
  EXPECT_EQ(details.info.reason(), "INVALID_FIELD");
  EXPECT_EQ(details.info.domain(), "cwm");
  EXPECT_EQ(details.info.metadata().at("key"), "value");
  EXPECT_EQ(details.bad_request.field_violations(0).field(), "a.b");
  EXPECT_EQ(details.bad_request.field_violations(0).description(), "is 1, must be 2");
  EXPECT_TRUE(details.has_retry);
}

TEST(StatusConversion, AMessageOfAStreamCarriesTheSame) {
  const v1::QueryError error = ToQueryError(InvalidField("x", "is bad"));
  EXPECT_EQ(error.code(), static_cast<int>(grpc::StatusCode::INVALID_ARGUMENT));
  EXPECT_EQ(error.reason(), "INVALID_FIELD");
  EXPECT_EQ(error.fields(0).field(), "x");
  EXPECT_FALSE(error.has_retry_delay());
  const v1::QueryError overload = ToQueryError(
      MakeError(absl::StatusCode::kResourceExhausted, "full",
                {.reason = "FULL", .metadata = {{"limit", "3"}}, .retry_after_s = 1.5}));
  EXPECT_EQ(overload.retry_delay().seconds(), 1);
  EXPECT_EQ(overload.retry_delay().nanos(), 500'000'000);
  EXPECT_EQ(overload.metadata().at("limit"), "3");
}

TEST(StatusConversion, OverloadSaysWhenToComeBack) {
  const grpc::Status status = ToGrpcStatus(Overloaded("full", "QUEUE_FULL"));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_TRUE(DetailsIn(status).has_retry);
}

}  // namespace
}  // namespace cwm::server
