// Refuses calls while the server restores its worlds, though it listens already.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "server/core/error.h"
#include "server/core/limits.h"

namespace cwm::server {

// Open unless Close was called. Thread safe, except for Close.
class ServingGate {
 public:
  // Must be called before the server starts.
  void Close() {
    closed_at_ = Clock::now();
    progress_ = 0;
    open_ = false;
  }
  // `share` of the worlds is restored, 0 to 1.
  void SetProgress(double share) { progress_ = std::clamp(share, 0.0, 1.0); }
  void Open() {
    if (is_open()) return;
    closed_s_ = SecondsSinceClosing();
    progress_ = 1;
    open_ = true;
  }

  bool is_open() const { return open_; }
  double progress() const { return progress_; }
  // How long it was closed, 0 until it opens.
  double closed_s() const { return closed_s_; }

  // UNAVAILABLE STORE_REPLAYING with the progress, and the time after which it will probably be
  // open; OK if it is open.
  absl::Status Check() const {
    if (is_open()) return absl::OkStatus();
    const double progress = progress_;
    const std::string percent = absl::StrCat(static_cast<int>(100 * progress), " %");
    return MakeError(absl::StatusCode::kUnavailable,
                     absl::StrCat("the server restores its worlds (", percent, " done)"),
                     {.reason = "STORE_REPLAYING",
                      .fields = {},
                      .metadata = {{"progress", absl::StrCat(progress)}},
                      .retry_after_s = RemainingSeconds(progress)});
  }

 private:
  double SecondsSinceClosing() const {
    return std::chrono::duration<double>(Clock::now() - closed_at_).count();
  }

  // An estimate from the progress so far.
  double RemainingSeconds(double progress) const {
    constexpr double kMin_s = 0.1, kMax_s = 10;  // chosen: clients see the progress now and then
    if (progress <= 0) return kMin_s;
    return std::clamp(SecondsSinceClosing() * (1 - progress) / progress, kMin_s, kMax_s);
  }

  Clock::time_point closed_at_ = {};
  std::atomic<bool> open_ = true;
  std::atomic<double> progress_ = 1;
  std::atomic<double> closed_s_ = 0;
};

}  // namespace cwm::server
