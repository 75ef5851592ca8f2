// A budget that ends at a look of its own, for tests of what is read and done under one.
#pragma once

#include <cstdint>

#include "server/core/work_budget.h"

namespace cwm::server {

// As a caller who goes away before the n-th look, counted from 1.
class EndsAtLook : public WorkBudget {
 public:
  explicit EndsAtLook(std::int64_t look) : look_(look) {}

 protected:
  End Look() const override { return looks() >= look_ ? End::kCancelled : End::kNone; }

 private:
  const std::int64_t look_;
};

}  // namespace cwm::server
