#include "collision/motion/check_motions.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "collision/engines/exact_engine.h"
#include "collision/geometry/aabb.h"

namespace cwm::collision {
namespace {

// Places of one edge that one pair is measured at. A pair that stays a millimetre apart takes as many
// as its parts travel millimetres.
constexpr int kMostPlaces = 4000;
// Pairs are measured that may come as near as this: no clearance beyond it is told.
constexpr double kLookout_m = 0.02;
// Of the lesser gap at two places that is still told of what lies between them; more asks for more
// places.
constexpr double kTold = 0.25;
// Narrower intervals of an edge are not halved again: that of a kilometre's travel is as long as
// distances are right to.
constexpr double kNarrowest = 1e-10;
// A gap of this and less is not proven: what closes by a millimetre over the edge is then bracketed
// as closely as kBracket.
constexpr double kFinest_m = 5e-8;
// Of how far a pair can travel: what is nearer takes tens of places to prove by halving, more than a
// plane between the two costs.
constexpr double kPlaneWithin = 1.0 / 64;

// Of the edge: of shorter steps by hulls alone a search of the triangles takes no longer.
constexpr double kShortestStep = 1.0 / 64;
// Of work: to place a robot and ask for the distance of two hulls.
constexpr std::size_t kStepsByHulls = 2 * kStepsOfConvexPair;

// A pair that may come near on the edge. Its poses are those of the place looked at last.
struct Candidate {
  BodySearch::Pair pair;
  double travel_m = 0;  // how fast it can close, over the whole edge
  double gap_m = 0;     // at the start: distance less margin, or less where hulls tell it
};

// From one fraction of the edge to another.
struct Span {
  double from = 0, to = 1;
  double width() const { return to - from; }
};

// A pair at one fraction of the edge.
struct Place {
  double fraction = 0;
  double gap_m = 0;
  bool contact = false;
  bool certain = true;
  Trust trust = Trust::kExact;  // of what is told here: contact, no contact, or neither
  // Of a pair that nearly touches: a gap along `normal`, from the body to the object, between planes
  // that each have one of the two wholly behind them; none is known of others.
  double plane_gap_m = -std::numeric_limits<double>::infinity();
  Vector3 normal = Vector3::Zero();
};

// One row: the body at a fraction of an edge.
class EdgeRow : public BodyRows {
 public:
  EdgeRow(const BodyMotion& motion, double fraction) : motion_(motion), fraction_(fraction) {}
  std::size_t size() const override { return 1; }
  void Place(std::size_t, std::span<Pose> X_WF) const override { motion_.Place(fraction_, X_WF); }

 private:
  const BodyMotion& motion_;
  const double fraction_;
};

struct EdgeResult {
  MotionVerdict verdict = MotionVerdict::kFree;
  double lo = 0, hi = 1, clearance_m = kLookout_m;
  PairId pair = {};
  Trust trust = Trust::kExact;
};

// One pair after the other, those first that soon could meet; once one does, the others are followed
// up to there alone.
class EdgeSearch {
 public:
  EdgeSearch(BodySearch& search, const BodyMotion& motion) : search_(search), motion_(motion) {}

  EdgeResult Run() {
    Gather();
    for (std::size_t next : order_) {
      if (search_.ended()) break;
      Follow(candidates_[next]);
    }
    if (result_.verdict != MotionVerdict::kFree) result_.clearance_m = 0;
    const bool is_of_all_pairs =
        result_.verdict == MotionVerdict::kFree || result_.verdict == MotionVerdict::kGrazing;
    if (is_of_all_pairs) result_.trust = weakest_;
    return result_;
  }

 private:
  // Pairs farther apart than this at the start stay so far apart that nothing is told of them.
  static double Reach_m(double margin_m, double travel_m) {
    return std::max(0.0, margin_m) + travel_m + kLookout_m;
  }

  void Gather() {
    search_.PlaceBody(EdgeRow(motion_, 0), 0);
    double fastest_m = 0;
    for (const PartPair& pair : search_.self_pairs()) {
      fastest_m = std::max(fastest_m, motion_.RelativeTravel_m(pair));
    }
    search_.ForEachSelfPair(
        BodySearch::From::kMargin, Reach_m(0, fastest_m), Question::kDistance,
        [&](const BodySearch::Pair& pair) {
          Add(pair, motion_.RelativeTravel_m({pair.id.body_part, pair.id.object_part}));
          return Reach_m(0, fastest_m);
        });
    if (search_.asks_world()) GatherOfWorld();
    order_.resize(candidates_.size());
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::stable_sort(order_.begin(), order_.end(), [&](std::size_t i, std::size_t j) {
      const Candidate &a = candidates_[i], &b = candidates_[j];
      return a.gap_m * b.travel_m < b.gap_m * a.travel_m;
    });
  }

  void GatherOfWorld() {
    double fastest_m = 0;
    for (std::size_t k = 0; k < search_.part_count(); ++k) {
      fastest_m = std::max(fastest_m, motion_.Travel_m(static_cast<std::int32_t>(k)));
    }
    search_.world().bounds().ForEachWithin(
        search_.body_bounds_W(), Reach_m(search_.widest_margin_m(), fastest_m),
        [&](const Obstacle& object) {
          if (search_.Skips(object)) return true;
          search_.ForEachPair(object, BodySearch::From::kMargin, Reach_m(0, fastest_m),
                              Question::kDistance, [&](const BodySearch::Pair& pair) {
                                Add(pair, motion_.Travel_m(pair.id.body_part));
                                return Reach_m(0, fastest_m);
                              });
          return !search_.ended();
        });
  }

  void Add(const BodySearch::Pair& pair, double travel_m) {
    if (MayBeAsked(pair, travel_m)) weakest_ = std::max(weakest_, pair.TrustOfProof());
    const double reach_m = Reach_m(pair.margin_m, travel_m);
    if (IsSlow(pair)) {  // what is nearest by hulls comes first, before all what these do not part
      const double least_m = LowerBound_m(pair.body, pair.object).value_or(0);
      if (least_m <= reach_m) candidates_.push_back({pair, travel_m, least_m - pair.margin_m});
      return;
    }
    const PairDistance answer = pair.engine.Distance(pair.body, pair.object, reach_m, pair.work);
    if (answer.distance_m - answer.bound_m > reach_m) return;
    candidates_.push_back({pair, travel_m, answer.distance_m - pair.margin_m});
  }

  // Whether the distance takes a search of triangles.
  static bool IsSlow(const BodySearch::Pair& pair) {
    const ShapeKind body = pair.body.kind, object = pair.object.kind;
    return (body == ShapeKind::kMesh && object != ShapeKind::kHalfSpace) ||
           (object == ShapeKind::kMesh && body != ShapeKind::kHalfSpace);
  }

  // Whether the boxes of the two can meet on the way. Far from its surface an open mesh has no inside
  // either: distances do not tell.
  bool MayBeAsked(const BodySearch::Pair& pair, double travel_m) const {
    const Aabb& theirs_W =
        pair.id.IsOfItself()
            ? search_.BoundsOf_W(pair.id.object_part)
            : pair.id.object->parts_W[static_cast<std::size_t>(pair.id.object_part)].bounds_W;
    const double reach_m = std::max(0.0, pair.margin_m) + travel_m;
    return SquaredDistance_m2(search_.BoundsOf_W(pair.id.body_part), theirs_W) <= reach_m * reach_m;
  }

  void Follow(const Candidate& candidate) {
    places_ = 0;
    const double end = result_.verdict == MotionVerdict::kContact ? result_.hi : 1;
    const std::optional<Span> open = WithoutWhatHullsProve(candidate, {0, end});
    if (!open || search_.ended()) return;
    const Place start = LookAt(candidate, open->from, open->width());
    if (start.contact) {
      result_ = Contact(open->from, start, candidate.pair.id);
      return;
    }
    const double left_m = start.gap_m - candidate.travel_m * open->width();
    if (start.certain && left_m >= std::min(kTold * start.gap_m, kLookout_m)) {
      StayClear(left_m, open->from, open->to);
      return;
    }
    if (open->width() == 0) return;
    CertifyAsFarAsWorkSuffices(candidate, start, LookAt(candidate, open->to, open->width()));
  }

  // Steps from either end as far as hulls show the pair to stay too far apart for anything to be told of
  // it. Nothing where that is everywhere.
  std::optional<Span> WithoutWhatHullsProve(const Candidate& candidate, Span open) {
    while (true) {
      const double step = StepByHulls(candidate, open.from);
      if (step >= open.width()) return std::nullopt;
      open.from += step;
      if (step < kShortestStep) break;
    }
    while (true) {
      const double step = StepByHulls(candidate, open.to);
      if (step >= open.width()) return std::nullopt;
      open.to -= step;
      if (step < kShortestStep) break;
    }
    return open;
  }

  // How far from the fraction, either way, the pair stays farther apart than is told.
  double StepByHulls(const Candidate& candidate, double fraction) {
    const BodySearch::Pair& pair = candidate.pair;
    if (MustEnd(pair.work, kStepsByHulls)) return 0;
    search_.PlaceBody(EdgeRow(motion_, fraction), 0);
    const std::optional<double> least_m = LowerBound_m(pair.body, pair.object);
    if (!least_m) return 0;
    const double room_m = *least_m - std::max(0.0, pair.margin_m) - kLookout_m;
    return room_m <= 0 ? 0 : room_m / candidate.travel_m;
  }

  // What slides along nearly at no gap is proven to half a kGrazing_m where it cannot be more finely.
  void CertifyAsFarAsWorkSuffices(const Candidate& candidate, const Place& a, const Place& b) {
    const EdgeResult before = result_;
    const double open_before = open_from_;
    finest_m_ = kFinest_m;
    Certify(candidate, a, b);
    if (places_ < kMostPlaces || search_.ended()) return;
    result_ = before;
    open_from_ = open_before;
    places_ = 0;
    finest_m_ = kGrazing_m;
    Certify(candidate, a, b);
  }

  // The pair is free up to `from` and in contact at `to`, and so are all others up to where they are
  // proven: a contact that is known already is no earlier than `to`, but free up to its `lo` alone.
  void Meet(const Candidate& candidate, double from, const Place& to) {
    const double others = result_.verdict == MotionVerdict::kContact ? result_.lo : 1;
    result_ = Contact(std::min({from, others, open_from_}), to, candidate.pair.id);
  }

  static EdgeResult Contact(double lo, const Place& at, const PairId& id) {
    return {.verdict = MotionVerdict::kContact,
            .lo = lo,
            .hi = at.fraction,
            .clearance_m = 0,
            .pair = id,
            .trust = at.trust};
  }

  // From left to right; true when there is no need to look further. Once work has run out, an
  // interval is left open, as undecided, unless it ends in contact: such a one takes few places.
  bool Certify(const Candidate& candidate, const Place& a, const Place& b) {
    const double width = b.fraction - a.fraction;
    const double travel_m = candidate.travel_m * width;
    const double least_m = std::min(a.gap_m, b.gap_m);
    const double between_m = 0.5 * (a.gap_m + b.gap_m - travel_m);
    const double plane_m = GapAlongPlanes_m(candidate, a, b);
    const double proven_m = std::max(between_m, plane_m);
    const bool is_certain = !b.contact && a.certain && b.certain;
    if (is_certain && proven_m >= kTold * least_m) {
      StayClear(std::min(least_m, proven_m), a.fraction, b.fraction);
      return false;
    }
    if (search_.ended()) return true;
    const bool is_narrowest = width <= kNarrowest;
    if (b.contact && (width <= kBracket || is_narrowest)) {
      Meet(candidate, a.fraction, b);
      return true;
    }
    // What slides along a plane grazes as far as it stays at no gap, not where it comes near.
    const bool slides = std::max(a.gap_m, b.gap_m) <= finest_m_ && plane_m >= -0.5 * finest_m_;
    const bool is_grazing = !b.contact && least_m <= finest_m_ && (travel_m <= finest_m_ || slides);
    if (is_grazing || is_narrowest || (!b.contact && places_ >= kMostPlaces)) {
      const bool grazes = is_grazing && is_certain;
      open_from_ = std::min(open_from_, a.fraction);
      if (result_.verdict == MotionVerdict::kContact) result_.lo = std::min(result_.lo, open_from_);
      Doubt({.verdict = grazes ? MotionVerdict::kGrazing : MotionVerdict::kUndecided,
             .lo = a.fraction,
             .hi = b.fraction,
             .trust = std::max(a.trust, b.trust)});
      // Undecided it stays, but for a contact: no more work is worth it.
      if (!is_grazing) places_ = kMostPlaces;
      return false;
    }
    const Place middle = LookAt(candidate, 0.5 * (a.fraction + b.fraction), width);
    return Certify(candidate, a, middle) || (!middle.contact && Certify(candidate, middle, b));
  }

  // The least gap from one place to another by the planes of either, against which the body moves
  // no more than along their normal: what slides on a plane does not close. Of whole shapes, so
  // that it is none where one of them reaches around the other; none either of what grazes near one
  // place alone, before it is known near which.
  double GapAlongPlanes_m(const Candidate& candidate, const Place& a, const Place& b) const {
    constexpr double kNone_m = -std::numeric_limits<double>::infinity();
    const double width = b.fraction - a.fraction;
    const auto least_m = [&](const Place& place, const Vector3& toward) {
      if (place.plane_gap_m == kNone_m) return kNone_m;
      const double travel_m = motion_.TravelAlong_m(candidate.pair.id.body_part, toward);
      return place.plane_gap_m - std::max(0.0, travel_m) * width;
    };
    const double plane_m = std::max(least_m(a, a.normal), least_m(b, -b.normal));
    const bool grazes_all_along = std::max(a.gap_m, b.gap_m) <= kGrazing_m;
    return plane_m > kGrazing_m || grazes_all_along || width <= kBracket ? plane_m : kNone_m;
  }

  // Proven from one fraction to another: no contact, but maybe a graze.
  void StayClear(double clearance_m, double from, double to) {
    result_.clearance_m = std::min(result_.clearance_m, clearance_m);
    if (clearance_m <= kGrazing_m) {
      Doubt({.verdict = MotionVerdict::kGrazing, .lo = from, .hi = to});
    }
  }

  // Of several the worst stays, and of those the first found; a contact overrides them.
  void Doubt(const EdgeResult& doubt) {
    if (result_.verdict == MotionVerdict::kContact) return;
    const bool worse =
        result_.verdict == MotionVerdict::kFree ||
        (doubt.verdict == MotionVerdict::kUndecided && result_.verdict != doubt.verdict);
    if (worse) result_ = doubt;
  }

  // For what lies no farther from there than `width`: how much farther apart than that takes the pair is
  // does not matter.
  Place LookAt(const Candidate& candidate, double fraction, double width) {
    ++places_;
    search_.PlaceBody(EdgeRow(motion_, fraction), 0);
    const BodySearch::Pair& pair = candidate.pair;
    // A little farther, where a rounding decides.
    const double reach_m = Reach_m(pair.margin_m, candidate.travel_m * width) + kGrazing_m;
    Place place{.fraction = fraction};
    // How deep triangles overlap takes long to tell, and matters to no margin of none or more.
    if (pair.margin_m >= 0 && IsSlow(pair) &&
        pair.engine.Collides(pair.body, pair.object, pair.work)) {
      search_.CountPair(pair);
      place.contact = true;
      place.trust = pair.TrustOfProof();
      return place;
    }
    const PairDistance answer = pair.engine.Distance(pair.body, pair.object, reach_m, pair.work);
    search_.CountPair(pair);
    SetGap(pair, answer, reach_m, place);
    const bool is_yes_or_no = place.contact ? ProvesContact(pair, answer) : place.certain;
    place.trust = is_yes_or_no ? pair.TrustOfProof() : answer.trust;
    if (place.gap_m <= kPlaneWithin * candidate.travel_m) SetPlane(pair, answer.normal, place);
    return place;
  }

  // The kernels call an overlap what is one: of a margin of none or more it is a contact, whatever
  // the depth.
  static bool ProvesContact(const BodySearch::Pair& pair, const PairDistance& answer) {
    return answer.distance_m < 0 && pair.margin_m >= 0;
  }

  // Else what is known counts: of a depth that is let pass, and of a gap between round shapes of very
  // different sizes, that may be more than bounds.
  static void SetGap(const BodySearch::Pair& pair, const PairDistance& answer, double reach_m,
                     Place& place) {
    const bool is_known = answer.trust != Trust::kDegraded;
    const double most_m = answer.distance_m + answer.bound_m - pair.margin_m;
    place.contact = ProvesContact(pair, answer) || (is_known && most_m < 0);
    place.gap_m = place.contact
                      ? answer.distance_m - pair.margin_m
                      : std::min(answer.distance_m - answer.bound_m, reach_m) - pair.margin_m;
    place.certain = is_known && (place.contact || place.gap_m >= 0);
  }

  // Not of self pairs, of which both parts move, nor of meshes: their vertices are too many.
  void SetPlane(const BodySearch::Pair& pair, const Vector3& normal, Place& place) const {
    const bool has_mesh =
        pair.body.kind == ShapeKind::kMesh || pair.object.kind == ShapeKind::kMesh;
    if (pair.id.IsOfItself() || has_mesh) return;
    const Pose X_NW(BasisFromZ(normal).transpose());  // z is the normal
    const auto along = [&](const Shape& shape, const Pose& X_WS) {
      return TightBounds(shape, X_NW * X_WS);
    };
    const auto object_part = static_cast<std::size_t>(pair.id.object_part);
    const Shape& theirs = pair.id.object->geometry->parts[object_part].shape;
    const double body_m = along(search_.ShapeOf(pair.id.body_part), pair.body.X_WS).max().z();
    place.normal = normal;
    place.plane_gap_m = along(theirs, pair.object.X_WS).min().z() - body_m - pair.margin_m;
  }

  BodySearch& search_;
  const BodyMotion& motion_;
  std::vector<Candidate> candidates_;
  std::vector<std::size_t> order_;
  int places_ = 0;
  double finest_m_ = kFinest_m;    // a gap of this and less is not proven
  double open_from_ = 1;           // nothing is proven from here
  Trust weakest_ = Trust::kExact;  // of the pairs that can come near
  EdgeResult result_;
};

}  // namespace

void Append(MotionColumns& columns, const MotionAnswer& answer) {
  columns.verdict.push_back(answer.verdict);
  columns.segment.push_back(answer.segment);
  columns.lo.push_back(answer.lo);
  columns.hi.push_back(answer.hi);
  columns.clearance_m.push_back(answer.clearance_m);
  columns.object.push_back(answer.object);
  columns.body_part.push_back(answer.body_part);
  columns.object_part.push_back(answer.object_part);
  columns.trust.push_back(answer.trust);
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

MotionAnswer EdgeChecker::Check(const BodyMotion& edge) {
  EdgeResult result = EdgeSearch(search_, edge).Run();
  if (with_unseen_ && result.verdict != MotionVerdict::kContact && !search_.ended()) {
    result = EdgeSearch(*with_unseen_, edge).Run();
    // What it meets now is unseen space, or it would have been met before.
    if (result.verdict == MotionVerdict::kContact) result.verdict = MotionVerdict::kUndecided;
  }
  return {.verdict = result.verdict,
          .segment = result.verdict == MotionVerdict::kFree ? -1 : 0,
          .lo = result.lo,
          .hi = result.hi,
          .clearance_m = result.clearance_m,
          .object = result.pair.IsOfItself() ? kItself : ranks_.Of(result.pair.object),
          .body_part = result.pair.body_part,
          .object_part = result.pair.object_part,
          .trust = std::max(result.trust, body_.best_trust)};
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
    const MotionAnswer answer = checker.Check(*edge);
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
