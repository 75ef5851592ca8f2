// Places in the world, by numbers or by an object's name.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "clients/cli/session.h"
#include "clients/cpp/row_bytes.h"

namespace cwm::cli {

// What the help calls the forms.
inline constexpr char kPlaceForm[] = "X,Y,Z[,QX,QY,QZ,QW]|NAME[+DX,DY,DZ]";

// "x,y,z", "x,y,z,qx,qy,qz,qw", or an object's name, alone or with an offset along the world's
// axes: "mug+0,0,0.2". A name stands for the centre of the object's bounding box (its origin when
// it has none), without rotation; the server is asked for it.
absl::StatusOr<client::PoseRow> ParsePlace(Session& session, const std::string& text,
                                           const std::string& option);

}  // namespace cwm::cli
