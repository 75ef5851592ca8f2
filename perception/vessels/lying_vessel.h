// Finds vessels that lie or lean. Their axis follows from their own surface, not from the support.
#pragma once

#include <optional>
#include <vector>

#include "perception/fit/extraction.h"
#include "perception/vessels/revolved_wall.h"

namespace cwm::perception {

// The axes of round surfaces, and the normals of planes (which may be a vessel's floor), among the
// first few fits.
std::vector<Vector3> AxesOf(const Extraction& extraction);

// Returns the wall whose shell (FitShell) explains the object's points best, unless the shell of
// one of the `standing` walls explains them about as well. It tries the `axes` and, if these
// explain little, the axes that the normals of all points suggest.
std::optional<RevolvedWall> FindLyingWall(const OrientedPoints& object,
                                          const std::vector<RevolvedWall>& standing,
                                          const std::vector<Vector3>& axes,
                                          const FitContext& context);

}  // namespace cwm::perception
