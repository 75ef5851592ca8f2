// Puts one thread to sleep until another thread wakes it.
#pragma once

#include <sched.h>

#include <atomic>

namespace cwm {

// A woken thread starts on another core than its waker's, if it may run on one. Linux would often
// queue it behind its waker, which keeps running: under virtualisation with paravirtual steal time,
// a halted core counts as preempted and therefore not as idle (available_idle_cpu in kernel/sched),
// and the woken thread waits some milliseconds until the load is balanced.
class Parker {
 public:
  // Called by the thread that is to sleep, before other threads know of it.
  void PreparePark();
  // Called by that thread after PreparePark. Returns after Unpark, at once if Unpark came first.
  void Park();
  // Called by another thread, once for each PreparePark.
  void Unpark();

 private:
  pid_t thread_ = 0;
  // The cores on which the thread may run, written by the waker if it excluded its own core, and
  // restored by the thread once awake.
  cpu_set_t cores_ = {};
  bool was_migrated_ = false;
  std::atomic<int> is_awake_{1};
};

}  // namespace cwm
