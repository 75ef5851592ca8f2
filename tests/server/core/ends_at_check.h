// A budget that ends at a chosen check, for tests of code that reads and works under a budget.
#pragma once

#include <cstdint>

#include "server/core/work_budget.h"

namespace cwm::server {

// Behaves like a caller who cancels before the n-th check, counted from 1.
class EndsAtCheck : public WorkBudget {
 public:
  explicit EndsAtCheck(std::int64_t check) : check_(check) {}

 protected:
  End Check() const override { return check_count() >= check_ ? End::kCancelled : End::kNone; }

 private:
  const std::int64_t check_;
};

}  // namespace cwm::server
