// A budget that ends at a chosen check, for tests of code that reads and works under a budget.
#pragma once

#include <cstdint>

#include "server/core/work_budget.h"

namespace cwm::server {

// Behaves like a caller who cancels before the n-th check, counted from 1.
class EndsAtLook : public WorkBudget {
 public:
  explicit EndsAtLook(std::int64_t look) : look_(look) {}

 protected:
  End Look() const override { return looks() >= look_ ? End::kCancelled : End::kNone; }

 private:
  const std::int64_t look_;
};

}  // namespace cwm::server
