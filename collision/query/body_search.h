// The walk that collisions, distances and contacts share: one row's body against the parts of one
// object, through broadphase bounds, filter, rules of pairs and the table of trust. What margin a
// pair has is decided here; engines see placed geometries and distances only.
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <limits>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "collision/query/interrupt.h"
#include "collision/query/pair_rule_lookup.h"
#include "collision/query/query.h"
#include "collision/query/world_filter.h"
#include "collision/spheres/sphere_lanes.h"
#include "collision/spheres/sphere_program.h"

namespace cwm::collision {

// Where an answer comes from. Ordered as ties break: the body itself, then object name, then body
// part, then object part.
struct PairId {
  const Obstacle* object = nullptr;  // of the snapshot that is asked; null: the body itself
  std::int32_t body_part = -1;
  std::int32_t object_part = -1;
  bool IsOfItself() const { return object == nullptr && object_part >= 0; }
  friend std::strong_ordering operator<=>(const PairId& a, const PairId& b) {
    if (a.object == nullptr || b.object == nullptr) {
      if (a.object != b.object) return (b.object == nullptr) <=> (a.object == nullptr);
    } else if (a.object != b.object) {
      return a.object->name <=> b.object->name;
    }
    if (a.body_part != b.body_part) return a.body_part <=> b.body_part;
    return a.object_part <=> b.object_part;
  }
};

// The pairs of frames of which a body's self pairs are, in the order in which they come up.
struct FramePairs {
  std::vector<LinkPair> pairs;
  std::vector<std::int32_t> of_self_pair;  // into `pairs`
};
FramePairs FramePairsOf(const QueryBody& body);

// Used by one thread; allocates at construction, and in a world with rules of pairs
// when it first meets an object.
class BodySearch {
 public:
  // A pair that is about to be asked.
  struct Pair {
    PairId id;
    const Engine& engine;
    PlacedGeometry body;
    PlacedGeometry object;
    bool has_open_mesh;
    double margin_m;
    int weight;         // of asking, in units of Interrupt, besides what is counted within
    WorkCounter* work;  // the search's: what is asked of the engine is void once it has ended

    // What is proven needs no label of its own but where a surface has no inside.
    Trust TrustOfProof() const { return has_open_mesh ? Trust::kSurfaceOnly : Trust::kExact; }
    // Of what the engine says without a distance.
    Trust TrustOfYesNo() const {
      return std::max(TrustOfProof(), engine.TrustOfCollides(body.kind, object.kind));
    }
  };

  // Where the reach of a walk begins: at the surfaces, or at the margin of each pair.
  enum class From { kSurface, kMargin };

  BodySearch(const WorldSnapshot& world, const QueryBody& body, const QueryOptions& options,
             Interrupt interrupt);

  // Puts the body where the row has it. What is not open is not asked about: bits of `worlds` are
  // frames, bits of `pairs` those of FramePairsOf, both modulo kTags.
  void PlaceBody(const BodyRows& rows, std::size_t row, const LaneOpen& open = kAllOpen);
  // The same where the row's frames, but for those of what it carries, are known already.
  void PlaceBody(std::span<const Pose> X_WF, std::size_t row, const LaneOpen& open);
  static constexpr LaneOpen kAllOpen{~std::uint64_t{0}, ~std::uint64_t{0}};
  const Aabb& body_bounds_W() const { return bounds_W_; }

  // Calls visit(pair) for the pairs of parts of the body and the obstacle that may not collide and
  // whose bounds are within `reach_m`; visit returns the reach that still matters, none when
  // negative. `question` is asked of pairs without a margin, the distance of the others; it is an
  // error when no engine answers it. Ends early when the batch must.
  template <class Visit>
  void ForEachPair(const Obstacle& object, From from, double reach_m, Question question,
                   Visit&& visit);
  // The same for the pairs of the body's own parts.
  template <class Visit>
  void ForEachSelfPair(From from, double reach_m, Question question, Visit&& visit);
  // Both from surfaces, without margins, asking for distances: the pair whose boxes are nearest first,
  // so that most others are farther apart than still matters, and are not asked.
  template <class Visit>
  void ForEachPairNearestFirst(const Obstacle& object, double reach_m, Visit&& visit);
  template <class Visit>
  void ForEachSelfPairNearestFirst(double reach_m, Visit&& visit);
  // Of the boxes of parts, squared; no pair of the row's body and the obstacle is nearer.
  double LeastGap_m2(const Obstacle& object);
  // No pair of the body and the world has more.
  double widest_margin_m() const { return widest_margin_m_; }
  bool asks_world() const { return body_.asks_world && has_parts_; }
  bool asks_itself() const { return !body_.self_pairs.empty(); }
  std::size_t part_count() const { return parts_.size(); }
  const Shape& ShapeOf(std::int32_t body_part) const {
    return parts_[static_cast<std::size_t>(body_part)].part->shape;
  }
  const Aabb& BoundsOf_W(std::int32_t body_part) const {
    return parts_[static_cast<std::size_t>(body_part)].bounds_W;
  }
  const std::vector<PartPair>& self_pairs() const { return body_.self_pairs; }

  bool Skips(const Obstacle& object) const { return filter_.Skips(object); }
  const WorldSnapshot& world() const { return world_; }

  // A pair that was asked once more; its geometries lie where PlaceBody has put the body since.
  void CountPair(const Pair& pair) { interrupt_.After(pair.weight); }

  // Whether the row at hand is void: interrupted, or an engine had no answer.
  bool ended() const { return !status_.ok() || interrupt_.reason() != Interrupt::Reason::kNone; }
  // To be asked before each row.
  bool MustEnd() { return !status_.ok() || interrupt_.After(1); }
  // Of the whole call: OK when the rows so far are the answer.
  absl::Status Finish() const;

 private:
  struct BodyPart {
    const PreparedPart* part;
    ShapeKind kind;
    bool cheap_bounds;  // tight bounds take a handful of operations
    bool open_mesh;
    bool at_frame;  // not moved from where the frame is
    bool skipped;   // by the representation
    int weight;     // see WeightOf
    int frame;
    double margin_m;                  // of the object that it is a part of
    const std::string* supported_by;  // of that object; nullptr: by nothing
    double inflation_m;
    Pose X_WP;
    Aabb bounds_W;
  };
  // A pair to be asked: parts of the body and of the object, or two of the body by their self pair.
  struct NearPair {
    double squared_m2;
    std::int32_t first, second;
    // Of a heap: the nearest is its first, of equally near ones that of the lowest parts.
    friend bool operator<(const NearPair& a, const NearPair& b) {
      if (a.squared_m2 != b.squared_m2) return a.squared_m2 > b.squared_m2;
      return a.first != b.first ? a.first > b.first : a.second > b.second;
    }
  };
  using EngineTable = std::array<std::array<const Engine*, kShapeKindCount>, kShapeKindCount>;

  // Those of X_WF_ that are not of what the body carries.
  std::span<Pose> OwnFrames() {
    return std::span(X_WF_).first(static_cast<std::size_t>(body_.frame_count));
  }
  void PlaceCarried();
  void PlaceParts(std::span<const Pose> frames, std::size_t row, const LaneOpen& open);
  // Where no rule sets another.
  double UsualMargin_m(const BodyPart& mine, const std::string& theirs,
                       double their_margin_m) const {
    if (mine.supported_by != nullptr && *mine.supported_by == theirs) return -support_tolerance_m_;
    return their_margin_m + mine.margin_m + request_margin_m_;
  }
  double UsualSelfMargin_m(const BodyPart& a, const BodyPart& b) const;
  void RefusePair(const PairId& id, Question question);
  // The pair as it is asked; nothing where no engine answers it, which is an error.
  std::optional<Pair> PairOf(const Obstacle& object, std::size_t b, std::size_t o, double margin_m,
                             Question question);
  std::optional<Pair> SelfPairOf(const PartPair& parts, double margin_m, Question question);
  // Fill `near_`.
  void GatherPairs(const Obstacle& object, double reach_m);
  void GatherSelfPairs(double reach_m);
  // Of `near_`; false when the batch must end.
  bool MakeHeap();
  // That the boxes of all parts are looked at; true when the batch must end.
  bool CountBoxes(const Obstacle& object) {
    constexpr std::size_t kBoxesOfStep = 8;
    return interrupt_.MustEndAfter(object.parts_W.size() / kBoxesOfStep);
  }
  template <class PairOfNear, class Visit>
  void AskNearestFirst(double reach_m, PairOfNear&& pair_of, Visit&& visit);
  static bool IsOpen(std::uint64_t tags, std::int32_t tag) {
    return (tags >> (tag % kTags) & 1) != 0;
  }
  const Engine* EngineFor(ShapeKind a, ShapeKind b, Question question) const {
    return engines_[question == Question::kCollides ? 0 : 1][static_cast<int>(a)]
                   [static_cast<int>(b)];
  }
  // What counts as near: `more_m` is what the parts' deviations can add to the margin.
  static double Start_m(From from, double margin_m, double more_m) {
    return from == From::kMargin ? std::max(0.0, margin_m + more_m) : 0;
  }

  const WorldSnapshot& world_;
  const QueryBody& body_;
  WorldFilter filter_;
  PairRuleLookup rules_;
  double request_margin_m_;
  double support_tolerance_m_;
  double sigmas_;  // of QueryOptions::margin_sigma
  double widest_margin_m_;
  EngineChoice choice_;
  std::array<EngineTable, 2> engines_;  // by Question: kCollides, kDistance
  std::vector<BodyPart> parts_;
  bool has_parts_ = false;  // that are not skipped
  std::vector<Pose> X_WF_;
  Aabb bounds_W_;
  LaneOpen open_ = kAllOpen;
  std::vector<NearPair> near_;  // memory of NearestFirst
  FramePairs frame_pairs_;
  std::vector<std::uint64_t> frames_of_pair_;  // by bit of LaneOpen::pairs, as bits of `worlds`
  std::int64_t row_ = -1;                      // of PlaceBody
  Interrupt interrupt_;
  absl::Status status_;
};

bool IsOpenMesh(const Shape& shape);

// What the shape adds to the work of a pair, in units of Interrupt: microseconds, by number of corners.
int WeightOf(const Shape& shape);

template <class Visit>
void BodySearch::ForEachPair(const Obstacle& object, From from, double reach_m, Question question,
                             Visit&& visit) {
  const ObstacleTerms rules = rules_.Of(object);
  const double more_m = sigmas_ * object.geometry->widest_sigma_m;
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    const BodyPart& mine = parts_[b];
    if (mine.skipped || !IsOpen(open_.worlds, mine.frame)) continue;
    if (CountBoxes(object)) return;
    const double usual_m = UsualMargin_m(mine, object.name, object.margin_m);
    double margin_m = usual_m + mine.inflation_m;
    double start_m = Start_m(from, margin_m, more_m);
    for (std::size_t o = 0; o < object.parts_W.size(); ++o) {
      const PlacedPart& placed = object.parts_W[o];
      if (!rules.empty() && (o == 0 || rules.by_part())) {
        const PairTerms& terms = rules.Of(mine.frame, o);
        if (terms.allowed && !rules.by_part()) break;
        if (terms.allowed) continue;
        margin_m = terms.Margin_m(usual_m) + mine.inflation_m;
        start_m = Start_m(from, margin_m, more_m);
      }
      const double squared_m2 = SquaredDistance_m2(mine.bounds_W, placed.bounds_W);
      const double near_m = start_m + reach_m;
      if (reach_m < 0 || squared_m2 > near_m * near_m) continue;
      const PreparedPart& theirs = object.geometry->parts[o];
      if (filter_.SkipsPart(object, theirs.source)) continue;
      const double pair_margin_m = margin_m + sigmas_ * theirs.sigma_m;
      const std::optional<Pair> pair = PairOf(object, b, o, pair_margin_m, question);
      if (!pair) return;
      reach_m = visit(*pair);
      if (interrupt_.After(pair->weight)) return;
    }
  }
}

template <class Visit>
void BodySearch::ForEachSelfPair(From from, double reach_m, Question question, Visit&& visit) {
  const std::span<const PairTerms> rules = rules_.OfSelfPairs();
  for (std::size_t i = 0; i < body_.self_pairs.size(); ++i) {
    if (!IsOpen(open_.pairs, frame_pairs_.of_self_pair[i])) continue;
    const auto [first, second] = body_.self_pairs[i];
    const BodyPart& a = parts_[static_cast<std::size_t>(first)];
    const BodyPart& b = parts_[static_cast<std::size_t>(second)];
    if (a.skipped || b.skipped) continue;
    double margin_m = UsualSelfMargin_m(a, b);
    if (!rules.empty()) {
      if (rules[i].allowed) continue;
      margin_m = rules[i].Margin_m(margin_m);
    }
    margin_m += a.inflation_m + b.inflation_m;
    const double near_m = Start_m(from, margin_m, 0) + reach_m;
    const double squared_m2 = SquaredDistance_m2(a.bounds_W, b.bounds_W);
    if (reach_m < 0 || squared_m2 > near_m * near_m) continue;
    const std::optional<Pair> pair = SelfPairOf({first, second}, margin_m, question);
    if (!pair) return;
    reach_m = visit(*pair);
    if (interrupt_.After(pair->weight)) return;
  }
}

template <class PairOfNear, class Visit>
void BodySearch::AskNearestFirst(double reach_m, PairOfNear&& pair_of, Visit&& visit) {
  if (!MakeHeap()) return;
  while (!near_.empty() && reach_m >= 0 && near_.front().squared_m2 <= reach_m * reach_m) {
    const NearPair next = near_.front();
    std::pop_heap(near_.begin(), near_.end());
    near_.pop_back();
    const std::optional<Pair> pair = pair_of(next);
    if (!pair) return;
    reach_m = visit(*pair);
    if (interrupt_.After(pair->weight)) return;
  }
}

template <class Visit>
void BodySearch::ForEachPairNearestFirst(const Obstacle& object, double reach_m, Visit&& visit) {
  GatherPairs(object, reach_m);
  AskNearestFirst(
      reach_m,
      [&](const NearPair& near) {
        return PairOf(object, static_cast<std::size_t>(near.first),
                      static_cast<std::size_t>(near.second), 0, Question::kDistance);
      },
      visit);
}

template <class Visit>
void BodySearch::ForEachSelfPairNearestFirst(double reach_m, Visit&& visit) {
  GatherSelfPairs(reach_m);
  AskNearestFirst(
      reach_m,
      [&](const NearPair& near) {
        return SelfPairOf({near.first, near.second}, 0, Question::kDistance);
      },
      visit);
}

}  // namespace cwm::collision
