// Hides that the rows are joint states, so that each is answered without the SIMD code.
#pragma once

#include <cstddef>
#include <span>

#include "collision/query/query.h"

namespace cwm::collision {

class PlainRows : public BodyRows {
 public:
  explicit PlainRows(const BodyRows& rows) : rows_(rows) {}
  std::size_t size() const override { return rows_.size(); }
  void Place(std::size_t row, std::span<Pose> X_WF) const override { rows_.Place(row, X_WF); }
  bool IsWithinLimits(std::size_t row) const override { return rows_.IsWithinLimits(row); }
  std::optional<int> VariableOutOfLimits(std::size_t row) const override {
    return rows_.VariableOutOfLimits(row);
  }

 private:
  const BodyRows& rows_;
};

}  // namespace cwm::collision
