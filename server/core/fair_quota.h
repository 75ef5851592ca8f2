// Shares a limited amount (bytes, places, streams) among holders by dynamic thresholds (Choudhury
// and Hahne, "Dynamic Queue Length Thresholds for Shared-Memory Packet Switches", IEEE/ACM
// Transactions on Networking 6, 1998): a holder may take more while it has less than a multiple of
// the free amount. A single holder gets most of it, many get equal parts, and a newcomer always
// finds room.
#pragma once

#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <utility>

#include "server/core/client_id.h"

namespace cwm::server {

// A member of a group, e.g. a connection of a user. Groups share first, then the members of each
// group.
struct QuotaHolder {
  std::int64_t group = 0;
  std::int64_t member = 0;
  friend bool operator==(const QuotaHolder&, const QuotaHolder&) = default;
};

// Connections whose user is unknown are one group.
QuotaHolder HolderOf(const ClientId& client);

struct FairQuotaOptions {
  std::int64_t limit = 0;                                                // of all holders together
  std::int64_t member_limit = std::numeric_limits<std::int64_t>::max();  // of one member
  // chosen: the multiples of the free amount; for a member, of the amount that is free to its
  // group. A single group gets 3/4 of the limit. With member_share 1 a single member gets half of
  // the limit, and four greedy members of one group leave about a sixth of it to others of their
  // group.
  double group_share = 3;
  double member_share = 3;
};

// Thread safe. Must outlive the shares taken from it.
class FairQuota {
 public:
  explicit FairQuota(FairQuotaOptions options) : options_(options) {}

  enum class Refusal { kLimit, kGroup, kMember };
  // Empty if the amount was taken, else the reason. `reserved` is a part of the limit that is taken
  // elsewhere.
  std::optional<Refusal> TryTake(QuotaHolder holder, std::int64_t amount,
                                 std::int64_t reserved = 0);
  // Takes the amount even if it is not free.
  void ForceTake(QuotaHolder holder, std::int64_t amount);
  void Release(QuotaHolder holder, std::int64_t amount);

  std::int64_t taken() const;
  std::int64_t taken_by(QuotaHolder holder) const;
  std::int64_t limit() const { return options_.limit; }

 private:
  using Amounts = std::unordered_map<std::int64_t, std::int64_t>;

  const FairQuotaOptions options_;
  mutable std::mutex mutex_;
  std::int64_t taken_ = 0;
  Amounts groups_;
  Amounts members_;  // member numbers are unique across groups
};

// A share of a quota, given back by the destructor.
class QuotaShare {
 public:
  QuotaShare() = default;  // an empty share
  QuotaShare(QuotaShare&& other) noexcept
      : quota_(std::exchange(other.quota_, nullptr)),
        holder_(other.holder_),
        amount_(std::exchange(other.amount_, 0)) {}
  QuotaShare& operator=(QuotaShare&& other) noexcept {
    std::swap(quota_, other.quota_);
    std::swap(holder_, other.holder_);
    std::swap(amount_, other.amount_);
    return *this;
  }
  ~QuotaShare() {
    if (quota_ != nullptr) quota_->Release(holder_, amount_);
  }

  // Empty if the quota refuses.
  static std::optional<QuotaShare> TryTake(FairQuota& quota, const ClientId& client,
                                           std::int64_t amount = 1) {
    const QuotaHolder holder = HolderOf(client);
    if (quota.TryTake(holder, amount)) return std::nullopt;
    QuotaShare share;
    share.quota_ = &quota;
    share.holder_ = holder;
    share.amount_ = amount;
    return share;
  }

 private:
  FairQuota* quota_ = nullptr;
  QuotaHolder holder_;
  std::int64_t amount_ = 0;
};

}  // namespace cwm::server
