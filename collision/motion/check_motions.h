// Whether a body meets the world, or itself, on its way: certified, never sampled. Between two
// fractions of an edge at which the distances are known, no pair can have closed by more than its
// parts can have travelled (conservative advancement: Mirtich 1996; with bounds on rotation as of
// Zhang, Lee and Kim 2006), nor, where a plane parts the two, by more than they can have travelled
// along its normal; where that is not enough, the edge is halved.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/motion/body_motion.h"
#include "collision/query/body_search.h"
#include "collision/query/object_ranks.h"
#include "collision/query/query.h"

namespace cwm::collision {

enum class MotionVerdict : std::uint8_t {
  kNotComputed,
  kFree,         // every distance stays at or above its margin, all along: never wrong
  kContact,      // some pair is below its margin at `hi`: never wrong
  kGrazing,      // a pair comes within kGrazing_m of its margin, and none deeper below it than that
  kUndecided,    // the work or the trust of the answers did not suffice
  kOutOfLimits,  // of a path: it has a row that the body cannot be in
};

// A gap of this and less is not told from touching.
inline constexpr double kGrazing_m = 1e-6;
// How narrowly the first contact is bracketed, as a share of the edge.
inline constexpr double kBracket = 1e-4;

// One entry a motion: an edge, or a path of several (check_paths.h).
struct MotionColumns {
  std::vector<MotionVerdict> verdict;
  // Of what is not free the edge of the motion that the other columns are about, from 0; of a path
  // out of limits its first row that is. -1 where the motion is free or not computed.
  std::vector<std::int32_t> segment;
  // Shares of the edge. Of a contact: free up to `lo`, in contact at `hi`, hi - lo <= kBracket unless
  // something grazes before it, or comes so near for so long that it is not proven free; an edge that
  // begins in contact has 0 and 0. Of a grazing or undecided one where that is. Else 0 and 1.
  std::vector<double> lo, hi;
  // Of a free motion: no pair comes nearer to its margin than that, which is 2 cm at most: what stays
  // farther away is not measured. 0 for the others.
  std::vector<double> clearance_m;
  // The pair of the contact, or with UnseenSpace::kReport of the unseen space that the motion would
  // pass through; as in CollisionColumns; -1 where none is named.
  std::vector<std::int32_t> object, body_part, object_part;
  // As of a state's verdict, CollisionColumns: of a contact, and of what is undecided, that of the pair
  // that told; of a motion that is free or grazes, the weakest of the pairs that can come near on its
  // way.
  std::vector<Trust> trust;
  // Of the robot that moves: of a path out of limits what its first row that is leaves them by, as in
  // CollisionColumns; else -1. Empty where no path is, and of edges alone.
  std::vector<std::int32_t> variable = {};
  std::size_t completed = 0;  // motions answered
};

// One entry of the columns.
struct MotionAnswer {
  MotionVerdict verdict = MotionVerdict::kNotComputed;
  std::int32_t segment = -1;
  double lo = 0, hi = 1, clearance_m = 0;
  std::int32_t object = -1, body_part = -1, object_part = -1;
  Trust trust = Trust::kExact;
};
void Append(MotionColumns& columns, const MotionAnswer& answer);

// Edges one after the other, for who decides by the last which is next. Used by one thread.
class EdgeChecker {
 public:
  EdgeChecker(const WorldSnapshot& world, const QueryBody& body, const QueryOptions& options,
              const Interrupt& interrupt);

  // Unimplemented when an engine is asked for by name that cannot certify.
  static absl::Status CheckEngine(const QueryOptions& options);

  // As segment 0. Void once `ended`.
  MotionAnswer Check(const BodyMotion& edge);
  // Whether the last answer is void: interrupted, or an engine had no answer.
  bool ended() const { return search_.ended() || (with_unseen_ && with_unseen_->ended()); }
  // Of the body: no answer is labelled better.
  Trust best_trust() const { return body_.best_trust; }
  // To be asked before each motion.
  bool MustEnd() { return search_.MustEnd(); }
  // Of the whole call: OK when the motions so far are the answer.
  absl::Status Finish() const;

 private:
  const QueryBody& body_;
  BodySearch search_;
  // Where unseen space is to be told of: `search_` knows nothing of it, this one does.
  std::optional<BodySearch> with_unseen_;
  ObjectRanks ranks_;
};

// By the exact kernels or AUTO: Unimplemented when another engine is asked for by name. Margins as in
// CheckCollisions. Limits of joints are not looked at: between two states within them lie none
// beyond. Cancelled when `stop` is.
absl::StatusOr<MotionColumns> CheckMotions(const WorldSnapshot& world, const QueryBody& body,
                                           std::span<const std::unique_ptr<BodyMotion>> edges,
                                           const QueryOptions& options, std::stop_token stop = {});

}  // namespace cwm::collision
