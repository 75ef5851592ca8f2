#include "clients/cli/stream_report.h"

#include <algorithm>
#include <cmath>
#include <ostream>
#include <vector>

#include "absl/strings/str_cat.h"
#include "clients/cli/quantity.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

constexpr double kMinLatencyMs = 0.01, kLatencyStep = 1.02;
// chosen: a second of a usual camera.
constexpr std::size_t kRecentFrames = 30;

std::string Ms(double latency_ms) { return absl::StrCat(FormatFixed(latency_ms, 1), " ms"); }

// ", 3 LATE, 1 EARLY"
std::string CountsText(const std::map<std::string, std::int64_t>& counts) {
  std::string text;
  for (const auto& [name, count] : counts) {
    absl::StrAppend(&text, text.empty() ? "" : ", ", count, " ", name);
  }
  return text;
}

}  // namespace

void LatencyHistogram::Add(double latency_ms) {
  const double step =
      std::log(std::max(latency_ms, kMinLatencyMs) / kMinLatencyMs) / std::log(kLatencyStep);
  ++counts_[std::min(static_cast<std::size_t>(step), kSteps - 1)];
  ++count_;
}

double LatencyHistogram::Quantile(double share) const {
  const auto wanted = static_cast<std::int64_t>(std::ceil(share * static_cast<double>(count_)));
  std::int64_t below = 0;
  for (std::size_t i = 0; i < kSteps; ++i) {
    below += counts_[i];
    // The middle of the step.
    if (below > 0 && below >= wanted) {
      return kMinLatencyMs * std::pow(kLatencyStep, static_cast<double>(i) + 0.5);
    }
  }
  return 0;
}

void StreamReport::Add(const pb::StreamCloudsResponse& answer, Clock::duration latency,
                       Clock::time_point now) {
  if (answered() == 0) first_ = now - latency;
  last_ = now;
  revision_ = std::max(revision_, answer.revision());
  if (answer.fate() == pb::FRAME_FATE_DROPPED) {
    ++dropped_;
    return;
  }
  if (answer.fate() == pb::FRAME_FATE_REFUSED) {
    ++refused_;
    ++reasons_[answer.reason().empty() ? "for no reason given" : answer.reason()];
    return;
  }
  ++processed_;
  const double latency_ms = std::chrono::duration<double, std::milli>(latency).count();
  latencies_.Add(latency_ms);
  recent_.push_back({now, latency_ms});
  if (recent_.size() > kRecentFrames) recent_.pop_front();
  const pb::FrameChanges& changes = answer.changes();
  added_ += changes.added_size();
  moved_ += changes.moved_size();
  replaced_ += changes.replaced_size();
  removed_ += changes.removed_size();
  if (!changes.movers().empty()) ++mover_frames_;
}

double StreamReport::RecentRate() const {
  if (recent_.size() < 2) return 0;
  const std::chrono::duration<double> span = recent_.back().time - recent_.front().time;
  return span.count() > 0 ? static_cast<double>(recent_.size() - 1) / span.count() : 0;
}

double StreamReport::RecentLatency() const {
  if (recent_.empty()) return 0;
  std::vector<double> sorted;
  for (const Answer& answer : recent_) sorted.push_back(answer.latency_ms);
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

std::string StreamReport::Line() const {
  std::string line = absl::StrCat(
      answered(), " frames, ", FormatFixed(RecentRate(), 1), "/s, latency ", Ms(RecentLatency()),
      ", ", added_ + moved_ + replaced_ + removed_, " changes, ", dropped_, " dropped");
  if (refused_ > 0) absl::StrAppend(&line, ", ", refused_, " refused");
  return line;
}

void StreamReport::Print(std::ostream& out) const {
  const std::chrono::duration<double> elapsed = last_ - first_;
  out << answered() << " frames";
  if (elapsed.count() > 0) {
    out << " in " << FormatFixed(elapsed.count(), 1) << " s, "
        << FormatFixed(static_cast<double>(answered()) / elapsed.count(), 1) << "/s";
  }
  out << ": " << processed_ << " processed, " << dropped_ << " dropped, " << refused_ << " refused";
  if (!reasons_.empty()) out << " (" << CountsText(reasons_) << ")";
  out << "\n";
  if (processed_ == 0) return;
  out << "latency: " << Ms(latencies_.Quantile(0.5)) << " median, " << Ms(latencies_.Quantile(0.95))
      << " p95\n";
  out << "changes: " << added_ << " added, " << moved_ << " moved, " << replaced_ << " replaced, "
      << removed_ << " removed; movers in " << mover_frames_ << " frames\n";
  out << "revision " << revision_ << "\n";
}

}  // namespace cwm::cli
