// The capability table: the queries that an engine supports for each pair of shapes. Each
// engine defines its own at the top of its file; nothing else decides which calls reach a foreign
// library.
#pragma once

#include <array>
#include <cstdint>

#include "collision/engines/engine.h"

namespace cwm::collision {

enum class Capability : std::uint8_t {
  kNothing,   // never passed on: unsupported, wrong, or a crash
  kCollides,  // collision checks only
  kAll,       // collision checks, distance, depth and contacts
};

// Indexed by ShapeKind; symmetric.
using CapabilityTable = std::array<std::array<Capability, kShapeKindCount>, kShapeKindCount>;

constexpr bool Allows(const CapabilityTable& table, ShapeKind a, ShapeKind b, QueryKind query) {
  const Capability capability = table[static_cast<int>(a)][static_cast<int>(b)];
  return capability == Capability::kAll ||
         (capability == Capability::kCollides && query == QueryKind::kCollides);
}

constexpr bool IsSymmetric(const CapabilityTable& table) {
  for (int a = 0; a < kShapeKindCount; ++a) {
    for (int b = 0; b < a; ++b) {
      if (table[a][b] != table[b][a]) return false;
    }
  }
  return true;
}

}  // namespace cwm::collision
