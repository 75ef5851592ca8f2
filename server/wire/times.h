// Converts durations and points in time.
#pragma once

#include <chrono>
#include <optional>

#include "absl/status/statusor.h"
#include "google/protobuf/duration.pb.h"
#include "google/protobuf/timestamp.pb.h"
#include "server/wire/field_path.h"

namespace cwm::server {

// A duration: positive and at most `max`; a time budget is at most a day.
absl::StatusOr<std::chrono::nanoseconds> DurationFromProto(
    const google::protobuf::Duration& duration, const FieldPath& path,
    std::chrono::seconds max = std::chrono::hours(24));
google::protobuf::Duration DurationToProto(std::chrono::nanoseconds duration);

// Checks the ranges of protobuf (years 1 to 9999) and of the system clock.
absl::StatusOr<std::chrono::system_clock::time_point> TimePointFromProto(
    const google::protobuf::Timestamp& stamp, const FieldPath& path);
google::protobuf::Timestamp TimePointToProto(std::chrono::system_clock::time_point time);

}  // namespace cwm::server
