// Closed forms with line segments: the cores of capsules.
#pragma once

#include "collision/geometry/shape.h"
#include "collision/kernels/pair_distance.h"

namespace cwm::collision {

struct Segment {
  Vector3 a, b;
};

// The distance of two segments, never negative. If they meet, the normal is perpendicular to both,
// since two capsules are separated by the minimum translation along it.
PairDistance SegmentToSegment(const Segment& a, const Segment& b);

// The distance of a box (A) and a segment in the box's frame; negative if the segment enters the
// box.
PairDistance BoxToSegment(const Box& box, const Segment& segment);

}  // namespace cwm::collision
