#include "server/core/fair_quota.h"

#include <algorithm>

namespace cwm::server {
namespace {

constexpr std::int64_t kUnknownUser = -1;  // user ids are not negative

std::int64_t AmountOf(const std::unordered_map<std::int64_t, std::int64_t>& amounts,
                      std::int64_t key) {
  const auto found = amounts.find(key);
  return found == amounts.end() ? 0 : found->second;
}

void Subtract(std::unordered_map<std::int64_t, std::int64_t>& amounts, std::int64_t key,
              std::int64_t amount) {
  const auto found = amounts.find(key);
  if (found == amounts.end()) return;
  found->second -= amount;
  if (found->second <= 0) amounts.erase(found);
}

}  // namespace

QuotaHolder HolderOf(const ClientId& client) {
  return {.group = client.uid ? static_cast<std::int64_t>(*client.uid) : kUnknownUser,
          .member = client.connection};
}

std::optional<FairQuota::Refusal> FairQuota::TryTake(QuotaHolder holder, std::int64_t amount,
                                                     std::int64_t reserved) {
  if (amount <= 0) return std::nullopt;
  const std::lock_guard lock(mutex_);
  const std::int64_t free = options_.limit - reserved - taken_;
  if (amount > free) return Refusal::kLimit;
  const std::int64_t group = AmountOf(groups_, holder.group) + amount;
  const double of_group = options_.group_share * static_cast<double>(free);
  if (static_cast<double>(group) > of_group) return Refusal::kGroup;
  // Members share the rest of their group's part, so that new members of the group find room, too.
  const double room =
      std::min(static_cast<double>(free), of_group - static_cast<double>(group - amount));
  const std::int64_t member = AmountOf(members_, holder.member) + amount;
  if (member > options_.member_limit ||
      static_cast<double>(member) > options_.member_share * room) {
    return Refusal::kMember;
  }
  groups_[holder.group] = group;
  members_[holder.member] = member;
  taken_ += amount;
  return std::nullopt;
}

void FairQuota::ForceTake(QuotaHolder holder, std::int64_t amount) {
  const std::lock_guard lock(mutex_);
  groups_[holder.group] += amount;
  members_[holder.member] += amount;
  taken_ += amount;
}

void FairQuota::Release(QuotaHolder holder, std::int64_t amount) {
  const std::lock_guard lock(mutex_);
  taken_ -= amount;
  Subtract(groups_, holder.group, amount);
  Subtract(members_, holder.member, amount);
}

std::int64_t FairQuota::taken() const {
  const std::lock_guard lock(mutex_);
  return taken_;
}

std::int64_t FairQuota::taken_by(QuotaHolder holder) const {
  const std::lock_guard lock(mutex_);
  return AmountOf(members_, holder.member);
}

}  // namespace cwm::server
