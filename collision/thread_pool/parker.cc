#include "collision/thread_pool/parker.h"

#include <sys/syscall.h>
#include <unistd.h>

#include <utility>

namespace cwm {

void Parker::PreparePark() {
  if (thread_ == 0) thread_ = static_cast<pid_t>(syscall(SYS_gettid));
  is_awake_ = 0;
}

void Parker::Park() {
  is_awake_.wait(0);
  if (!std::exchange(was_migrated_, false)) return;
  sched_setaffinity(0, sizeof(cores_), &cores_);
}

void Parker::Unpark() {
  // If the kernel refuses, the thread stays where it was: it starts later, but nothing is wrong.
  const int own = sched_getcpu();
  if (own >= 0 && sched_getaffinity(thread_, sizeof(cores_), &cores_) == 0) {
    cpu_set_t others = cores_;
    CPU_CLR(static_cast<unsigned>(own), &others);
    was_migrated_ = CPU_COUNT(&others) > 0 && CPU_ISSET(static_cast<unsigned>(own), &cores_) &&
                    sched_setaffinity(thread_, sizeof(others), &others) == 0;
  }
  is_awake_ = 1;
  is_awake_.notify_one();
}

}  // namespace cwm
