// The search of one edge of a body, pair by pair.
#pragma once

#include <cstdint>

#include "collision/motion/body_motion.h"
#include "collision/motion/open_times.h"
#include "collision/query/body_search.h"

namespace cwm::collision {

enum class MotionVerdict : std::uint8_t {
  kNotComputed,
  kFree,         // every distance stays at or above its margin, all along; never wrong
  kContact,      // a pair is below its margin at `hi`; never wrong
  kGrazing,      // a pair comes within kGrazingTolerance_m of its margin; none is deeper below it
  kUndecided,    // the work or the accuracy of the answers did not suffice
  kOutOfLimits,  // for a path: a row is outside the limits of the body
};

// A gap up to this counts as touching.
inline constexpr double kGrazingTolerance_m = 1e-6;
// The width of the bracket around the first contact, as a share of the edge.
inline constexpr double kMaxBracketWidth = 1e-4;
// chosen: pairs that may come as near as this are measured; no larger clearance is reported.
inline constexpr double kMaxClearance_m = 0.02;

struct EdgeResult {
  MotionVerdict verdict = MotionVerdict::kFree;
  double lo = 0, hi = 1, clearance_m = kMaxClearance_m;  // as in MotionColumns
  PairId pair = {};
  Accuracy accuracy = Accuracy::kExact;
};

// A single row: the body at a fraction of an edge.
class EdgeRow : public BodyRows {
 public:
  EdgeRow(const BodyMotion& motion, double fraction) : motion_(motion), fraction_(fraction) {}
  std::size_t size() const override { return 1; }
  void Place(std::size_t, std::span<Pose> X_WF) const override { motion_.Place(fraction_, X_WF); }

 private:
  const BodyMotion& motion_;
  const double fraction_;
};

// The answer for the body of the search. Pairs are known to keep clear outside of their open times.
// No clearance above `max_clearance_m`, which is at most kMaxClearance_m, is measured. Void if the
// search has ended.
EdgeResult SearchEdge(BodySearch& search, const BodyMotion& motion, const OpenTimes& open = {},
                      double max_clearance_m = kMaxClearance_m);

}  // namespace cwm::collision
