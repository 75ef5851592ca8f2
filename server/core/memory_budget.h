// One memory account for the whole server. Code that keeps more than a few kilobytes beyond its own
// computation charges the account before it allocates them, and gives them back when they are
// freed. Two kinds of payers share it: clients, for requests, uploads, streams and answers on their
// way, and worlds, for what is stored.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/core/client_id.h"
#include "server/core/fair_quota.h"

namespace cwm::server {

// An amount charged to the account, given back by the destructor. Keeps the account alive.
class MemoryCharge;

// Thread safe.
class MemoryBudget : public std::enable_shared_from_this<MemoryBudget> {
 public:
  // Worlds get at most three quarters of `limit_bytes`: the rest is for queries and deletions.
  static std::shared_ptr<MemoryBudget> Make(std::int64_t limit_bytes);

  // The payer of a charge.
  struct Payer {
    enum class Kind { kClient, kWorld };
    Kind kind = Kind::kClient;
    QuotaHolder holder;
    std::string name;  // the world's name
  };
  static Payer Client(const ClientId& client);
  // `number` distinguishes worlds, also those that had the same name one after the other.
  static Payer World(std::int64_t number, std::string name);
  std::int64_t NextWorldNumber();

  // ResourceExhausted MEMORY_EXHAUSTED with the time to retry; the metadata has `account`
  // ("server", "worlds", "world", "user" or "client"), `asked_bytes`, `taken_bytes` and
  // `limit_bytes`.
  absl::StatusOr<MemoryCharge> Charge(const Payer& payer, std::int64_t bytes);

  std::int64_t limit_bytes() const { return clients_.limit(); }
  std::int64_t worlds_limit_bytes() const { return worlds_.limit(); }
  std::int64_t client_bytes() const { return clients_.taken(); }
  std::int64_t world_bytes() const { return worlds_.taken(); }
  std::int64_t world_bytes_of(const Payer& world) const { return worlds_.taken_by(world.holder); }

 private:
  friend class MemoryCharge;

  explicit MemoryBudget(std::int64_t limit_bytes);
  absl::Status TryTake(const Payer& payer, std::int64_t bytes);
  void ForceTake(const Payer& payer, std::int64_t bytes);
  void Release(const Payer& payer, std::int64_t bytes);

  FairQuota clients_;
  FairQuota worlds_;
  std::atomic<std::int64_t> last_world_ = 0;
};

class MemoryCharge {
 public:
  MemoryCharge() = default;  // an empty charge without a payer
  MemoryCharge(MemoryCharge&& other) noexcept { Swap(other); }
  MemoryCharge& operator=(MemoryCharge&& other) noexcept {
    Swap(other);
    return *this;
  }
  ~MemoryCharge() {
    if (budget_ != nullptr) budget_->Release(payer_, bytes_);
  }

  // An empty charge with a payer.
  static MemoryCharge Empty(std::shared_ptr<MemoryBudget> budget, MemoryBudget::Payer payer);

  std::int64_t bytes() const { return bytes_; }
  // Grows or shrinks the charge. If it cannot grow, returns the error of MemoryBudget::Charge and
  // changes nothing.
  absl::Status Resize(std::int64_t bytes);
  // Grows or shrinks the charge in any case: for memory that is already taken, or that a promise
  // needs.
  void ForceResize(std::int64_t bytes);

 private:
  friend class MemoryBudget;
  void Swap(MemoryCharge& other) noexcept {
    std::swap(budget_, other.budget_);
    std::swap(payer_, other.payer_);
    std::swap(bytes_, other.bytes_);
  }

  std::shared_ptr<MemoryBudget> budget_;  // nullptr: no payer
  MemoryBudget::Payer payer_;
  std::int64_t bytes_ = 0;
};

// The object itself, with a charge that ends with the last reference.
template <class T>
std::shared_ptr<const T> WithCharge(std::shared_ptr<const T> object, MemoryCharge charge) {
  struct Holder {
    MemoryCharge charge;
    std::shared_ptr<const T> object;  // freed first
  };
  const T* const address = object.get();
  auto holder = std::make_shared<const Holder>(Holder{std::move(charge), std::move(object)});
  return {std::move(holder), address};
}

// A readable number of bytes, e.g. "1.5 GiB".
std::string FormatBytes(std::int64_t bytes);

}  // namespace cwm::server
