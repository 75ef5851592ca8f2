// Continuous collision checking of a body against the world and itself, certified instead of
// sampled. Between two fractions of an edge at which distances are known, no pair can have closed
// by more than its parts can have travelled (conservative advancement, Mirtich 1996, with the
// bounds on rotation of Zhang, Lee and Kim 2006). If a plane separates the pair, it cannot have
// closed by more than the travel along the normal. If these bounds do not suffice, the interval is
// halved.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/motion/body_motion.h"
#include "collision/motion/edge_search.h"
#include "collision/motion/sphere_motion.h"
#include "collision/motion/waypoints.h"
#include "collision/query/body_search.h"
#include "collision/query/object_ranks.h"
#include "collision/query/query.h"

namespace cwm::collision {

// Columns with one entry per motion: an edge, or a path of several edges (check_paths.h).
struct MotionColumns {
  std::vector<MotionVerdict> verdict;
  // The index of the edge that the other columns describe, from 0, if the motion is not free; for a
  // path out of limits, the index of its first row out of limits. -1 if the motion is free or not
  // computed.
  std::vector<std::int32_t> segment;
  // Fractions of the edge. For a contact: free up to `lo`, in contact at `hi`, hi - lo <=
  // kMaxBracketWidth unless a pair before it grazes, or stays so near for so long that it is not
  // proven free; both are 0 if the edge begins in contact. For a grazing or undecided motion: the
  // interval in question. Else 0 and 1.
  std::vector<double> lo, hi;
  // For a free motion: no pair comes nearer to its margin than this. It is at most 2 cm, since
  // larger distances are not measured. 0 for other motions.
  std::vector<double> clearance_m;
  // The pair in contact, as in CollisionColumns; with UnseenSpace::kReport also the unseen space
  // that an undecided motion would pass through. -1 if none is named.
  std::vector<std::int32_t> object, body_part, object_part;
  // The accuracy, as for the verdict of a state in CollisionColumns: of the deciding pair for a
  // contact and an undecided motion; the weakest of all pairs that can come near on the way for a
  // motion that is free or grazes.
  std::vector<Accuracy> accuracy;
  // For a path out of limits: the variable that its first such row violates, as in
  // CollisionColumns; else -1. Empty if no path is out of limits, and for single edges.
  std::vector<std::int32_t> variable = {};
  std::size_t completed = 0;  // number of motions answered
};

// One entry of the columns.
struct MotionResult {
  MotionVerdict verdict = MotionVerdict::kNotComputed;
  std::int32_t segment = -1;
  double lo = 0, hi = 1, clearance_m = 0;
  std::int32_t object = -1, body_part = -1, object_part = -1;
  Accuracy accuracy = Accuracy::kExact;
};
void Append(MotionColumns& columns, const MotionResult& answer);

// Checks edges one after the other, for callers that choose the next edge by the last answer. Used
// by one thread.
class EdgeChecker {
 public:
  EdgeChecker(const WorldSnapshot& world, const QueryBody& body, const QueryOptions& options,
              const Interrupt& interrupt);

  // Unimplemented if the options name an engine that cannot certify motions.
  static absl::Status CheckEngine(const QueryOptions& options);

  // Checks edges between these rows by their spheres first. Refers to the rows.
  void UseSpheresOf(const WorldSnapshot& world, const JointRows& rows, const QueryOptions& options);

  // The answer, with segment 0 if the edge is not free. Void once `ended`.
  MotionResult Check(const BodyMotion& edge);
  // The same for the edge from a row to the next, of the rows of UseSpheresOf if they have them.
  MotionResult Check(const Waypoints& waypoints, std::size_t row);
  // True if the last answer is void: the call was interrupted, or an engine had no answer.
  bool ended() const { return search_.ended() || (with_unseen_ && with_unseen_->ended()); }
  // The best accuracy that the body allows: no answer is labelled better.
  Accuracy best_accuracy() const { return body_.best_accuracy; }
  // True if the call must end. To be called before each motion.
  bool MustEnd() { return search_.MustEnd(); }
  // The status of the whole call: OK if the motions so far are the answer.
  absl::Status Finish() const;

 private:
  const QueryBody& body_;
  BodySearch search_;
  // For UnseenSpace::kReport: `search_` ignores unseen space, this search includes it.
  std::optional<BodySearch> with_unseen_;
  MotionResult ResultOf(const EdgeResult& result);
  std::optional<EdgeResult> NameContact(const SphereMotionAnswer& known);

  std::optional<SphereMotion> spheres_;
  std::vector<Pose> X_WL_;  // of the robot's links
  ObjectRanks ranks_;
};

// Checks edges with the exact kernels or AUTO; Unimplemented if the options name another engine.
// Margins are as in CheckCollisions. Joint limits are not checked: if both ends are within them, so
// is every state between. Cancelled if `stop` is.
absl::StatusOr<MotionColumns> CheckMotions(const WorldSnapshot& world, const QueryBody& body,
                                           std::span<const std::unique_ptr<BodyMotion>> edges,
                                           const QueryOptions& options, std::stop_token stop = {});

}  // namespace cwm::collision
