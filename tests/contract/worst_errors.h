// The largest errors of each referee over random poses of pairs of 20 cm shapes, from -20 mm to +1 m:
// what a reader of collision/README.md wants to know before choosing an engine.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "collision/geometry/shape.h"

namespace cwm::collision {

enum class Referee { kExact, kFcl, kBullet, kLibccd };
inline constexpr int kRefereeCount = 4;

// Metres; nothing where the referee never answered itself: an answer that the kernels stood in for
// is not the engine's.
struct WorstError {
  std::optional<double> apart_m;        // of distances of pairs that are 0 to 1 m apart
  std::optional<double> overlapping_m;  // of depths up to 20 mm
};

struct PairErrors {
  std::string pair;                          // "box – cone"
  std::array<WorstError, kRefereeCount> of;  // by Referee
};

// First of pairs whose distances anyone can work out: a box of 1 m, and others along x from its middle.
// Then sphere, box, cylinder, cone, capsule, half-space and plate, each with each but two half-spaces. The
// truth comes from formulas in extended precision, or from searches over all directions with the
// heights of the shapes: no code of the kernels.
std::vector<PairErrors> MeasureWorstErrors(int poses_per_pair);

// As a table in Markdown; errors rounded up to one digit.
std::string TableOf(const std::vector<PairErrors>& all);

}  // namespace cwm::collision
