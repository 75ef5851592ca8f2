// Shows the progress of a long call on one line of a terminal.
#pragma once

#include <chrono>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>

#include "clients/cli/session.h"

namespace cwm::cli {

enum class ProgressStyle { kSilent, kOneLine };

// Bytes being transferred. `total_bytes` is positive.
struct Transfer {
  std::string action;  // "sending"
  std::int64_t moved_bytes = 0;
  std::int64_t total_bytes = 0;
  double bytes_per_s = 0;   // 0: unknown yet
  std::string detail = {};  // "87381 of 307200 points"; empty: omitted
};

// "sending 1.0 MB of 3.7 MB, 87381 of 307200 points, 2.5 MB/s, 1 s left"; rate and time are omitted
// while the rate is unknown.
std::string FormatTransfer(const Transfer& transfer);

// "87381 of 307200 points": the number of complete ones of `bytes_each` bytes, which is positive.
std::string FormatCount(const Transfer& transfer, std::int64_t bytes_each, const std::string& unit);

// Rewrites one line of `err` and erases it at the end. Silent if `err` is no terminal.
class Progress {
 public:
  explicit Progress(const Session& session);
  Progress(std::ostream& err, ProgressStyle style) : err_(err), style_(style) {}
  ~Progress() { Clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // Sets `bytes_per_s` to the mean since the first call, before which the server may have worked on
  // what is received.
  void Update(Transfer transfer);
  void ShowStage(const std::string& stage);
  void Clear();

 private:
  struct Start {
    std::chrono::steady_clock::time_point time;
    std::int64_t moved_bytes;
  };
  std::optional<Start> start_;
  std::ostream& err_;
  ProgressStyle style_;
  bool shown_ = false;
};

}  // namespace cwm::cli
