// Compares answers about edges with states along them.
#pragma once

#include <gtest/gtest.h>

#include <span>
#include <utility>
#include <vector>

#include "collision/motion/check_motions.h"

namespace cwm::collision {

// The body at several fractions of an edge.
class FractionRows : public BodyRows {
 public:
  FractionRows(const BodyMotion& motion, std::vector<double> fractions)
      : motion_(motion), fractions_(std::move(fractions)) {}
  std::size_t size() const override { return fractions_.size(); }
  void Place(std::size_t row, std::span<Pose> X_WF) const override {
    motion_.Place(fractions_[row], X_WF);
  }

 private:
  const BodyMotion& motion_;
  const std::vector<double> fractions_;
};

// The numbers of verdicts that were compared with dense samples.
struct Tally {
  int free = 0, contact = 0, other = 0;
};

inline void ExpectTrue(const WorldSnapshot& world, const QueryBody& body, const BodyMotion& motion,
                       const MotionColumns& columns, std::size_t edge, int steps, Tally& result) {
  std::vector<double> fractions;
  for (int k = 0; k <= steps; ++k) fractions.push_back(static_cast<double>(k) / steps);
  const auto sampled = *CheckCollisions(world, body, FractionRows(motion, fractions), {});
  for (int k = 0; k <= steps; ++k) {
    const double fraction = fractions[static_cast<std::size_t>(k)];
    const bool collides = sampled.verdict[static_cast<std::size_t>(k)] == Verdict::kCollision;
    if (!collides) continue;
    EXPECT_NE(columns.verdict[edge], MotionVerdict::kFree) << edge << " at " << fraction;
    if (columns.verdict[edge] == MotionVerdict::kContact) {
      EXPECT_GE(fraction, columns.lo[edge]) << edge;
    }
    break;
  }
  switch (columns.verdict[edge]) {
    case MotionVerdict::kFree:
      ++result.free;
      break;
    case MotionVerdict::kContact: {
      ++result.contact;
      EXPECT_EQ(
          CheckCollisions(world, body, FractionRows(motion, {columns.hi[edge]}), {})->verdict[0],
          Verdict::kCollision)
          << edge;
      EXPECT_LE(columns.hi[edge] - columns.lo[edge], kMaxBracketWidth);
      break;
    }
    default:
      ++result.other;
  }
}

}  // namespace cwm::collision
