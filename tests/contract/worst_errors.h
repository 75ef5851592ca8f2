// The largest errors of each referee over random poses of pairs of 20 cm shapes, from -20 mm to +1
// m. Readers of collision/README.md choose an engine by them.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "collision/geometry/shape.h"

namespace cwm::collision {

enum class Referee { kExact, kFcl, kBullet, kLibccd };
inline constexpr int kRefereeCount = 4;

// In metres. Empty if the referee never answered itself; an answer of the kernels in its place does
// not count.
struct WorstError {
  std::optional<double> apart_m;        // for distances of pairs 0 to 1 m apart
  std::optional<double> overlapping_m;  // for depths up to 20 mm
};

struct PairErrors {
  std::string pair;                          // "box – cone"
  std::array<WorstError, kRefereeCount> of;  // by Referee
};

// The first entry has pairs whose distances are known by hand: a box of 1 m, and other shapes along
// x from its centre. Then follow all pairs of sphere, box, cylinder, cone, capsule, half-space and
// plate, except two half-spaces. The reference values come from formulas in extended precision, or
// from searches over all directions with the extents of the shapes, without code of the kernels.
std::vector<PairErrors> MeasureWorstErrors(int poses_per_pair);

// The errors as a table in Markdown, rounded up to one digit.
std::string TableOf(const std::vector<PairErrors>& all);

}  // namespace cwm::collision
