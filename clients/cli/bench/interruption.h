// Ctrl-C as a question that long work asks.
#pragma once

#include <csignal>

namespace cwm::cli {

// While it lives, the first SIGINT and the first SIGTERM are noted, so that what was begun can be
// put away; a second one ends the process as ever. One at a time.
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  bool came() const;

 private:
  struct sigaction interrupt_before_ = {};
  struct sigaction terminate_before_ = {};
};

}  // namespace cwm::cli
