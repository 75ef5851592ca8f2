#include "collision/motion/edge_search.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

#include "collision/engines/exact_engine.h"
#include "collision/geometry/aabb.h"

namespace cwm::collision {
namespace {

// chosen: the largest number of fractions of an edge at which one pair is measured. A pair that
// stays a millimetre apart needs about one per millimetre that its parts travel.
constexpr int kMaxMeasurements = 4000;
// chosen: an interval is accepted if its proven clearance is at least this share of the smaller gap
// at its ends. A larger share needs more measurements.
constexpr double kMinProvenShare = 0.25;
// derived: narrower intervals of an edge are not halved. For a kilometre of travel this is 1e-7 m,
// the accuracy of distances.
constexpr double kMinWidth = 1e-10;
// derived: a gap up to this is not proven free. A pair that closes by a millimetre over the edge is
// then still bracketed within kMaxBracketWidth.
constexpr double kMinProvenGap_m = 5e-8;
// chosen: as a share of a pair's travel. For a nearer pair halving needs tens of measurements,
// which cost more than a separating plane.
constexpr double kMaxPlaneGapShare = 1.0 / 64;

// chosen: distances of meshes are searched up to this factor, since a certificate needs a lower
// bound only. The clearance that is told may be as much lower.
constexpr double kSlack = 1.25;
// chosen: as a share of the edge. In narrower intervals, near a contact, exact distances save more
// measurements than they cost.
constexpr double kMinSlackWidth = 0.03;

// chosen: as a share of the edge. If hulls prove only shorter steps, a search of the triangles
// takes no longer.
constexpr double kMinHullStep = 1.0 / 64;
// The work of placing a robot and measuring the distance of two hulls.
constexpr std::size_t kStepsByHulls = 2 * kStepsPerConvexPair;

// A pair that may come near on the edge. Its poses are those of the fraction that was measured
// last.
struct Candidate {
  BodySearch::Pair pair;
  double travel_m = 0;  // the most that it can close over the whole edge
  double gap_m = 0;     // at the start: distance minus margin, or a lower bound by hulls
  TimeSpan open = {};   // the pair keeps clear before and after
};

// The state of a pair at one fraction of the edge.
struct PairState {
  double fraction = 0;
  double gap_m = 0;
  bool contact = false;
  bool certain = true;
  Accuracy accuracy = Accuracy::kExact;  // of the verdict here: contact, no contact, or neither
  // For a pair that nearly touches: the gap along `normal`, which points from the body to the
  // object, between two planes that each have one of the shapes wholly behind them. -infinity for
  // other pairs.
  double plane_gap_m = -std::numeric_limits<double>::infinity();
  Vector3 normal = Vector3::Zero();
  // For a sphere and a convex part: the change of the gap by fraction, and a bound on how much
  // faster it can come to change. Infinite for other pairs.
  double rate_m = 0, bend_m = std::numeric_limits<double>::infinity();
};

// Follows one pair after the other, first the pairs that could meet soonest. Once a contact is
// found, the other pairs are followed only up to it.
class EdgeSearch {
 public:
  EdgeSearch(BodySearch& search, const BodyMotion& motion, const OpenTimes& times,
             double max_clearance_m)
      : search_(search),
        motion_(motion),
        times_(times),
        whole_(times.Whole()),
        max_clearance_m_(max_clearance_m) {}

  EdgeResult Run() {
    Gather();
    if (!FindContactAtStart()) {
      for (std::size_t next : order_) {
        if (search_.ended()) break;
        Track(candidates_[next]);
      }
    }
    if (result_.verdict != MotionVerdict::kFree) result_.clearance_m = 0;
    const bool is_of_all_pairs =
        result_.verdict == MotionVerdict::kFree || result_.verdict == MotionVerdict::kGrazing;
    if (is_of_all_pairs) result_.accuracy = weakest_;
    if (search_.MeetsHidden() && result_.accuracy == Accuracy::kExact) {
      search_.PlaceBody(EdgeRow(motion_, 0), 0);
      result_.accuracy = search_.HiddenAccuracy(
          [&](std::int32_t body_part) { return motion_.Travel_m(body_part); });
    }
    return result_;
  }

 private:
  // Pairs farther apart than this stay more than max_clearance_m_ away from their margin.
  double Reach_m(double margin_m, double travel_m) const {
    return std::max(0.0, margin_m) + travel_m + max_clearance_m_;
  }

  // Collects the pairs that may come near in the open times, at their begin.
  void Gather() {
    search_.PlaceBody(EdgeRow(motion_, whole_.from), 0, times_.tags());
    const double width = whole_.width();
    double max_travel_m = 0;
    search_.ForEachOpenSelfPair([&](const PartPair& pair) {
      max_travel_m = std::max(max_travel_m, motion_.RelativeTravel_m(pair));
    });
    const double reach_m = Reach_m(0, max_travel_m * width);
    search_.ForEachSelfPair(
        BodySearch::From::kMargin, reach_m, QueryKind::kDistance,
        [&](const BodySearch::Pair& pair) {
          Add(pair, motion_.RelativeTravel_m({pair.id.body_part, pair.id.object_part}));
          return reach_m;
        });
    if (search_.tests_world() && !search_.body_bounds_W().isEmpty()) GatherOfWorld();
    order_.resize(candidates_.size());
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::stable_sort(order_.begin(), order_.end(), [&](std::size_t i, std::size_t j) {
      const Candidate &a = candidates_[i], &b = candidates_[j];
      return a.gap_m * b.travel_m < b.gap_m * a.travel_m;
    });
  }

  void GatherOfWorld() {
    double max_travel_m = 0;
    search_.ForEachOpenPart(
        [&](std::int32_t part) { max_travel_m = std::max(max_travel_m, motion_.Travel_m(part)); });
    max_travel_m *= whole_.width();
    search_.world().bounds().ForEachWithin(
        search_.body_bounds_W(), Reach_m(search_.max_margin_m(), max_travel_m),
        [&](const Obstacle& object) {
          if (search_.Skips(object)) return true;
          search_.ForEachPair(object, BodySearch::From::kMargin, Reach_m(0, max_travel_m),
                              QueryKind::kDistance, [&](const BodySearch::Pair& pair) {
                                Add(pair, motion_.Travel_m(pair.id.body_part));
                                return Reach_m(0, max_travel_m);
                              });
          return !search_.ended();
        });
  }

  void Add(const BodySearch::Pair& pair, double travel_m) {
    const std::optional<TimeSpan> open = times_.Of(search_.TagsOf(pair.id));
    if (!open) return;
    if (MayMeet(pair, travel_m)) weakest_ = std::max(weakest_, pair.ProofAccuracy(travel_m));
    const double reach_m = Reach_m(pair.margin_m, travel_m);
    if (IsSlow(pair)) {  // ordered by the hulls' distance; 0 if they overlap
      const double min_m = LowerBound_m(pair.body, pair.object).value_or(0);
      if (min_m <= reach_m) candidates_.push_back({pair, travel_m, min_m - pair.margin_m, *open});
      return;
    }
    const PairDistance answer = pair.engine.Distance(pair.body, pair.object, reach_m, pair.work);
    if (answer.distance_m - answer.bound_m > reach_m) return;
    candidates_.push_back({pair, travel_m, answer.distance_m - pair.margin_m, *open});
  }

  // True if the distance needs a search of triangles.
  static bool IsSlow(const BodySearch::Pair& pair) {
    const ShapeKind body = pair.body.kind, object = pair.object.kind;
    return (body == ShapeKind::kMesh && object != ShapeKind::kHalfSpace) ||
           (object == ShapeKind::kMesh && body != ShapeKind::kHalfSpace);
  }

  // True if the bounding boxes of the two can meet on the way. A distance would not do: an open
  // mesh has no inside even far from its surface.
  bool MayMeet(const BodySearch::Pair& pair, double travel_m) const {
    const Aabb& theirs_W =
        pair.id.IsSelfPair()
            ? search_.BoundsOf_W(pair.id.object_part)
            : pair.id.object->parts_W[static_cast<std::size_t>(pair.id.object_part)].bounds_W;
    const double reach_m = std::max(0.0, pair.margin_m) + travel_m;
    return SquaredDistance_m2(search_.BoundsOf_W(pair.id.body_part), theirs_W) <= reach_m * reach_m;
  }

  // Asks all pairs for contact at the start, which decides the edge, before any pair is certified.
  bool FindContactAtStart() {
    for (const std::size_t next : order_) {
      const Candidate& candidate = candidates_[next];
      if (search_.ended()) return false;
      if (candidate.gap_m > 0 || candidate.open.from > whole_.from) continue;
      const BodySearch::Pair& pair = candidate.pair;
      if (IsSlow(pair) && pair.margin_m == 0) {
        search_.CountPair(pair);
        if (!pair.engine.Collides(pair.body, pair.object, pair.work)) continue;
      }
      const PairState start = Measure(candidate, whole_.from, candidate.open.width());
      if (!start.contact) continue;
      result_ = Contact(whole_.from, start, pair.id);
      return true;
    }
    return false;
  }

  void Track(const Candidate& candidate) {
    measurements_ = 0;
    TimeSpan span = candidate.open;
    if (result_.verdict == MotionVerdict::kContact) span.to = std::min(span.to, result_.hi);
    if (span.to < span.from) return;
    const std::optional<TimeSpan> open = TrimByHulls(candidate, span);
    if (!open || search_.ended()) return;
    const PairState start = Measure(candidate, open->from, open->width());
    if (start.contact) {
      result_ = Contact(open->from, start, candidate.pair.id);
      return;
    }
    const double left_m = start.gap_m - candidate.travel_m * open->width();
    if (start.certain && left_m >= std::min(kMinProvenShare * start.gap_m, kMaxClearance_m)) {
      RecordClearance(left_m, open->from, open->to);
      return;
    }
    if (open->width() == 0) return;
    CertifyWithinBudget(candidate, start, Measure(candidate, open->to, open->width()));
  }

  // Shrinks the interval from both ends as far as hulls prove that the pair stays more than
  // kMaxClearance_m away from its margin. Empty if they prove it for the whole interval.
  std::optional<TimeSpan> TrimByHulls(const Candidate& candidate, TimeSpan open) {
    while (true) {
      const double step = StepByHulls(candidate, open.from);
      if (step >= open.width()) return std::nullopt;
      open.from += step;
      if (step < kMinHullStep) break;
    }
    while (true) {
      const double step = StepByHulls(candidate, open.to);
      if (step >= open.width()) return std::nullopt;
      open.to -= step;
      if (step < kMinHullStep) break;
    }
    return open;
  }

  // The share of the edge, in either direction, over which hulls prove that the pair stays more
  // than kMaxClearance_m away from its margin.
  double StepByHulls(const Candidate& candidate, double fraction) {
    const BodySearch::Pair& pair = candidate.pair;
    if (MustEnd(pair.work, kStepsByHulls)) return 0;
    search_.PlaceBody(EdgeRow(motion_, fraction), 0, search_.FramesOf(pair.id));
    const std::optional<double> min_m = LowerBound_m(pair.body, pair.object);
    if (!min_m) return 0;
    const double room_m = *min_m - std::max(0.0, pair.margin_m) - kMaxClearance_m;
    return room_m <= 0 ? 0 : room_m / candidate.travel_m;
  }

  // A pair that slides along with almost no gap can exhaust the work. It is then certified again
  // with the coarser resolution kGrazingTolerance_m.
  void CertifyWithinBudget(const Candidate& candidate, const PairState& a, const PairState& b) {
    const EdgeResult before = result_;
    const double open_before = open_from_;
    min_proven_gap_m_ = kMinProvenGap_m;
    Certify(candidate, a, b);
    if (measurements_ < kMaxMeasurements || search_.ended()) return;
    result_ = before;
    open_from_ = open_before;
    measurements_ = 0;
    min_proven_gap_m_ = kGrazingTolerance_m;
    Certify(candidate, a, b);
  }

  // Records a contact: the pair is free up to `from` and in contact at `to`. The other pairs are
  // proven free only up to `open_from_` and up to the `lo` of a contact that was found before.
  void RecordContact(const Candidate& candidate, double from, const PairState& to) {
    const double others = result_.verdict == MotionVerdict::kContact ? result_.lo : 1;
    result_ = Contact(std::min({from, others, open_from_}), to, candidate.pair.id);
  }

  static EdgeResult Contact(double lo, const PairState& at, const PairId& id) {
    return {.verdict = MotionVerdict::kContact,
            .lo = lo,
            .hi = at.fraction,
            .clearance_m = 0,
            .pair = id,
            .accuracy = at.accuracy};
  }

  // Certifies the interval from a to b, from left to right. True if there is no need to search
  // further. Once the work has run out, an interval is recorded as undecided, unless it ends in
  // contact, which needs few more measurements.
  bool Certify(const Candidate& candidate, const PairState& a, const PairState& b) {
    const double width = b.fraction - a.fraction;
    const double travel_m = candidate.travel_m * width;
    const double min_m = std::min(a.gap_m, b.gap_m);
    const double between_m = 0.5 * (a.gap_m + b.gap_m - travel_m);
    const double plane_m = GapAlongPlanes_m(candidate, a, b);
    const double proven_m = std::max(between_m, plane_m);
    const bool is_certain = !b.contact && a.certain && b.certain;
    if (is_certain && proven_m >= kMinProvenShare * min_m) {
      RecordClearance(std::min(min_m, proven_m), a.fraction, b.fraction);
      return false;
    }
    if (search_.ended()) return true;
    const bool is_narrow = width <= kMinWidth;
    if (b.contact && (width <= kMaxBracketWidth || is_narrow)) {
      RecordContact(candidate, a.fraction, b);
      return true;
    }
    // A pair that slides along a plane grazes only if it has no gap at either end of the interval,
    // not if it merely comes near.
    const bool slides =
        std::max(a.gap_m, b.gap_m) <= min_proven_gap_m_ && plane_m >= -0.5 * min_proven_gap_m_;
    const bool is_grazing =
        !b.contact && min_m <= min_proven_gap_m_ && (travel_m <= min_proven_gap_m_ || slides);
    if (is_grazing || is_narrow || (!b.contact && measurements_ >= kMaxMeasurements)) {
      const bool grazes = is_grazing && is_certain;
      open_from_ = std::min(open_from_, a.fraction);
      if (result_.verdict == MotionVerdict::kContact) result_.lo = std::min(result_.lo, open_from_);
      RecordUncertain({.verdict = grazes ? MotionVerdict::kGrazing : MotionVerdict::kUndecided,
                       .lo = a.fraction,
                       .hi = b.fraction,
                       .accuracy = std::max(a.accuracy, b.accuracy)});
      // The pair stays undecided unless a contact follows, so no more work is spent on it.
      if (!is_grazing) measurements_ = kMaxMeasurements;
      return false;
    }
    const PairState middle = Measure(candidate, 0.5 * (a.fraction + b.fraction), width);
    return Certify(candidate, a, middle) || (!middle.contact && Certify(candidate, middle, b));
  }

  // A lower bound on the gap between two fractions, of a sphere and a convex part: the plane
  // through the nearest point of that part, perpendicular to the way to the centre of the sphere,
  // separates the two, and the centre comes nearer to it at a known rate (spheres/motion_lanes.h).
  // Each end speaks for its half of the interval, in which the bound is least at either end of the
  // half.
  static double GapAlongCurves_m(const PairState& a, const PairState& b) {
    const double half = 0.5 * (b.fraction - a.fraction);
    const auto least_m = [half](const PairState& state, double rate_m) {
      const double away_m = state.gap_m + half * (rate_m - 0.5 * half * state.bend_m);
      return std::min(state.gap_m, away_m);
    };
    return std::min(least_m(a, a.rate_m), least_m(b, -b.rate_m));
  }

  // A lower bound on the gap between two fractions, from the separating planes at either of them.
  // The gap closes only by the body's travel along the normal, so a body that slides along a plane
  // does not close it. The planes separate whole shapes, so the bound is useless if one shape
  // reaches around the other. -infinity for a pair that grazes near one end only, until the
  // interval is narrow.
  double GapAlongPlanes_m(const Candidate& candidate, const PairState& a,
                          const PairState& b) const {
    constexpr double kNone_m = -std::numeric_limits<double>::infinity();
    const double width = b.fraction - a.fraction;
    const auto min_m = [&](const PairState& state, const Vector3& toward) {
      if (state.plane_gap_m == kNone_m) return kNone_m;
      const double travel_m = motion_.TravelAlong_m(candidate.pair.id.body_part, toward);
      return state.plane_gap_m - std::max(0.0, travel_m) * width;
    };
    const double plane_m =
        std::max({min_m(a, a.normal), min_m(b, -b.normal), GapAlongCurves_m(a, b)});
    const bool grazes_all_along = std::max(a.gap_m, b.gap_m) <= kGrazingTolerance_m;
    return plane_m > kGrazingTolerance_m || grazes_all_along || width <= kMaxBracketWidth ? plane_m
                                                                                          : kNone_m;
  }

  // Records that no pair is in contact from one fraction to another, though one may graze.
  void RecordClearance(double clearance_m, double from, double to) {
    result_.clearance_m = std::min(result_.clearance_m, clearance_m);
    if (clearance_m <= kGrazingTolerance_m) {
      RecordUncertain({.verdict = MotionVerdict::kGrazing, .lo = from, .hi = to});
    }
  }

  // Keeps the worst uncertain result, and the first of equal ones. A contact overrides them.
  void RecordUncertain(const EdgeResult& uncertain) {
    if (result_.verdict == MotionVerdict::kContact) return;
    const bool worse =
        result_.verdict == MotionVerdict::kFree ||
        (uncertain.verdict == MotionVerdict::kUndecided && result_.verdict != uncertain.verdict);
    if (worse) result_ = uncertain;
  }

  // Measures the pair at a fraction, for intervals up to `width` away. A distance larger than the
  // pair can close in `width` need not be exact.
  PairState Measure(const Candidate& candidate, double fraction, double width) {
    ++measurements_;
    const BodySearch::Pair& pair = candidate.pair;
    search_.PlaceBody(EdgeRow(motion_, fraction), 0, search_.FramesOf(pair.id));
    // The reach is slightly larger, so that rounding does not decide.
    const double reach_m = Reach_m(pair.margin_m, candidate.travel_m * width) + kGrazingTolerance_m;
    PairState state{.fraction = fraction};
    // The depth of overlapping triangles is slow to compute, and does not matter unless the margin
    // is negative.
    if (pair.margin_m >= 0 && IsSlow(pair) &&
        pair.engine.Collides(pair.body, pair.object, pair.work)) {
      search_.CountPair(pair);
      state.contact = true;
      state.accuracy = pair.ProofAccuracy();
      return state;
    }
    PairDistance answer;
    if (IsSlow(pair) && width >= kMinSlackWidth) {
      answer = DistanceWithin(pair.body, pair.object, reach_m, kSlack, pair.work);
      search_.CountPair(pair);
      SetGap(pair, answer, reach_m, state);
      if (state.certain && !state.contact) {
        state.accuracy = pair.ProofAccuracy();
        return state;
      }
    }
    answer = pair.engine.Distance(pair.body, pair.object, reach_m, pair.work);
    search_.CountPair(pair);
    SetGap(pair, answer, reach_m, state);
    const bool is_yes_or_no = state.contact ? ProvesContact(pair, answer) : state.certain;
    state.accuracy = is_yes_or_no ? pair.ProofAccuracy() : answer.accuracy;
    if (state.gap_m <= kMaxPlaneGapShare * candidate.travel_m) SetPlane(pair, answer.normal, state);
    SetRate(pair, answer, state);
    return state;
  }

  // True if the pair overlaps and its margin is not negative. The kernels detect an overlap
  // reliably, even if its depth is only bounded.
  static bool ProvesContact(const BodySearch::Pair& pair, const PairDistance& answer) {
    return answer.distance_m < 0 && pair.margin_m >= 0;
  }

  // Sets the gap of a pair. Without a proven contact the bounds of the answer decide, which
  // matters for allowed depths and for gaps between round shapes of very different sizes.
  static void SetGap(const BodySearch::Pair& pair, const PairDistance& answer, double reach_m,
                     PairState& state) {
    const bool is_known = answer.accuracy != Accuracy::kDegraded;
    const double max_m = answer.distance_m + answer.bound_m - pair.margin_m;
    state.contact = ProvesContact(pair, answer) || (is_known && max_m < 0);
    state.gap_m = state.contact
                      ? answer.distance_m - pair.margin_m
                      : std::min(answer.distance_m - answer.bound_m, reach_m) - pair.margin_m;
    state.certain = is_known && (state.contact || state.gap_m >= 0);
  }

  void SetRate(const BodySearch::Pair& pair, const PairDistance& answer, PairState& state) const {
    const auto is_convex = [](ShapeKind kind) {
      return kind != ShapeKind::kMesh && kind != ShapeKind::kPlate;
    };
    // Only the distance itself has this rate, not one that the reach cut off.
    const bool is_apart = answer.distance_m > 0 && answer.bound_m == 0 && !state.contact &&
                          state.gap_m == answer.distance_m - pair.margin_m;
    if (!is_apart || pair.body.kind != ShapeKind::kSphere || !is_convex(pair.object.kind)) return;
    const auto along_m = [&](std::int32_t part, const Vector3& p_W) {
      return answer.normal.dot(motion_.Velocity_m(search_.frames(), part, p_W));
    };
    state.rate_m = -along_m(pair.id.body_part, pair.body.X_WS.translation());
    if (!pair.id.IsSelfPair()) {
      state.bend_m = motion_.Bend_m(pair.id.body_part);
    } else if (pair.object.kind == ShapeKind::kSphere) {
      state.rate_m += along_m(pair.id.object_part, pair.object.X_WS.translation());
      state.bend_m = motion_.RelativeBend_m({pair.id.body_part, pair.id.object_part});
    }
  }

  // Sets the separating plane of a pair. Not for self pairs, both parts of which move, nor for
  // meshes, which have too many vertices.
  void SetPlane(const BodySearch::Pair& pair, const Vector3& normal, PairState& state) const {
    const bool has_mesh =
        pair.body.kind == ShapeKind::kMesh || pair.object.kind == ShapeKind::kMesh;
    if (pair.id.IsSelfPair() || has_mesh) return;
    const Pose X_NW(BasisFromZ(normal).transpose());  // its z axis is the normal
    const auto along = [&](const Shape& shape, const Pose& X_WS) {
      return TightBounds(shape, X_NW * X_WS);
    };
    const auto object_part = static_cast<std::size_t>(pair.id.object_part);
    const Shape& theirs = pair.id.object->geometry->parts[object_part].shape;
    const double body_m = along(search_.ShapeOf(pair.id.body_part), pair.body.X_WS).max().z();
    state.normal = normal;
    state.plane_gap_m = along(theirs, pair.object.X_WS).min().z() - body_m - pair.margin_m;
  }

  BodySearch& search_;
  const BodyMotion& motion_;
  const OpenTimes& times_;
  const TimeSpan whole_;
  const double max_clearance_m_;
  std::vector<Candidate> candidates_;
  std::vector<std::size_t> order_;
  int measurements_ = 0;
  double min_proven_gap_m_ = kMinProvenGap_m;  // gaps up to this are not proven free
  double open_from_ = 1;                       // from here on nothing is proven
  Accuracy weakest_ = Accuracy::kExact;        // of the pairs that can come near
  EdgeResult result_;
};

}  // namespace

EdgeResult SearchEdge(BodySearch& search, const BodyMotion& motion, const OpenTimes& open,
                      double max_clearance_m) {
  return EdgeSearch(search, motion, open, max_clearance_m).Run();
}

}  // namespace cwm::collision
