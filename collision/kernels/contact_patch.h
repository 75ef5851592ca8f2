// Contact patches: several contact points of two solids that touch along an edge or a face.
#pragma once

#include <vector>

#include "collision/kernels/exact.h"

namespace cwm::collision {

// chosen: points of a patch besides the deepest one. The contact of two faces is defined by its
// corners, and four of them span nearly all of its area.
inline constexpr int kMaxPatchPoints = 4;

struct ContactLimits {
  double max_distance_m = 0;
  int max_count = 1;
  WorkCounter* work = nullptr;  // see ExactDistance
};

// Appends at most max_count contacts of A and B with distance_m < max_distance_m to `contacts`, in
// frame F. The first is the answer of ExactDistance. If faces or edges are foremost along its
// normal (contact_feature.h), the further contacts are corners of the intersection of their
// projections onto the plane across the normal: the deepest corner, the one farthest from that, and
// one to either side of the line between them. Corners at the position of another contact are left
// out. Further contacts have the normal and the accuracy of the first one, and points on both
// surfaces that lie on a line along the normal. Their distance is the signed one along that line,
// never less than the first, and they are ordered deepest first.
//
// In a mesh each triangle has its own feature, which may be a single corner (the legs of a table
// stand on these). The further contacts span the features of the first 65536 pairs of near
// triangles whose distance along the normal is below max_distance_m and not less than the first.
// Two half-spaces have only the first contact.
void ExactContacts(const PlacedExact& a, const PlacedExact& b, const ContactLimits& limits,
                   std::vector<PairDistance>& contacts);

}  // namespace cwm::collision
