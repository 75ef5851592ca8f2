// Objects in space, indexed by the cells that their bounds overlap: the neighbour search of the
// quality measures. It shares nothing with the grids of the interpreter that they judge.
#pragma once

#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "collision/geometry/aabb.h"

namespace cwm::benchmarks {

class CellIndex {
 public:
  void Insert(const Aabb& bounds, std::uint32_t id) {
    ForEachCell(bounds, [&](std::uint64_t key) {
      cells_[key].push_back(id);
      return false;
    });
  }

  // True if `holds(id)` for an object whose cells reach within `distance_m` of p. Objects in
  // several cells are tested several times.
  template <class Holds>
  bool AnyNear(const Vector3& p, double distance_m, const Holds& holds) const {
    const Vector3 reach = Vector3::Constant(distance_m);
    return ForEachCell(Aabb(p - reach, p + reach), [&](std::uint64_t key) {
      const auto cell = cells_.find(key);
      if (cell == cells_.end()) return false;
      for (std::uint32_t id : cell->second) {
        if (holds(id)) return true;
      }
      return false;
    });
  }

 private:
  static constexpr double kCell_m = 0.02;  // a few points and triangles of a close scan
  static constexpr int kBits = 21;         // 20 km each way

  static std::int64_t CellOf(double x_m) {
    return static_cast<std::int64_t>(std::floor(x_m / kCell_m)) + (1LL << (kBits - 1));
  }

  template <class Visit>
  static bool ForEachCell(const Aabb& bounds, const Visit& visit) {
    for (std::int64_t x = CellOf(bounds.min().x()); x <= CellOf(bounds.max().x()); ++x) {
      for (std::int64_t y = CellOf(bounds.min().y()); y <= CellOf(bounds.max().y()); ++y) {
        for (std::int64_t z = CellOf(bounds.min().z()); z <= CellOf(bounds.max().z()); ++z) {
          if (visit(static_cast<std::uint64_t>((x << (2 * kBits)) | (y << kBits) | z))) return true;
        }
      }
    }
    return false;
  }

  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

}  // namespace cwm::benchmarks
