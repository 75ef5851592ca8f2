// Lets long work check for Ctrl-C.
#pragma once

#include <csignal>

namespace cwm::cli {

// During its lifetime the first SIGINT and the first SIGTERM are only recorded, so that the work
// can be cleaned up; a second one ends the process as usual. Only one may exist at a time.
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
