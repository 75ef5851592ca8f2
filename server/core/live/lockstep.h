// Turns for frames whose effects must follow from their order alone.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <mutex>

namespace cwm::server {

// One frame of a world has the turn at a time, and keeps it until everything that it began beside
// the frames is done. Turns are given in the order in which they were asked for. Thread safe.
class Lockstep {
 public:
  using Callback = std::function<void()>;

  // Calls `begin` once when it is the caller's turn and nothing runs beside the frames: in this
  // thread, or later in another one. The caller must then call End.
  void Begin(Callback begin);
  // The frame that has the turn is processed. Calls `end` once when nothing runs beside the frames
  // any more, in this thread or another one, and then ends the turn.
  void End(Callback end);

  // Something runs beside the frames until the last copy of the token is gone, which must not
  // outlive this object.
  using Token = std::shared_ptr<const void>;
  Token RunBeside();

 private:
  void Leave();
  // Calls what can be called now.
  void Advance();

  std::mutex mutex_;  // a leaf; not held while callbacks run
  std::deque<Callback> waiting_;
  bool is_taken_ = false;
  Callback end_;  // of the turn, once its frame is processed
  int running_ = 0;
};

}  // namespace cwm::server
