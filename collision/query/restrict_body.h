// The body of a query that is restricted to named members (QueryOptions::only).
#pragma once

#include <span>

#include "collision/query/query.h"

namespace cwm::collision {

// Restricts the body to what `only` names; the world is restricted by WorldFilter.
//
// Links of the robot, with the objects on them, and attached objects restrict the frames: parts in
// other frames are not tested against the world, and self pairs count if one of their parts is in a
// named frame. If no frame is named, all frames are tested, but self pairs only count if the name
// of the body itself is among the names. Names and links that do not exist have no effect. An empty
// list restricts nothing.
QueryBody RestrictBody(QueryBody body, std::span<const NamedThing> only);

}  // namespace cwm::collision
