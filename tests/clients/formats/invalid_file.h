// Malformed files and how they are refused, for the tests of all formats.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "absl/status/status.h"

namespace cwm::formats {

struct InvalidFile {
  const char* name;
  std::string text;
  const char* place;  // the field or the line that the message names
  const char* rule;
};

inline void ExpectRefusal(const absl::Status& status, const std::string& file,
                          const InvalidFile& invalid) {
  ASSERT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
  EXPECT_THAT(std::string(status.message()), ::testing::AllOf(::testing::HasSubstr(file + ": "),
                                                              ::testing::HasSubstr(invalid.place),
                                                              ::testing::HasSubstr(invalid.rule)));
}

}  // namespace cwm::formats
