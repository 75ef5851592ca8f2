// Which way the parts of a mesh are wound.
#pragma once

#include "collision/geometry/triangle_mesh.h"

namespace cwm {

// A watertight mesh with its parts wound outward: each that lies in no other is turned over where its
// volume is negative, and what lies in it along with it, so that a cavity stays one. With more than
// 1 000 parts it is turned as a whole.
TriangleMesh WoundOutward(TriangleMesh mesh);

}  // namespace cwm
