// Poses in the world, by numbers or by an object's name.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "clients/cli/session.h"
#include "clients/cpp/row_bytes.h"

namespace cwm::cli {

// The forms of a pose, for the help.
inline constexpr char kPoseArgumentForm[] = "X,Y,Z[,QX,QY,QZ,QW]|NAME[+DX,DY,DZ]";

// Parses "x,y,z", "x,y,z,qx,qy,qz,qw", or an object's name, optionally with an offset along the
// world's axes: "mug+0,0,0.2". A name means the centre of the object's bounding box (its origin if
// it has none), without rotation; the server is asked for it.
absl::StatusOr<client::PoseRow> ParsePoseArgument(Session& session, const std::string& text,
                                                  const std::string& option);

}  // namespace cwm::cli
