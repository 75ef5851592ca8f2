#include "clients/planner/edge_batch.h"

#include <algorithm>
#include <cmath>

namespace cwm::planner {

std::size_t EdgeBatch::Add(std::span<const double> from, std::span<const double> to, double step,
                           std::size_t parts) {
  begins_.push_back(rows_.size() / space_.width());
  const double steps = std::ceil(space_.Distance(from, to) / step);
  const std::size_t count = parts * std::max<std::size_t>(1, static_cast<std::size_t>(steps));
  for (std::size_t k = 1; k <= count; ++k) {
    rows_.resize(rows_.size() + space_.width());
    const std::span<double> row(rows_.end() - static_cast<std::ptrdiff_t>(space_.width()),
                                rows_.end());
    space_.Interpolate(from, to, static_cast<double>(k) / static_cast<double>(count), row);
  }
  return begins_.size() - 1;
}

std::size_t EdgeBatch::Add(std::span<const double> row) {
  begins_.push_back(rows_.size() / space_.width());
  rows_.insert(rows_.end(), row.begin(), row.end());
  return begins_.size() - 1;
}

absl::Status EdgeBatch::CheckAll() {
  const auto free = checker_.CheckStates(rows_, space_.width());
  if (!free.ok()) return free.status();
  free_fractions_.clear();
  for (std::size_t i = 0; i < begins_.size(); ++i) {
    const auto begin = free->begin() + static_cast<std::ptrdiff_t>(begins_[i]);
    const auto end = i + 1 < begins_.size()
                         ? free->begin() + static_cast<std::ptrdiff_t>(begins_[i + 1])
                         : free->end();
    const auto hit = std::find(begin, end, std::uint8_t{0});
    free_fractions_.push_back(static_cast<double>(hit - begin) / static_cast<double>(end - begin));
  }
  rows_.clear();
  begins_.clear();
  return absl::OkStatus();
}

}  // namespace cwm::planner
