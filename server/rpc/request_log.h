// Logs calls to stderr at level info, one line each.
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

// chosen: lines per second of one kind, and of all kinds. Further lines are counted and reported as
// one number, so that a flood of refused calls does not fill the disk.
inline constexpr std::int64_t kMaxLinesOfKind = 10;
inline constexpr std::int64_t kMaxLines = 50;
// chosen: a call that takes longer is logged as slow.
inline constexpr auto kSlowCall = std::chrono::seconds(1);

// Not thread safe. A second begins with the first line of a kind.
class LineLimit {
 public:
  // False if the line must be omitted; it is then counted for its kind.
  bool Admit(std::string_view kind, Clock::time_point now);

  struct Omitted {
    std::string kind;
    std::int64_t lines = 0;
  };
  // The numbers of lines omitted in seconds that ended before `now`; forgets those seconds.
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

// A name for a log line: in quotes, without control characters, cut after 128 bytes.
std::string QuoteForLog(std::string_view name);

struct IngestLine {
  std::string_view world, sensor;
  std::int64_t points = 0;
  Clock::duration took{};
  absl::Status outcome;
  std::int64_t objects = 0, revision = 0;  // valid if the outcome is OK
};

// Thread safe. Lines contain names, numbers and reasons, never the content of a request. The timer
// must outlive it and must be stopped before the destructor runs, since it reports omitted lines.
class RequestLog {
 public:
  explicit RequestLog(Timer& timer) : timer_(timer) {}

  void Ingested(const IngestLine& line);
  void RobotLoaded(std::string_view world, std::string_view robot, std::int64_t links,
                   std::int64_t revision);
  void WorldCreated(std::string_view world, std::string_view uid);
  void WorldDeleted(std::string_view world, std::string_view uid);
  // `method` as in "/cwm.v1.WorldService/GetWorld". CANCELLED is not logged: a client that gave up
  // was not refused.
  void Refused(std::string_view method, absl::StatusCode code, std::string_view reason,
               const ClientId& client);
  void Slow(std::string_view method, absl::StatusCode code, Clock::duration took,
            std::size_t request_bytes, std::size_t response_bytes);

 private:
  void Write(std::string_view kind, const std::string& line);
  void ReportOmitted();

  Timer& timer_;
  std::mutex mutex_;
  LineLimit limit_;
  bool report_scheduled_ = false;  // the timer is going to call ReportOmitted
};

}  // namespace cwm::server
