// Whether a body meets the world, or itself, on its way: certified, never sampled. Between two
// fractions of an edge at which the distances are known, no pair can have closed by more than its
// parts can have travelled (conservative advancement: Mirtich 1996; with bounds on rotation as of
// Zhang, Lee and Kim 2006); where that is not enough, the edge is halved.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/motion/body_motion.h"
#include "collision/query/query.h"

namespace cwm::collision {

enum class MotionVerdict : std::uint8_t {
  kNotComputed,
  kFree,       // every distance stays at or above its margin, all along: never wrong
  kContact,    // some pair is below its margin at `hi`: never wrong
  kGrazing,    // no contact found, but a pair comes within kGrazing_m of its margin
  kUndecided,  // the work or the trust of the answers did not suffice
};

// A gap of this and less is not told from touching.
inline constexpr double kGrazing_m = 1e-6;
// How narrowly the first contact is bracketed, as a share of the edge.
inline constexpr double kBracket = 1e-4;

// One entry an edge.
struct MotionColumns {
  std::vector<MotionVerdict> verdict;
  // Of a contact: free up to `lo`, in contact at `hi`, hi - lo <= kBracket; an edge that begins in
  // contact has 0 and 0. Of a grazing or undecided one where that is. Else 0 and 1.
  std::vector<double> lo, hi;
  // Of a free edge: no pair comes nearer to its margin than that, which is 2 cm at most: what stays
  // farther away is not measured. 0 for the others.
  std::vector<double> clearance_m;
  // The pair of the contact, as in CollisionColumns; -1 where none is named.
  std::vector<std::int32_t> object, body_part, object_part;
  std::size_t completed = 0;  // edges answered
};

// By the exact kernels or AUTO: Unimplemented when another engine is asked for by name. Margins as in
// CheckCollisions. Limits of joints are not looked at: between two states within them lie none
// beyond. Cancelled when `stop` is.
absl::StatusOr<MotionColumns> CheckMotions(const WorldSnapshot& world, const QueryBody& body,
                                           std::span<const std::unique_ptr<BodyMotion>> edges,
                                           const QueryOptions& options, std::stop_token stop = {});

}  // namespace cwm::collision
