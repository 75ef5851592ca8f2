// The table of trust: the questions that an engine may be asked about each pair of shapes. Each
// engine defines its own at the top of its file; nothing else decides which calls reach a foreign
// library.
#pragma once

#include <array>
#include <cstdint>

#include "collision/engines/engine.h"

namespace cwm::collision {

enum class Ability : std::uint8_t {
  kNothing,   // never passed on: unsupported, wrong, or a crash
  kCollides,  // collision checks only
  kAll,       // collision checks, distance, depth and contacts
};

// Indexed by ShapeKind; symmetric.
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
