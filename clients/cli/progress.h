// One line on a terminal that says how far a long call is.
#pragma once

#include <chrono>
#include <cstdint>
#include <iosfwd>
#include <string>

namespace cwm::cli {

enum class ProgressStyle { kSilent, kOneLine };

// A cloud on its way. `point_bytes` and `total_bytes` are positive.
struct Upload {
  std::int64_t sent_bytes = 0;
  std::int64_t total_bytes = 0;
  std::int64_t point_bytes = 0;  // of one point
  double elapsed_s = 0;
};

// "sending 1.0 MB of 3.7 MB, 87381 of 307200 points, 2.5 MB/s, 1 s left"; the rate is the mean so
// far, and is left out with the time where no time has passed.
std::string UploadText(const Upload& upload);

// Rewrites one line of `err` and wipes it at the end, so that nothing of it stays. Silent when err
// is no terminal.
class Progress {
 public:
  Progress(std::ostream& err, ProgressStyle style) : err_(err), style_(style) {}
  ~Progress() { Clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // `elapsed_s` is filled in: since this was made.
  void Sent(Upload upload);
  void Stage(const std::string& stage);
  void Clear();

 private:
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::ostream& err_;
  ProgressStyle style_;
  bool shown_ = false;
};

}  // namespace cwm::cli
