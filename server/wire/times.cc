#include "server/wire/times.h"

#include "absl/strings/str_cat.h"

namespace cwm::server {
namespace {

constexpr std::int64_t kNanosPerSecond = 1'000'000'000;
// derived: the whole seconds that system_clock can count in 64-bit nanoseconds: years 1678 to 2262.
constexpr std::int64_t kMaxStamp_s = std::numeric_limits<std::int64_t>::max() / kNanosPerSecond - 1;

}  // namespace

absl::StatusOr<std::chrono::nanoseconds> DurationFromProto(
    const google::protobuf::Duration& duration, const FieldPath& path, std::chrono::seconds max) {
  const bool nanos_valid = duration.nanos() >= 0 && duration.nanos() < kNanosPerSecond;
  const bool positive = duration.seconds() > 0 || (duration.seconds() == 0 && duration.nanos() > 0);
  if (!nanos_valid || !positive || duration.seconds() > max.count()) {
    return path.Error(absl::StrCat("is ", duration.seconds(), " s and ", duration.nanos(),
                                   " ns, must be positive and at most ", max.count(), " s"));
  }
  return std::chrono::seconds(duration.seconds()) + std::chrono::nanoseconds(duration.nanos());
}

google::protobuf::Duration DurationToProto(std::chrono::nanoseconds duration) {
  google::protobuf::Duration proto;
  proto.set_seconds(duration.count() / kNanosPerSecond);
  proto.set_nanos(static_cast<std::int32_t>(duration.count() % kNanosPerSecond));
  return proto;
}

absl::StatusOr<std::chrono::system_clock::time_point> TimePointFromProto(
    const google::protobuf::Timestamp& stamp, const FieldPath& path) {
  const bool nanos_valid = stamp.nanos() >= 0 && stamp.nanos() < kNanosPerSecond;
  const bool seconds_valid = stamp.seconds() >= -kMaxStamp_s && stamp.seconds() <= kMaxStamp_s;
  if (!nanos_valid || !seconds_valid) {
    return path.Error(absl::StrCat(
        "is ", stamp.seconds(), " s and ", stamp.nanos(),
        " ns, must lie between the years 1678 and 2262 with nanos from 0 to 999999999"));
  }
  return std::chrono::system_clock::time_point(
      std::chrono::duration_cast<std::chrono::system_clock::duration>(
          std::chrono::seconds(stamp.seconds()) + std::chrono::nanoseconds(stamp.nanos())));
}

google::protobuf::Timestamp TimePointToProto(std::chrono::system_clock::time_point time) {
  const std::int64_t nanos =
      std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
  // Timestamp requires non-negative nanos, also before 1970.
  const std::int64_t below = ((nanos % kNanosPerSecond) + kNanosPerSecond) % kNanosPerSecond;
  google::protobuf::Timestamp proto;
  proto.set_seconds((nanos - below) / kNanosPerSecond);
  proto.set_nanos(static_cast<std::int32_t>(below));
  return proto;
}

}  // namespace cwm::server
