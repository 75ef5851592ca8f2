#include "collision/crew/sleeper.h"

#include <sys/syscall.h>
#include <unistd.h>

namespace cwm {

void Sleeper::LieDown() {
  if (thread_ == 0) thread_ = static_cast<pid_t>(syscall(SYS_gettid));
  are_cores_known_ = sched_getaffinity(0, sizeof(cores_), &cores_) == 0;
  is_awake_ = 0;
}

void Sleeper::Sleep() {
  is_awake_.wait(0);
  if (are_cores_known_) sched_setaffinity(0, sizeof(cores_), &cores_);
}

void Sleeper::Wake() {
  // A refusal leaves the thread where it was: later, but never wrong.
  const int own = sched_getcpu();
  if (are_cores_known_ && own >= 0) {
    cpu_set_t others = cores_;
    CPU_CLR(own, &others);
    if (CPU_COUNT(&others) > 0) sched_setaffinity(thread_, sizeof(others), &others);
  }
  is_awake_ = 1;
  is_awake_.notify_one();
}

}  // namespace cwm
