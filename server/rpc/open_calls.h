// The open calls, so that a stopping server closes their connections after the last of them.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <list>
#include <mutex>
#include <stop_token>

#include "server/core/limits.h"

namespace cwm::server {

// Thread safe. Must outlive its tokens.
class OpenCalls {
 public:
  // Held by a call until gRPC has sent its status.
  class Token {
   public:
    // `stop` is requested when the call has to end. Without it the call ends by itself.
    explicit Token(OpenCalls& calls, std::stop_source stop = std::stop_source(std::nostopstate));
    ~Token();
    Token(const Token&) = delete;
    Token& operator=(const Token&) = delete;

    // Records that the client has received something from the call.
    void NoteProgress() { calls_.NoteProgress(); }

   private:
    friend class OpenCalls;
    OpenCalls& calls_;
    std::stop_source stop_;
    bool is_late_ = false;  // the call came while the server was draining
    std::list<Token*>::iterator position_;
  };

  // Calls from now on are refused at once, so WaitUntilNone ignores them.
  void SetDraining();
  // Requests the stop of all open and all later calls.
  void RequestStop();
  // True after RequestStop: a call is cancelled because the server stops.
  bool stop_requested() const;

  // True if all calls from before the drain have ended. False at `end`, or if for the time
  // `patience` none of them has ended or sent anything while `is_busy` was false: the remaining
  // calls then wait only for their clients.
  bool WaitUntilNone(Clock::time_point end, Clock::duration patience,
                     const std::function<bool()>& is_busy);

 private:
  void NoteProgress();
  bool IsEmpty() const { return late_ == static_cast<std::int64_t>(open_.size()); }

  mutable std::mutex mutex_;
  std::condition_variable none_;
  std::list<Token*> open_;
  std::int64_t late_ = 0;  // open calls that came while draining
  Clock::time_point last_progress_ = Clock::now();
  bool is_draining_ = false;
  bool stop_requested_ = false;
};

}  // namespace cwm::server
