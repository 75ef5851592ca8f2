#include "server/rpc/request_log.h"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include "absl/strings/escaping.h"

namespace cwm::server {
namespace {

constexpr auto kSecond = std::chrono::seconds(1);
constexpr std::size_t kMaxNameBytes = 128;

std::int64_t Milliseconds(Clock::duration took) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(took).count();
}

std::string CodeText(absl::StatusCode code) { return absl::StatusCodeToString(code); }

std::string ClientText(const ClientId& client) {
  if (client.connection == 0) return "viewer";
  const std::string uid = client.uid ? fmt::format(" uid {}", *client.uid) : "";
  return fmt::format("connection {}{}", client.connection, uid);
}

void WriteOmitted(const std::vector<LineLimit::Omitted>& omitted) {
  for (const LineLimit::Omitted& kind : omitted) {
    spdlog::info("{}: and {} more in that second", kind.kind, kind.lines);
  }
}

}  // namespace

bool LineLimit::Admit(std::string_view kind, Clock::time_point now) {
  auto found = kinds_.find(kind);
  if (found == kinds_.end()) found = kinds_.emplace(kind, Second{.begin = now}).first;
  if (all_.begin + kSecond <= now) all_ = Second{.begin = now};
  Second& second = found->second;
  if (second.admitted >= kMaxLinesOfKind || all_.admitted >= kMaxLines) {
    ++second.omitted;
    return false;
  }
  ++second.admitted;
  ++all_.admitted;
  return true;
}

std::vector<LineLimit::Omitted> LineLimit::TakeOmitted(Clock::time_point now) {
  std::vector<Omitted> omitted;
  for (auto kind = kinds_.begin(); kind != kinds_.end();) {
    if (kind->second.begin + kSecond > now) {
      ++kind;
      continue;
    }
    if (kind->second.omitted > 0) omitted.push_back({kind->first, kind->second.omitted});
    kind = kinds_.erase(kind);
  }
  return omitted;
}

std::string QuoteForLog(std::string_view name) {
  const std::string kept(name.substr(0, kMaxNameBytes));
  return fmt::format("\"{}{}\"", absl::CHexEscape(kept), kept.size() < name.size() ? "..." : "");
}

void RequestLog::Ingested(const IngestLine& line) {
  const std::string made =
      line.outcome.ok() ? fmt::format("{} objects, revision {}, ", line.objects, line.revision)
                        : "";
  Write("ingest", fmt::format("ingest: world {}, sensor {}, {} points, {} ms, {}{}",
                              QuoteForLog(line.world), QuoteForLog(line.sensor), line.points,
                              Milliseconds(line.took), made, CodeText(line.outcome.code())));
}

void RequestLog::RobotLoaded(std::string_view world, std::string_view robot, std::int64_t links,
                             std::int64_t revision) {
  Write("robot loaded", fmt::format("robot loaded: world {}, robot {}, {} links, revision {}",
                                    QuoteForLog(world), QuoteForLog(robot), links, revision));
}

void RequestLog::WorldCreated(std::string_view world, std::string_view uid) {
  Write("world created", fmt::format("world created: {}, uid {}", QuoteForLog(world), uid));
}

void RequestLog::WorldDeleted(std::string_view world, std::string_view uid) {
  Write("world deleted", fmt::format("world deleted: {}, uid {}", QuoteForLog(world), uid));
}

void RequestLog::Refused(std::string_view method, absl::StatusCode code, std::string_view reason,
                         const ClientId& client) {
  if (code == absl::StatusCode::kOk || code == absl::StatusCode::kCancelled) return;
  Write(fmt::format("refused {}", reason),
        fmt::format("refused {}: {}, {}, {}", reason, method, CodeText(code), ClientText(client)));
}

void RequestLog::Slow(std::string_view method, absl::StatusCode code, Clock::duration took,
                      std::size_t request_bytes, std::size_t response_bytes) {
  Write("slow", fmt::format("slow: {}, {} ms, {} bytes asked, {} bytes answered, {}", method,
                            Milliseconds(took), request_bytes, response_bytes, CodeText(code)));
}

void RequestLog::Write(std::string_view kind, const std::string& line) {
  if (!spdlog::should_log(spdlog::level::info)) return;
  std::vector<LineLimit::Omitted> omitted;
  bool is_admitted = false;
  bool must_schedule_report = false;
  {
    const std::lock_guard lock(mutex_);
    const Clock::time_point now = Clock::now();
    omitted = limit_.TakeOmitted(now);
    is_admitted = limit_.Admit(kind, now);
    must_schedule_report = !is_admitted && !report_scheduled_;
    report_scheduled_ = report_scheduled_ || must_schedule_report;
  }
  WriteOmitted(omitted);
  if (is_admitted) spdlog::info("{}", line);
  if (must_schedule_report) timer_.After(kSecond, [this] { ReportOmitted(); });
}

void RequestLog::ReportOmitted() {
  std::vector<LineLimit::Omitted> omitted;
  {
    const std::lock_guard lock(mutex_);
    report_scheduled_ = false;
    omitted = limit_.TakeOmitted(Clock::now());
  }
  WriteOmitted(omitted);
}

}  // namespace cwm::server
