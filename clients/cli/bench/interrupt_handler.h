// Lets long work check for Ctrl-C.
#pragma once

#include <csignal>

namespace cwm::cli {

// During its lifetime the first SIGINT and the first SIGTERM are only recorded, so that the work
// can be cleaned up; a second one ends the process as usual. Only one may exist at a time.
class InterruptHandler {
 public:
  InterruptHandler();
  ~InterruptHandler();
  InterruptHandler(const InterruptHandler&) = delete;
  InterruptHandler& operator=(const InterruptHandler&) = delete;

  bool signalled() const;

 private:
  struct sigaction previous_interrupt_ = {};
  struct sigaction previous_terminate_ = {};
};

}  // namespace cwm::cli
