// Durations and points of time.
#pragma once

#include <chrono>
#include <optional>

#include "absl/status/statusor.h"
#include "google/protobuf/duration.pb.h"
#include "google/protobuf/timestamp.pb.h"
#include "server/wire/field_path.h"

namespace cwm::server {

// A span of time: positive and at most `longest`; a time to spend at most a day.
absl::StatusOr<std::chrono::nanoseconds> FromProto(
    const google::protobuf::Duration& duration, const FieldPath& path,
    std::chrono::seconds longest = std::chrono::hours(24));
google::protobuf::Duration ToProto(std::chrono::nanoseconds duration);

// Within what protobuf allows (years 1 to 9999) and the system clock can hold.
absl::StatusOr<std::chrono::system_clock::time_point> FromProto(
    const google::protobuf::Timestamp& stamp, const FieldPath& path);
google::protobuf::Timestamp ToProto(std::chrono::system_clock::time_point time);

}  // namespace cwm::server
