// One thread's bed: where it sleeps until another thread wakes it.
#pragma once

#include <sched.h>

#include <atomic>

namespace cwm {

// A thread that is woken starts on another core than its waker's, where it may. Linux would often
// put it behind its waker, which goes on to work: under virtualisation with paravirtual steal time a
// core that halts counts as preempted, and so as not idle (available_idle_cpu in kernel/sched), and
// the woken thread waits until the load is balanced, some milliseconds later.
class Sleeper {
 public:
  // By the thread that is to sleep, before others know of it.
  void LieDown();
  // By that thread, after LieDown: returns after Wake, at once where that was before.
  void Sleep();
  // By another thread, once for each LieDown.
  void Wake();

 private:
  pid_t thread_ = 0;
  // By the waker, read once awake: where the thread may run, when it was kept from one of them.
  cpu_set_t cores_ = {};
  bool is_sent_elsewhere_ = false;
  std::atomic<int> is_awake_{1};
};

}  // namespace cwm
