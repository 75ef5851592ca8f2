#include "cwm/internal/session.h"

#include <algorithm>
#include <random>
#include <thread>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace cwm::CWM_API::internal {
namespace {

// chosen: a restarted server is back within this time.
constexpr std::chrono::milliseconds kBackWithin(3'000);

using Clock = std::chrono::steady_clock;

}  // namespace

std::string NewRequestId() {
  std::random_device random;
  std::string id;
  for (int i = 0; i < 4; ++i) absl::StrAppendFormat(&id, "%08x", random());
  return id;
}

void Throw(const absl::Status& status, const client::Connection& connection) {
  const Error error = client::ErrorFromStatus(status);
  if (!absl::IsUnavailable(status) || !error.reason().empty()) throw error;
  throw Error(error.code(), absl::StrCat("no cwm-server answers at ", connection.address(), ": ",
                                         error.message()));
}

void ThrowBadArgument(const std::string& field, const std::string& description) {
  throw Error(
      ErrorCode::kInvalidArgument, absl::StrCat(field, ": ", description),
      {.reason = {}, .fields = {{field, description}}, .metadata = {}, .retry_after_s = {}});
}

bool IsBack(const client::Connection& connection, std::optional<double> retry_after_s,
            std::optional<Clock::time_point> end) {
  const auto by = [&](Clock::time_point time) { return end ? std::min(*end, time) : time; };
  const auto pause = std::chrono::duration<double>(retry_after_s.value_or(0));
  std::this_thread::sleep_until(
      by(Clock::now() + std::chrono::duration_cast<Clock::duration>(pause)));
  const auto left = by(Clock::now() + kBackWithin) - Clock::now();
  return connection.channel()->WaitForConnected(
      std::chrono::system_clock::now() +
      std::chrono::duration_cast<std::chrono::system_clock::duration>(left));
}

std::optional<std::chrono::milliseconds> DeadlineOf(std::optional<double> timeout_s) {
  if (!timeout_s) return std::nullopt;
  return std::chrono::milliseconds(static_cast<std::int64_t>(1e3 * *timeout_s));
}

}  // namespace cwm::CWM_API::internal
