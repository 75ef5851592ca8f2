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

// Threads wait here for a value that another thread builds. Many values share one of a few places,
// so that a thread may be woken for the value of another.
struct BuildingPlace {
  std::mutex mutex;
  std::condition_variable changed;
};

inline BuildingPlace& BuildingPlaceOf(const void* value) {
  constexpr std::size_t kPlaces = 16, kBytesOfValue = 64;
  static auto* const places = new std::array<BuildingPlace, kPlaces>;  // outlives static values
  return (*places)[reinterpret_cast<std::uintptr_t>(value) / kBytesOfValue % kPlaces];
}

}  // namespace internal

// Thread safe. Unlike std::call_once, both building and waiting can be ended by the WorkCounter of
// the calling thread. A value whose building was ended is dropped; the next caller builds it again.
template <class T>
class BuiltOnce {
 public:
  BuiltOnce() = default;
  BuiltOnce(const BuiltOnce&) = delete;
  BuiltOnce& operator=(const BuiltOnce&) = delete;

  // Returns the value and calls build() if it does not exist yet; nullptr if `work` ended the
  // building or the wait. The value lives as long as this object.
  template <class Build>
  const T* Get(const Build& build, WorkCounter* work = nullptr) const {
    if (const T* built = IfBuilt()) return built;
    internal::BuildingPlace& place = internal::BuildingPlaceOf(this);
    std::unique_lock lock(place.mutex);
    while (under_way_) {
      place.changed.wait_for(lock, kWait);
      if (under_way_ && work != nullptr && work->MustEndNow()) return nullptr;
    }
    if (const T* built = IfBuilt()) return built;
    under_way_ = true;
    lock.unlock();
    std::optional<T> made;
    try {
      made.emplace(build());
    } catch (...) {
      Leave(place);
      throw;
    }
    lock.lock();
    if (!HasEnded(work)) {
      value_.swap(made);
      built_.store(&*value_, std::memory_order_release);
    }
    lock.unlock();
    Leave(place);
    return IfBuilt();
  }

  // The value, or nullptr before it is built.
  const T* IfBuilt() const { return built_.load(std::memory_order_acquire); }

 private:
  static constexpr auto kWait = std::chrono::milliseconds(5);

  void Leave(internal::BuildingPlace& place) const {
    {
      const std::lock_guard lock(place.mutex);
      under_way_ = false;
    }
    place.changed.notify_all();
  }

  mutable std::atomic<const T*> built_ = nullptr;
  mutable bool under_way_ = false;  // guarded by the mutex of the BuildingPlace
  mutable std::optional<T> value_;  // written once
};

}  // namespace cwm
