#include "collision/crew/sleeper.h"

#include <sys/syscall.h>
#include <unistd.h>

#include <utility>

namespace cwm {

void Sleeper::LieDown() {
  if (thread_ == 0) thread_ = static_cast<pid_t>(syscall(SYS_gettid));
  is_awake_ = 0;
}

void Sleeper::Sleep() {
  is_awake_.wait(0);
  if (!std::exchange(is_sent_elsewhere_, false)) return;
  sched_setaffinity(0, sizeof(cores_), &cores_);
}

void Sleeper::Wake() {
  // If the kernel refuses, the thread stays where it was: it starts later, but nothing is wrong.
  const int own = sched_getcpu();
  if (own >= 0 && sched_getaffinity(thread_, sizeof(cores_), &cores_) == 0) {
    cpu_set_t others = cores_;
    CPU_CLR(static_cast<unsigned>(own), &others);
    is_sent_elsewhere_ = CPU_COUNT(&others) > 0 && CPU_ISSET(static_cast<unsigned>(own), &cores_) &&
                         sched_setaffinity(thread_, sizeof(others), &others) == 0;
  }
  is_awake_ = 1;
  is_awake_.notify_one();
}

}  // namespace cwm
