// Which calls are not over yet, so that a server closes their connections after the last of them.
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

// Thread safe; outlives its tokens.
class OpenCalls {
 public:
  // Held by a call until gRPC has sent its status.
  class Token {
   public:
    // `stop` is requested when the call has to end. Without one it ends by itself.
    explicit Token(OpenCalls& calls, std::stop_source stop = std::stop_source(std::nostopstate));
    ~Token();
    Token(const Token&) = delete;
    Token& operator=(const Token&) = delete;

    // Tells that the client has taken something of what the call sends.
    void NoteProgress() { calls_.NoteMove(); }

   private:
    friend class OpenCalls;
    OpenCalls& calls_;
    std::stop_source stop_;
    bool is_late_ = false;  // it came while the server drained
    std::list<Token*>::iterator position_;
  };

  // Calls that come from now on are refused at once: nobody waits for the last of them.
  void SetDraining();
  // Requests the stop of all that are open and of those to come.
  void RequestStop();
  // True from then on: what is cancelled is so because the server ends.
  bool stop_requested() const;

  // True when none is open that came before the drain. False at `end`, or when for the time of
  // `patience` none of them has ended or sent anything while `is_busy` was false: what is left then
  // waits for its client alone.
  bool WaitUntilNone(Clock::time_point end, Clock::duration patience,
                     const std::function<bool()>& is_busy);

 private:
  void NoteMove();
  bool IsEmpty() const { return late_ == static_cast<std::int64_t>(open_.size()); }

  mutable std::mutex mutex_;
  std::condition_variable none_;
  std::list<Token*> open_;
  std::int64_t late_ = 0;  // of them
  Clock::time_point last_move_ = Clock::now();
  bool is_draining_ = false;
  bool stop_requested_ = false;
};

}  // namespace cwm::server
