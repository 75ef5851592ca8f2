// The edges of an axis-aligned box.
#pragma once

#include <array>

namespace cwm::perception {

// The corners of a box at each end of its twelve edges, as AlignedBox numbers them: a bit an axis.
inline constexpr std::array<std::array<int, 2>, 12> kBoxEdges = {{{0, 1},
                                                                  {2, 3},
                                                                  {4, 5},
                                                                  {6, 7},
                                                                  {0, 2},
                                                                  {1, 3},
                                                                  {4, 6},
                                                                  {5, 7},
                                                                  {0, 4},
                                                                  {1, 5},
                                                                  {2, 6},
                                                                  {3, 7}}};

}  // namespace cwm::perception
