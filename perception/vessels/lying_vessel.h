// Vessels that lie or lean: of an axis that their own surface tells, not what they stand on.
#pragma once

#include <optional>
#include <vector>

#include "perception/fit/extraction.h"
#include "perception/vessels/revolved_wall.h"

namespace cwm::perception {

// Of round surfaces and the normals of planes, which may be floors: of the first few of the fits.
std::vector<Vector3> AxesOf(const Extraction& extraction);

// The wall about which a shell (FitShell) accounts for the object's points, where no shell about one of
// the `standing` walls does so about as well. Asked are the `axes`, and where these account for little,
// what the normals of all points suggest.
std::optional<RevolvedWall> FindLyingWall(const OrientedPoints& object,
                                          const std::vector<RevolvedWall>& standing,
                                          const std::vector<Vector3>& axes,
                                          const FitContext& context);

}  // namespace cwm::perception
