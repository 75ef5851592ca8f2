// Shares a limited amount of something (bytes, places, streams) among holders by dynamic thresholds
// (Choudhury and Hahne, "Dynamic Queue Length Thresholds for Shared-Memory Packet Switches",
// IEEE/ACM Transactions on Networking 6, 1998): a holder may take more while it has less than a
// multiple of what is free. A single holder gets most of it, many get equal parts, and a newcomer
// always finds room.
#pragma once

#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <utility>

#include "server/core/client_id.h"

namespace cwm::server {

// A member of a group, as a connection is one of a user. Groups share first, members within.
struct QuotaHolder {
  std::int64_t group = 0;
  std::int64_t member = 0;
  friend bool operator==(const QuotaHolder&, const QuotaHolder&) = default;
};

// Connections whose user is unknown are one group.
QuotaHolder HolderOf(const ClientId& client);

struct FairQuotaOptions {
  std::int64_t limit = 0;                                                // in all
  std::int64_t member_limit = std::numeric_limits<std::int64_t>::max();  // of one member
  // Multiples of what is free, for a member of what is free to its group. A group alone gets 3/4 of the
  // limit, one member alone half of it where member_share is 1; four greedy members of one group leave
  // their group a sixth.
  double group_share = 3;
  double member_share = 3;
};

// Thread safe; outlives what was taken from it.
class FairQuota {
 public:
  explicit FairQuota(FairQuotaOptions options) : options_(options) {}

  enum class Refusal { kLimit, kGroup, kMember };
  // Nothing when it was taken. `reserved` is a part of the limit that is taken elsewhere.
  std::optional<Refusal> Take(QuotaHolder holder, std::int64_t amount, std::int64_t reserved = 0);
  // Takes though nothing may be free.
  void TakeAnyway(QuotaHolder holder, std::int64_t amount);
  void GiveBack(QuotaHolder holder, std::int64_t amount);

  std::int64_t taken() const;
  std::int64_t taken_by(QuotaHolder holder) const;
  std::int64_t limit() const { return options_.limit; }

 private:
  using Amounts = std::unordered_map<std::int64_t, std::int64_t>;

  const FairQuotaOptions options_;
  mutable std::mutex mutex_;
  std::int64_t taken_ = 0;
  Amounts groups_;
  Amounts members_;  // numbers of members are unique among all groups
};

// A part of a quota, given back at its end.
class QuotaShare {
 public:
  QuotaShare() = default;  // of nothing
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
    if (quota_ != nullptr) quota_->GiveBack(holder_, amount_);
  }

  // Nothing when the quota refuses.
  static std::optional<QuotaShare> Take(FairQuota& quota, const ClientId& client,
                                        std::int64_t amount = 1) {
    const QuotaHolder holder = HolderOf(client);
    if (quota.Take(holder, amount)) return std::nullopt;
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
