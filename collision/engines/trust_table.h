// The table of trust: what an engine may be asked, pair by pair, on one screen. Each engine states
// its own at the top of its file; nothing else decides what reaches a foreign library.
#pragma once

#include <array>
#include <cstdint>

#include "collision/engines/engine.h"

namespace cwm::collision {

enum class Ability : std::uint8_t {
  kNothing,   // never passed on: unsupported, wrong, or a crash
  kCollides,  // yes and no only
  kAll,       // yes and no, distance, depth, contacts
};

// By the order of ShapeKind; symmetric.
using TrustTable = std::array<std::array<Ability, kShapeKindCount>, kShapeKindCount>;

constexpr bool Allows(const TrustTable& table, ShapeKind a, ShapeKind b, Question question) {
  const Ability ability = table[static_cast<int>(a)][static_cast<int>(b)];
  return ability == Ability::kAll ||
         (ability == Ability::kCollides && question == Question::kCollides);
}

constexpr bool IsSymmetric(const TrustTable& table) {
  for (int a = 0; a < kShapeKindCount; ++a) {
    for (int b = 0; b < a; ++b) {
      if (table[a][b] != table[b][a]) return false;
    }
  }
  return true;
}

}  // namespace cwm::collision
