// Where two solids touch that touch in more than one point.
#pragma once

#include <vector>

#include "collision/kernels/exact.h"

namespace cwm::collision {

// Points of a patch beside the deepest one: what is plane between two faces hangs on its corners, and
// four tell nearly all of its area.
inline constexpr int kMostPatchPoints = 4;

struct ContactLimits {
  double max_distance_m = 0;
  int max_count = 1;
  WorkCounter* work = nullptr;  // see ExactDistance
};

// Contacts of A and B in frame F with distance_m < max_distance_m, at most max_count, appended to
// `contacts`. The first is ExactDistance's answer. Where faces or edges are foremost along its normal
// (contact_feature.h) the further ones are corners of what their shadows on the plane across it have
// in common: the deepest, the one farthest from that, and one to either side of their line; those
// that lie where another contact does are left out. They have the first one's normal and trust, and
// points on both surfaces that lie on a line along it; their distance is the signed one along that
// line, never less than the first, which they follow deepest first.
//
// Of a mesh each triangle has a feature of its own, single corners among them: legs of a table stand on
// these. The further ones span all of them whose distance along the normal is below max_distance_m and
// no less than the first, of the first 65536 pairs that lie near each other. Of two half-spaces the first
// alone is told.
void ExactContacts(const PlacedExact& a, const PlacedExact& b, const ContactLimits& limits,
                   std::vector<PairDistance>& contacts);

}  // namespace cwm::collision
