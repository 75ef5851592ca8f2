#include "server/core/memory_budget.h"

#include <algorithm>
#include <array>
#include <limits>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/core/error.h"

namespace cwm::server {
namespace {

// chosen: requests in flight end within seconds; a retry sooner would rarely find free memory.
constexpr double kRetryAfter_s = 1;

// A single world may have three quarters of the worlds' part; a single client, half of what is
// free.
constexpr double kWorldShare = 3;
constexpr double kClientShare = 1;

std::string AccountText(const MemoryBudget::Payer& payer, FairQuota::Refusal refusal,
                        std::string& account) {
  const bool is_world = payer.kind == MemoryBudget::Payer::Kind::kWorld;
  if (refusal == FairQuota::Refusal::kLimit) {
    account = is_world ? "worlds" : "server";
    return is_world ? "the account of all worlds" : "the account of the server";
  }
  if (is_world) {
    account = "world";
    return absl::StrCat("the account of the world \"", payer.name, "\"");
  }
  account = refusal == FairQuota::Refusal::kGroup ? "user" : "client";
  return refusal == FairQuota::Refusal::kGroup ? "the account of this user"
                                               : "the account of this connection";
}

absl::Status Exhausted(const MemoryBudget::Payer& payer, FairQuota::Refusal refusal,
                       std::int64_t asked, std::int64_t taken, std::int64_t limit) {
  std::string account;
  const std::string who = AccountText(payer, refusal, account);
  return MakeError(
      absl::StatusCode::kResourceExhausted,
      absl::StrCat("memory: ", who, " has no room for ", FormatBytes(asked),
                   " more: ", FormatBytes(taken), " of ", FormatBytes(limit),
                   refusal == FairQuota::Refusal::kLimit ? " are taken"
                                                         : " are taken, and the rest is shared"),
      {.reason = "MEMORY_EXHAUSTED",
       .fields = {},
       .metadata = {{"account", account},
                    {"asked_bytes", std::to_string(asked)},
                    {"taken_bytes", std::to_string(taken)},
                    {"limit_bytes", std::to_string(limit)}},
       .retry_after_s = kRetryAfter_s});
}

}  // namespace

std::string FormatBytes(std::int64_t bytes) {
  constexpr std::array<const char*, 5> kUnits = {"bytes", "KiB", "MiB", "GiB", "TiB"};
  double value = static_cast<double>(bytes);
  std::size_t unit = 0;
  for (; value >= 1024 && unit + 1 < kUnits.size(); ++unit) value /= 1024;
  return unit == 0 ? absl::StrCat(bytes, " bytes")
                   : absl::StrFormat("%.1f %s", value, kUnits[unit]);
}

MemoryBudget::MemoryBudget(std::int64_t limit_bytes)
    : clients_({.limit = limit_bytes, .group_share = 3, .member_share = kClientShare}),
      // All worlds are one group, whose share is the limit itself.
      worlds_({.limit = limit_bytes / 4 * 3,
               .group_share = std::numeric_limits<double>::infinity(),
               .member_share = kWorldShare}) {}

std::shared_ptr<MemoryBudget> MemoryBudget::Make(std::int64_t limit_bytes) {
  return std::shared_ptr<MemoryBudget>(new MemoryBudget(limit_bytes));
}

MemoryBudget::Payer MemoryBudget::Client(const ClientId& client) {
  return {.kind = Payer::Kind::kClient, .holder = HolderOf(client), .name = {}};
}

MemoryBudget::Payer MemoryBudget::World(std::int64_t number, std::string name) {
  return {.kind = Payer::Kind::kWorld,
          .holder = {.group = 0, .member = number},
          .name = std::move(name)};
}

std::int64_t MemoryBudget::NextWorldNumber() { return ++last_world_; }

absl::StatusOr<MemoryCharge> MemoryBudget::Charge(const Payer& payer, std::int64_t bytes) {
  if (absl::Status taken = TryTake(payer, bytes); !taken.ok()) return taken;
  MemoryCharge charge = MemoryCharge::Empty(shared_from_this(), payer);
  charge.bytes_ = bytes;
  return charge;
}

absl::Status MemoryBudget::TryTake(const Payer& payer, std::int64_t bytes) {
  const bool is_world = payer.kind == Payer::Kind::kWorld;
  // Neither kind of payer may take memory that the other has of the whole.
  const std::int64_t reserved =
      is_world ? std::max<std::int64_t>(0, clients_.taken() + worlds_.limit() - clients_.limit())
               : worlds_.taken();
  FairQuota& quota = is_world ? worlds_ : clients_;
  const auto refusal = quota.TryTake(payer.holder, bytes, reserved);
  if (!refusal) return absl::OkStatus();
  return Exhausted(payer, *refusal, bytes, quota.taken() + reserved, quota.limit());
}

void MemoryBudget::ForceTake(const Payer& payer, std::int64_t bytes) {
  (payer.kind == Payer::Kind::kWorld ? worlds_ : clients_).ForceTake(payer.holder, bytes);
}

void MemoryBudget::Release(const Payer& payer, std::int64_t bytes) {
  (payer.kind == Payer::Kind::kWorld ? worlds_ : clients_).Release(payer.holder, bytes);
}

MemoryCharge MemoryCharge::Empty(std::shared_ptr<MemoryBudget> budget, MemoryBudget::Payer payer) {
  MemoryCharge charge;
  charge.budget_ = std::move(budget);
  charge.payer_ = std::move(payer);
  return charge;
}

absl::Status MemoryCharge::Resize(std::int64_t bytes) {
  if (budget_ == nullptr) return absl::OkStatus();
  if (bytes > bytes_) {
    if (absl::Status taken = budget_->TryTake(payer_, bytes - bytes_); !taken.ok()) return taken;
  } else if (bytes < bytes_) {
    budget_->Release(payer_, bytes_ - bytes);
  }
  bytes_ = bytes;
  return absl::OkStatus();
}

void MemoryCharge::ForceResize(std::int64_t bytes) {
  if (budget_ == nullptr) return;
  if (bytes > bytes_) budget_->ForceTake(payer_, bytes - bytes_);
  if (bytes < bytes_) budget_->Release(payer_, bytes_ - bytes);
  bytes_ = bytes;
}

}  // namespace cwm::server
