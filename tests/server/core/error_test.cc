#include "server/core/error.h"

#include <gtest/gtest.h>

namespace cwm::server {
namespace {

TEST(Error, DetailsSurviveInsideAStatus) {
  const ErrorDetails given{
      .reason = "REVISION_MISMATCH",
      .fields = {{"expected_revision", "is 3: must be 4"}, {"changes[0]", ""}},
      .metadata = {{"expected_revision", "3"}, {"empty", ""}, {"12:odd", "a;b 7:\n5:x"}},
      .retry_after_s = 0.25};
  const absl::Status copy = MakeError(absl::StatusCode::kAborted, "the message", given);
  EXPECT_EQ(copy.code(), absl::StatusCode::kAborted);
  EXPECT_EQ(copy.message(), "the message");
  const ErrorDetails read = DetailsOf(copy);
  EXPECT_EQ(read.reason, given.reason);
  EXPECT_EQ(read.fields, given.fields);
  EXPECT_EQ(read.metadata, given.metadata);
  EXPECT_EQ(read.retry_after_s, given.retry_after_s);
}

TEST(Error, InvalidFieldNamesFieldValueAndRule) {
  const absl::Status status = InvalidField("changes[2].margin_m", "is -1, must not be negative");
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(status.message(), "changes[2].margin_m: is -1, must not be negative");
  const ErrorDetails details = DetailsOf(status);
  EXPECT_EQ(details.reason, "INVALID_FIELD");
  ASSERT_EQ(details.fields.size(), 1u);
  EXPECT_EQ(details.fields[0].field, "changes[2].margin_m");
  EXPECT_EQ(details.fields[0].description, "is -1, must not be negative");
}

TEST(Error, PlainStatusesHaveNoReason) {
  EXPECT_EQ(DetailsOf(absl::OkStatus()).reason, "");
  EXPECT_EQ(DetailsOf(absl::InternalError("x")).reason, "");
  EXPECT_FALSE(DetailsOf(absl::InternalError("x")).retry_after_s.has_value());
}

}  // namespace
}  // namespace cwm::server
