// What the server tells about its calls on stderr, at info: one line each.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "server/core/client_id.h"
#include "server/core/limits.h"
#include "server/rpc/timer.h"

namespace cwm::server {

// Lines of one kind in a second, and of all kinds: what comes over that is counted and told as one
// number, so that a crowd of refused calls fills no disk.
inline constexpr std::int64_t kMaxLinesOfKind = 10;
inline constexpr std::int64_t kMaxLines = 50;
// A call that takes longer is told as slow.
inline constexpr auto kSlowCall = std::chrono::seconds(1);

// Not thread safe. Seconds begin with the first line of a kind.
class LineLimit {
 public:
  // False: the line is left out, and counted for its kind.
  bool Admit(std::string_view kind, Clock::time_point now);

  struct Omitted {
    std::string kind;
    std::int64_t lines = 0;
  };
  // What was left out in seconds that are over at `now`; forgets those seconds.
  std::vector<Omitted> TakeOmitted(Clock::time_point now);

 private:
  struct Second {
    Clock::time_point begin;
    std::int64_t admitted = 0;
    std::int64_t omitted = 0;
  };

  std::map<std::string, Second, std::less<>> kinds_;
  Second all_;
};

// A name as it stands in a line: in quotes, without control characters, cut after 128 bytes.
std::string Shown(std::string_view name);

struct IngestLine {
  std::string_view world, sensor;
  std::int64_t points = 0;
  Clock::duration took{};
  absl::Status outcome;
  std::int64_t objects = 0, revision = 0;  // where the outcome is OK
};

// Thread safe. Lines hold names, numbers and reasons, never the content of a request. Outlives no
// timer: what was left out is told from there.
class RequestLog {
 public:
  explicit RequestLog(Timer& timer) : timer_(timer) {}

  void Ingested(const IngestLine& line);
  void RobotLoaded(std::string_view world, std::string_view robot, std::int64_t links,
                   std::int64_t revision);
  void WorldCreated(std::string_view world, std::string_view uid);
  void WorldDeleted(std::string_view world, std::string_view uid);
  // `method` as "/cwm.v1.WorldService/GetWorld". A client that gave a call up is no refusal:
  // CANCELLED is not told.
  void Refused(std::string_view method, absl::StatusCode code, std::string_view reason,
               const ClientId& client);
  void Slow(std::string_view method, absl::StatusCode code, Clock::duration took,
            std::size_t request_bytes, std::size_t response_bytes);

 private:
  void Write(std::string_view kind, const std::string& line);
  void TellOmitted();

  Timer& timer_;
  std::mutex mutex_;
  LineLimit limit_;
  bool will_tell_ = false;  // the timer has TellOmitted
};

}  // namespace cwm::server
