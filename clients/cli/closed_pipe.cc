#include "clients/cli/closed_pipe.h"

#include <poll.h>
#include <unistd.h>

#include <iostream>

namespace cwm::cli {

bool IsPipeClosed(const std::ostream& out, std::chrono::milliseconds wait) {
  // No events are requested, but errors are reported nevertheless. A descriptor of -1 is ignored,
  // so poll only waits.
  pollfd stdout_end{.fd = &out == &std::cout ? STDOUT_FILENO : -1, .events = 0, .revents = 0};
  return poll(&stdout_end, 1, static_cast<int>(wait.count())) > 0 &&
         (stdout_end.revents & (POLLERR | POLLHUP)) != 0;
}

}  // namespace cwm::cli
