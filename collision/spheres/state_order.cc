#include "collision/spheres/state_order.h"

#include <algorithm>

namespace cwm::collision {

StateOrder::StateOrder(const SphereProgram& program) {
  const std::size_t inputs = program.inputs.size();
  std::vector<double> sweep_m;
  for (const LaneInput& input : program.inputs) {
    sweep_m.push_back((input.turns ? input.lever_m : 1.0) * (input.upper - input.lower));
  }
  std::vector<std::vector<int>> bits(inputs);  // bits of the key, from the first halving on
  for (int bit = kHalvings - 1; bit >= 0 && inputs > 0; --bit) {
    const auto widest = std::max_element(sweep_m.begin(), sweep_m.end());
    *widest /= 2;
    bits[static_cast<std::size_t>(widest - sweep_m.begin())].push_back(bit);
  }
  for (std::size_t k = 0; k < inputs; ++k) {
    const std::size_t halvings = bits[k].size();
    const double range = program.inputs[k].upper - program.inputs[k].lower;
    if (halvings == 0 || !(range > 0)) continue;
    Axis& axis = axes_.emplace_back();
    const std::size_t cells = std::size_t{1} << halvings;
    axis.input = k;
    axis.cells.lower = static_cast<float>(program.inputs[k].lower);
    axis.cells.cells_per_unit = static_cast<float>(static_cast<double>(cells) / range);
    for (std::size_t cell = 0; cell < cells; ++cell) {
      std::uint32_t key = 0;
      for (std::size_t h = 0; h < halvings; ++h) {
        const auto half = static_cast<std::uint32_t>(cell >> (halvings - 1 - h) & 1);
        key |= half << bits[k][h];
      }
      axis.cells.key_of_cell.push_back(key);
    }
  }
}

std::span<const std::uint32_t> StateOrder::Sort(const float* values, std::size_t stride,
                                                std::size_t count) {
  keys_.assign(count, 0);
  for (const Axis& axis : axes_) {
    AddKeys(axis.cells, values + axis.input * stride, count, keys_.data());
  }
  begin_.assign((std::size_t{1} << kHalvings) + 1, 0);
  for (const std::uint32_t key : keys_) ++begin_[key + 1];
  for (std::size_t k = 1; k < begin_.size(); ++k) begin_[k] += begin_[k - 1];
  order_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    order_[begin_[keys_[i]]++] = static_cast<std::uint32_t>(i);
  }
  return order_;
}

}  // namespace cwm::collision
