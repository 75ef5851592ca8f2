// Closed forms with line segments: the cores of capsules.
#pragma once

#include "collision/geometry/shape.h"
#include "collision/kernels/pair_answer.h"

namespace cwm::collision {

struct Segment {
  Vector3 a, b;
};

// Never negative. Where the segments meet, the normal is perpendicular to both: parting two
// capsules along it takes least.
PairDistance SegmentToSegment(const Segment& a, const Segment& b);

// The segment is given in the box's frame; A is the box. Negative where it enters the box.
PairDistance BoxToSegment(const Box& box, const Segment& segment);

}  // namespace cwm::collision
