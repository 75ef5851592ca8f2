#include "collision/motion/check_motions.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

namespace cwm::collision {

void Append(MotionColumns& columns, const MotionResult& answer) {
  columns.verdict.push_back(answer.verdict);
  columns.segment.push_back(answer.segment);
  columns.lo.push_back(answer.lo);
  columns.hi.push_back(answer.hi);
  columns.clearance_m.push_back(answer.clearance_m);
  columns.object.push_back(answer.object);
  columns.body_part.push_back(answer.body_part);
  columns.object_part.push_back(answer.object_part);
  columns.accuracy.push_back(answer.accuracy);
}

namespace {

QueryOptions WithoutReports(QueryOptions options) {
  if (options.unseen == UnseenSpace::kReport) options.unseen = UnseenSpace::kIgnore;
  return options;
}

}  // namespace

EdgeChecker::EdgeChecker(const WorldSnapshot& world, const QueryBody& body,
                         const QueryOptions& options, const Interrupt& interrupt)
    : body_(body), search_(world, body, WithoutReports(options), interrupt), ranks_(world) {
  if (options.unseen == UnseenSpace::kReport) {
    with_unseen_.emplace(world, body, options, interrupt);
  }
}

void EdgeChecker::UseSpheresOf(const WorldSnapshot& world, const JointRows& rows,
                               const QueryOptions& options) {
  spheres_.reset();
  if (auto spheres = SphereMotion::Make(world, body_, rows, options)) {
    spheres_.emplace(*std::move(spheres));
  }
}

absl::Status EdgeChecker::Finish() const {
  if (absl::Status status = search_.Finish(); !status.ok()) return status;
  return with_unseen_ ? with_unseen_->Finish() : absl::OkStatus();
}

absl::Status EdgeChecker::CheckEngine(const QueryOptions& options) {
  if (options.engine == EngineChoice::kAuto || options.engine == EngineChoice::kExact) {
    return absl::OkStatus();
  }
  return absl::UnimplementedError(
      "motions are certified by the exact kernels alone: ask AUTO or EXACT");
}

MotionResult EdgeChecker::Check(const BodyMotion& edge) {
  EdgeResult result = SearchEdge(search_, edge);
  if (with_unseen_ && result.verdict != MotionVerdict::kContact && !search_.ended()) {
    result = SearchEdge(*with_unseen_, edge);
    // A contact that the first search did not find is a contact with unseen space.
    if (result.verdict == MotionVerdict::kContact) result.verdict = MotionVerdict::kUndecided;
  }
  return ResultOf(result);
}

MotionResult EdgeChecker::Check(const Waypoints& waypoints, std::size_t row) {
  if (!spheres_) return Check(*waypoints.MotionFrom(row));
  const SphereMotionAnswer known = spheres_->Check(row);
  if (known.open.empty() && !known.has_contact()) {
    return ResultOf({.clearance_m = known.clearance_m});
  }
  if (known.open.empty()) {
    const auto contact = NameContact(known);
    return contact ? ResultOf(*contact) : Check(*waypoints.MotionFrom(row));
  }
  const std::unique_ptr<BodyMotion> motion = waypoints.MotionFrom(row);
  EdgeResult result =
      SearchEdge(search_, *motion, known.open, known.has_contact() ? 0 : kMaxClearance_m);
  // A contact of the spheres is in one of the open times if its bracket is still too wide.
  if (known.has_contact() && result.verdict != MotionVerdict::kContact) return Check(*motion);
  result.clearance_m = std::min(result.clearance_m, known.clearance_m);
  return ResultOf(result);
}

// Finds the pair of a contact that spheres have proven. Empty if the interval between single and
// double precision contains its margin.
std::optional<EdgeResult> EdgeChecker::NameContact(const SphereMotionAnswer& known) {
  std::optional<EdgeResult> contact;
  X_WL_.resize(static_cast<std::size_t>(body_.frame_count));
  spheres_->Place(known.hi, X_WL_);
  search_.PlaceBody(X_WL_, 0, known.tags);
  const auto visit = [&](const BodySearch::Pair& pair) {
    const double reach_m = std::max(0.0, pair.margin_m);
    const PairDistance answer = pair.engine.Distance(pair.body, pair.object, reach_m, pair.work);
    if (answer.distance_m + answer.bound_m >= pair.margin_m) return 0.0;
    contact = {.verdict = MotionVerdict::kContact,
               .lo = known.lo,
               .hi = known.hi,
               .clearance_m = 0,
               .pair = pair.id,
               .accuracy = pair.ProofAccuracy()};
    return -1.0;
  };
  search_.ForEachSelfPair(BodySearch::From::kMargin, 0, QueryKind::kDistance, visit);
  if (contact || !search_.tests_world() || search_.body_bounds_W().isEmpty()) return contact;
  search_.world().bounds().ForEachWithin(
      search_.body_bounds_W(), std::max(0.0, search_.max_margin_m()), [&](const Obstacle& object) {
        if (search_.Skips(object)) return true;
        search_.ForEachPair(object, BodySearch::From::kMargin, 0, QueryKind::kDistance, visit);
        return !contact && !search_.ended();
      });
  return contact;
}

MotionResult EdgeChecker::ResultOf(const EdgeResult& result) {
  // Parts that contain the body prove it free, and nothing by their contact.
  const bool stands_for_others =
      body_.IsContaining(result.pair.body_part) ||
      (result.pair.IsSelfPair() && body_.IsContaining(result.pair.object_part));
  const bool is_open = result.verdict == MotionVerdict::kContact && stands_for_others;
  const bool is_proof = result.verdict == MotionVerdict::kFree && body_.containing_count > 0;
  return {.verdict = is_open ? MotionVerdict::kUndecided : result.verdict,
          .segment = result.verdict == MotionVerdict::kFree ? -1 : 0,
          .lo = result.lo,
          .hi = result.hi,
          .clearance_m = result.clearance_m,
          .object = result.pair.IsSelfPair() ? kSelfObject : ranks_.IndexOf(result.pair.object),
          .body_part = result.pair.body_part,
          .object_part = result.pair.object_part,
          .accuracy = is_proof ? result.accuracy : std::max(result.accuracy, body_.best_accuracy)};
}

absl::StatusOr<MotionColumns> CheckMotions(const WorldSnapshot& world, const QueryBody& body,
                                           std::span<const std::unique_ptr<BodyMotion>> edges,
                                           const QueryOptions& options, std::stop_token stop) {
  if (auto status = EdgeChecker::CheckEngine(options); !status.ok()) return status;
  TimeLimit limit(options);
  EdgeChecker checker(world, body, options, {std::move(stop), limit});
  MotionColumns columns;
  for (const std::unique_ptr<BodyMotion>& edge : edges) {
    if (checker.MustEnd()) break;
    const MotionResult answer = checker.Check(*edge);
    if (checker.ended()) break;
    Append(columns, answer);
    limit.Count(1);
    ++columns.completed;
  }
  if (absl::Status status = checker.Finish(); !status.ok()) return status;
  while (columns.verdict.size() < edges.size()) Append(columns, {});
  return columns;
}

}  // namespace cwm::collision
