// Which streams are not over yet, so that a server closes their connections after the last of them.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace cwm::server {

// Thread safe; outlives its tokens.
class OpenStreams {
 public:
  // Held by a stream until gRPC has sent its status.
  class Token {
   public:
    explicit Token(OpenStreams& streams) : streams_(streams) {
      const std::lock_guard lock(streams_.mutex_);
      ++streams_.count_;
    }
    ~Token() {
      // Notified under the lock: who waited may destroy the counter as soon as it is free.
      const std::lock_guard lock(streams_.mutex_);
      if (--streams_.count_ == 0) streams_.none_.notify_all();
    }
    Token(const Token&) = delete;
    Token& operator=(const Token&) = delete;

   private:
    OpenStreams& streams_;
  };

  // False when some are left after that time.
  bool WaitUntilNone(std::chrono::milliseconds at_most) {
    std::unique_lock lock(mutex_);
    return none_.wait_for(lock, at_most, [this] { return count_ == 0; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable none_;
  std::int64_t count_ = 0;
};

}  // namespace cwm::server
