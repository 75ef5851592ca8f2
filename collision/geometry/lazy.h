// A value that is built by the first thread that needs it, while other threads wait for it.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "collision/geometry/work_counter.h"

namespace cwm {
namespace internal {

// Threads wait here for a value that another thread builds. Many values share one of a few
// monitors, so that a thread may be woken for the value of another.
struct BuildMonitor {
  std::mutex mutex;
  std::condition_variable changed;
};

inline BuildMonitor& BuildMonitorOf(const void* value) {
  constexpr std::size_t kMonitors = 16, kBytesPerValue = 64;
  static auto* const monitors = new std::array<BuildMonitor, kMonitors>;  // outlives static values
  return (*monitors)[reinterpret_cast<std::uintptr_t>(value) / kBytesPerValue % kMonitors];
}

}  // namespace internal

// Thread safe. Unlike std::call_once, both building and waiting can be ended by the WorkCounter of
// the calling thread. A value whose building was ended is dropped; the next caller builds it again.
template <class T>
class Lazy {
 public:
  Lazy() = default;
  Lazy(const Lazy&) = delete;
  Lazy& operator=(const Lazy&) = delete;

  // Returns the value and calls build() if it does not exist yet; nullptr if `work` ended the
  // building or the wait. The value lives as long as this object.
  template <class Build>
  const T* Get(const Build& build, WorkCounter* work = nullptr) const {
    if (const T* built = GetIfBuilt()) return built;
    internal::BuildMonitor& monitor = internal::BuildMonitorOf(this);
    std::unique_lock lock(monitor.mutex);
    while (is_building_) {
      monitor.changed.wait_for(lock, kWait);
      if (is_building_ && work != nullptr && work->MustEndNow()) return nullptr;
    }
    if (const T* built = GetIfBuilt()) return built;
    is_building_ = true;
    lock.unlock();
    std::optional<T> made;
    try {
      made.emplace(build());
    } catch (...) {
      EndBuild(monitor);
      throw;
    }
    lock.lock();
    if (!HasEnded(work)) {
      value_.swap(made);
      built_.store(&*value_, std::memory_order_release);
    }
    lock.unlock();
    EndBuild(monitor);
    return GetIfBuilt();
  }

  // The value, or nullptr before it is built.
  const T* GetIfBuilt() const { return built_.load(std::memory_order_acquire); }

 private:
  static constexpr auto kWait = std::chrono::milliseconds(5);

  void EndBuild(internal::BuildMonitor& monitor) const {
    {
      const std::lock_guard lock(monitor.mutex);
      is_building_ = false;
    }
    monitor.changed.notify_all();
  }

  mutable std::atomic<const T*> built_ = nullptr;
  mutable bool is_building_ = false;  // guarded by the mutex of the BuildMonitor
  mutable std::optional<T> value_;    // written once
};

}  // namespace cwm
