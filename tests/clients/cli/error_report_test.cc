#include "clients/cli/error_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "clients/cli/exit_code.h"
#include "clients/cpp/call_error.h"
#include "cwm/v1/error_details.pb.h"

namespace cwm::cli {
namespace {

using ::testing::HasSubstr;

TEST(ExitCode, FollowsTheStatus) {
  using absl::StatusCode;
  const std::vector<std::pair<StatusCode, int>> codes = {
      {StatusCode::kOk, 0},
      {StatusCode::kUnavailable, 2},
      {StatusCode::kNotFound, 3},
      {StatusCode::kAborted, 4},
      {StatusCode::kFailedPrecondition, 4},
      {StatusCode::kOutOfRange, 4},
      {StatusCode::kDeadlineExceeded, 5},
      {StatusCode::kCancelled, 5},
      {StatusCode::kPermissionDenied, 6},
      {StatusCode::kUnauthenticated, 6},
      {StatusCode::kResourceExhausted, 7},
      {StatusCode::kInvalidArgument, 8},
      {StatusCode::kInternal, 70},
      {StatusCode::kUnknown, 70},
      {StatusCode::kUnimplemented, 70},
      {StatusCode::kDataLoss, 70},
  };
  for (const auto& [code, expected] : codes) {
    EXPECT_EQ(static_cast<int>(ExitCodeOf(absl::Status(code, "x"))), expected) << code;
  }
  EXPECT_EQ(ExitCodeOf(UsageError("x")), ExitCode::kUsage);
}

std::string Report(const absl::Status& status) {
  std::ostringstream err;
  ReportError(status, {"put", "unix:here"}, err);
  return err.str();
}

TEST(ReportError, SaysWhatWhyAndWhatToDoNext) {
  cwm::v1::ErrorInfo info;
  info.set_reason("INVALID_FIELD");
  cwm::v1::BadRequest request;
  request.add_field_violations()->set_field("changes[0].put.object.shapes[0].box.size_x_m");
  request.mutable_field_violations(0)->set_description("is -1, must be positive and finite");
  cwm::v1::Status packed;
  packed.add_details()->set_type_url("type.googleapis.com/google.rpc.ErrorInfo");
  packed.mutable_details(0)->set_value(info.SerializeAsString());
  packed.add_details()->set_type_url("type.googleapis.com/google.rpc.BadRequest");
  packed.mutable_details(1)->set_value(request.SerializeAsString());
  const std::string report = Report(client::StatusFromGrpc(
      grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "refused", packed.SerializeAsString())));
  EXPECT_EQ(report,
            "cwm: bad input: refused\n"
            "  changes[0].put.object.shapes[0].box.size_x_m: is -1, must be positive and finite\n"
            "  reason: INVALID_FIELD\n"
            "hint: `cwm put --help` shows examples and units\n");
}

TEST(ReportError, NamesTheOptionThatTakesAScanAllTheSame) {
  cwm::v1::ErrorInfo info;
  info.set_reason("SCAN_CONTRADICTS_WORLD");
  cwm::v1::Status packed;
  packed.add_details()->set_type_url("type.googleapis.com/google.rpc.ErrorInfo");
  packed.mutable_details(0)->set_value(info.SerializeAsString());
  const std::string report = Report(client::StatusFromGrpc(
      grpc::Status(grpc::StatusCode::FAILED_PRECONDITION,
                   "the scan contradicts the world: all supports would go; to take it all the "
                   "same, set force",
                   packed.SerializeAsString())));
  EXPECT_EQ(report,
            "cwm: revision conflict: the scan contradicts the world: all supports would go\n"
            "  reason: SCAN_CONTRADICTS_WORLD\n"
            "hint: `cwm ingest --force` takes it all the same\n");
}

TEST(ReportError, NamesTheAddressThatDidNotAnswer) {
  EXPECT_THAT(Report(absl::UnavailableError("nobody")), HasSubstr("tried unix:here"));
}

}  // namespace
}  // namespace cwm::cli
