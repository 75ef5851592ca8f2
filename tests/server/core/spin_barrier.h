// Starts threads at the same moment, so that they really race: there is no lock and no wake-up
// between the barrier and the code under test.
#pragma once

#include <atomic>
#include <thread>

namespace cwm::server {

class SpinBarrier {
 public:
  explicit SpinBarrier(int threads) : missing_(threads) {}
  void Arrive() {
    missing_.fetch_sub(1);
    while (missing_.load() > 0) std::this_thread::yield();
  }

 private:
  std::atomic<int> missing_;
};

}  // namespace cwm::server
