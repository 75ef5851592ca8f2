// One line on a terminal that says how far a long call is.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>

namespace cwm::cli {

enum class ProgressStyle { kSilent, kOneLine };

// Rewrites one line of `err` and wipes it at the end, so that nothing of it stays. Silent when err
// is no terminal.
class Progress {
 public:
  Progress(std::ostream& err, ProgressStyle style) : err_(err), style_(style) {}
  ~Progress() { Clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void Sent(std::int64_t sent_bytes, std::int64_t total_bytes);
  void Stage(const std::string& stage);
  void Clear();

 private:
  std::ostream& err_;
  ProgressStyle style_;
  bool shown_ = false;
};

}  // namespace cwm::cli
