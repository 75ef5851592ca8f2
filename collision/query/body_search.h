// The search that collisions, distances and contacts share: the body of one row against the parts
// of one object, through bounds, filter, pair rules and the table of supported pairs. The margin of
// a pair is determined here; engines only get placed geometries and distances.
//
// This file is longer than 500 lines, because the searches are templates.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "collision/engines/exact_engine.h"
#include "collision/geometry/interruptible_sort.h"
#include "collision/query/hidden_spaces.h"
#include "collision/query/interrupt.h"
#include "collision/query/pair_margins.h"
#include "collision/query/pair_rule_lookup.h"
#include "collision/query/query.h"
#include "collision/query/world_filter.h"
#include "collision/spheres/sphere_lanes.h"
#include "collision/spheres/sphere_program.h"

namespace cwm::collision {

// Identifies the pair of an answer. Ordered as ties are broken: the body itself first, then by
// object name, body part and object part.
struct PairId {
  const Obstacle* object = nullptr;  // of the queried snapshot; nullptr: the body itself
  std::int32_t body_part = -1;
  std::int32_t object_part = -1;
  bool IsSelfPair() const { return object == nullptr && object_part >= 0; }
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

// The pairs of frames that occur in a body's self pairs, in the order of their first occurrence.
struct FramePairs {
  std::vector<LinkPair> pairs;
  std::vector<std::int32_t> of_self_pair;  // into `pairs`
};
FramePairs FramePairsOf(const QueryBody& body);

// Used by one thread. Allocates at construction, and in a world with pair rules when it first meets
// an object.
class BodySearch {
 public:
  // A pair to be tested.
  struct Pair {
    PairId id;
    const Engine& engine;
    PlacedGeometry body;
    PlacedGeometry object;
    bool has_open_mesh;
    double margin_m;
    int weight;         // cost in units of Interrupt, besides the work that the kernels count
    WorkCounter* work;  // the search's counter; the engine's answer is void once it has ended
    // As ExactEngine prepared them, if a mesh has closed holes; else nullptr.
    const EngineGeometry* exact_body = nullptr;
    const EngineGeometry* exact_object = nullptr;

    bool has_caps() const { return exact_body != nullptr; }
    // The error of an answer that depends on closed holes within `reach_m` of the other part.
    CapError CapErrorWithin(double reach_m) const;
    // The accuracy of a proven verdict: exact unless a surface without an inside is involved, or a
    // closed hole is nearer than the margin and `reach_m`.
    Accuracy ProofAccuracy(double reach_m = 0) const {
      if (has_open_mesh) return Accuracy::kSurfaceOnly;
      const bool is_near = has_caps() && CapErrorWithin(std::abs(margin_m) + reach_m).any();
      return is_near ? Accuracy::kBounded : Accuracy::kExact;
    }
    // The accuracy of the engine's yes or no without a distance.
    Accuracy YesNoAccuracy() const {
      return std::max(ProofAccuracy(), engine.CollisionAccuracy(body.kind, object.kind));
    }
  };

  // The origin of a search's reach: the surfaces, or the margin of each pair.
  enum class From { kSurface, kMargin };

  BodySearch(const WorldSnapshot& world, const QueryBody& body, const QueryOptions& options,
             Interrupt interrupt);

  // Places the body at the row. Only frames and pairs that are open are tested: bits of
  // `open.worlds` are frames, bits of `open.pairs` are indices of FramePairsOf, both modulo kTags.
  void PlaceBody(const BodyRows& rows, std::size_t row,
                 const UnresolvedTags& open = kAllUnresolved);
  // The same if the row's frames, except those of attached objects, are already known.
  void PlaceBody(std::span<const Pose> X_WF, std::size_t row, const UnresolvedTags& open);
  static constexpr UnresolvedTags kAllUnresolved{~std::uint64_t{0}, ~std::uint64_t{0}};
  // Opens only the frames of the pair's parts of the body, to place no others.
  UnresolvedTags FramesOf(const PairId& pair) const {
    const auto bit = [this](std::int32_t part) {
      return std::uint64_t{1} << (parts_[static_cast<std::size_t>(part)].frame % kTags);
    };
    UnresolvedTags open;
    open.worlds = bit(pair.body_part);
    if (pair.IsSelfPair()) open.worlds |= bit(pair.object_part);
    return open;
  }
  // The tags of the pair itself: of its frame, or of its pair of frames.
  UnresolvedTags TagsOf(const PairId& pair) const;
  const Aabb& body_bounds_W() const { return bounds_W_; }

  // Calls visit(pair) for the pairs of parts of the body and the obstacle that no rule allows to
  // collide and whose bounds are within `reach_m`. visit returns the reach for the rest of the
  // search; a negative one ends it. The engine must support `query` for pairs without a margin,
  // distances for the others; otherwise the search ends with an error. Ends early if the batch must
  // end.
  template <class Visit>
  void ForEachPair(const Obstacle& object, From from, double reach_m, QueryKind query,
                   Visit&& visit);
  // The same for the body's self pairs.
  template <class Visit>
  void ForEachSelfPair(From from, double reach_m, QueryKind query, Visit&& visit);
  // Calls visit(parts) for the self pairs, and visit(part) for the parts against the world, that
  // are open in the current row.
  template <class Visit>
  void ForEachOpenSelfPair(Visit&& visit) const {
    for (std::size_t i = 0; i < body_.self_pairs.size(); ++i) {
      if (IsOpen(open_.pairs, frame_pairs_.of_self_pair[i])) visit(body_.self_pairs[i]);
    }
  }
  template <class Visit>
  void ForEachOpenPart(Visit&& visit) const {
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      if (TestsWorld(parts_[k])) visit(static_cast<std::int32_t>(k));
    }
  }
  // The frames of the body as they were placed last.
  std::span<const Pose> frames() const { return X_WF_; }
  // The same two searches for distances, from the surfaces and without margins. The pair with the
  // nearest boxes comes first, so that most other pairs are out of reach and are not tested.
  template <class Visit>
  void ForEachPairNearestFirst(const Obstacle& object, double reach_m, Visit&& visit);
  template <class Visit>
  void ForEachSelfPairNearestFirst(double reach_m, Visit&& visit);
  // Pairs that are asked for together: the parts in a frame of the body with those of an object, or
  // in a link of a robot (`other`); or the self pairs of two frames, first that of the lower part.
  struct Group {
    int frame = 0;
    int other = 0;  // 0 for an object
    friend auto operator<=>(const Group&, const Group&) = default;
  };
  // The same two searches, group by group in the order of their frames. begin(group) returns the
  // reach at which its search begins, at most `reach_m`, and visit that for the rest of the group.
  // The first part of a self pair is the lower one.
  template <class Begin, class Visit>
  void ForEachGroupNearestFirst(const Obstacle& object, double reach_m, Begin&& begin,
                                Visit&& visit);
  template <class Begin, class Visit>
  void ForEachSelfGroupNearestFirst(double reach_m, Begin&& begin, Visit&& visit);
  // The least squared distance between boxes of parts, a lower bound for the row's body and the
  // obstacle.
  double MinBoxDistance_m2(const Obstacle& object);
  // Calls visit(space, body_part, gap_m) for each hidden space of the world and each part of the
  // body that no rule allows to collide with its object. `gap_m` is a lower bound of the distance
  // from the space, less the pair's margin if `from` is kMargin.
  template <class Visit>
  void ForEachHiddenSpace(From from, Visit&& visit);
  // True if there is something that ForEachHiddenSpace would visit, or the body itself may extend
  // into space that no sensor saw.
  bool MeetsHidden() const { return body_.hidden_m > 0 || !hidden_.empty(); }
  // The label of a proven verdict: kBounded if the body may extend unseen, or if a hidden space is
  // nearer than the margin and reach_m(body_part), the way that the part goes; else kExact.
  template <class Reach>
  Accuracy HiddenAccuracy(const Reach& reach_m);
  // True if some pair may have closed holes (Pair::has_caps).
  bool MeetsCaps() const { return has_caps_; }
  // Upper bound of the margins of all pairs of the body and the world.
  double max_margin_m() const { return max_margin_m_; }
  bool tests_world() const { return body_.tests_world && has_parts_; }
  bool tests_self() const { return !body_.self_pairs.empty(); }
  std::size_t part_count() const { return parts_.size(); }
  int FrameOf(std::int32_t body_part) const {
    return parts_[static_cast<std::size_t>(body_part)].frame;
  }
  // True if the part is tested against the world in the current row.
  bool TestsWorld(std::int32_t body_part) const {
    return TestsWorld(parts_[static_cast<std::size_t>(body_part)]);
  }
  // The poses X_WF of the body's frames, after PlaceBody with the rows.
  std::span<const Pose> frames_W() const { return X_WF_; }
  // The pair of an answer at the last placement of PlaceBody; empty, with an error in Finish, if no
  // engine supports it.
  std::optional<Pair> PairOf(const PairId& id, QueryKind query);
  const Shape& ShapeOf(std::int32_t body_part) const {
    return parts_[static_cast<std::size_t>(body_part)].part->shape;
  }
  const Aabb& BoundsOf_W(std::int32_t body_part) const {
    return parts_[static_cast<std::size_t>(body_part)].bounds_W;
  }
  const std::vector<PartPair>& self_pairs() const { return body_.self_pairs; }

  bool Skips(const Obstacle& object) const { return filter_.Skips(object); }
  const WorldSnapshot& world() const { return world_; }
  const QueryBody& body() const { return body_; }

  // Counts a pair that the caller tests again by itself, at the last placement of PlaceBody.
  void CountPair(const Pair& pair) { interrupt_.CountWork(pair.weight); }

  // True if the current row is void, because the batch was interrupted or an engine lacks a pair.
  bool ended() const { return !status_.ok() || interrupt_.reason() != Interrupt::Reason::kNone; }
  // True if the batch must end. Called before each row.
  bool MustEnd() { return !status_.ok() || interrupt_.CountWork(1); }
  // The status of the whole query; OK if the rows so far are valid.
  absl::Status Finish() const;

 private:
  struct BodyPart {
    const PreparedPart* part;
    ShapeKind kind;
    bool cheap_bounds;  // tight bounds take a handful of operations
    bool open_mesh;
    bool has_caps;
    bool at_frame;   // true if its pose in the frame is the identity
    bool skipped;    // true if the representation excludes it
    bool self_only;  // true if it is only tested in self pairs
    int weight;      // see WeightOf
    int frame;
    double inflation_m;
    Pose X_WP;
    Aabb bounds_W;
  };
  // A pair to be tested: a part of the body and one of the object, or the two parts of a self pair.
  struct NearPair {
    double squared_m2;
    std::int32_t first, second;
    // Order for a heap that yields the nearest first, of equally near ones the lowest parts.
    friend bool operator<(const NearPair& a, const NearPair& b) {
      if (a.squared_m2 != b.squared_m2) return a.squared_m2 > b.squared_m2;
      return a.first != b.first ? a.first > b.first : a.second > b.second;
    }
  };
  using EngineTable = std::array<std::array<const Engine*, kShapeKindCount>, kShapeKindCount>;

  // The frames in X_WF_ of the body itself, without attached objects.
  std::span<Pose> OwnFrames() {
    return std::span(X_WF_).first(static_cast<std::size_t>(body_.frame_count));
  }
  void PlaceAttached();
  void PlaceParts(std::span<const Pose> frames, std::size_t row, const UnresolvedTags& open);
  // The paddings of the obstacle's parts; none between a robot and an object that it carries.
  std::span<const double> PaddingsOf_m(const Obstacle& object) const {
    const bool carries_body = body_.attachment != nullptr && body_.attachment->robot == object.name;
    return carries_body ? std::span<const double>() : collision::PaddingsOf_m(object);
  }
  void ReportUnsupported(const PairId& id, QueryKind query);
  // The pair to be tested; empty, with an error in status_, if no engine supports it.
  std::optional<Pair> PairOf(const Obstacle& object, std::size_t b, std::size_t o, double margin_m,
                             QueryKind query);
  std::optional<Pair> SelfPairOf(const PartPair& parts, double margin_m, QueryKind query);
  // Fill `near_` with the pairs within reach.
  void GatherPairs(const Obstacle& object, double reach_m);
  void GatherSelfPairs(double reach_m);
  // Makes `near_` a heap; false if the batch must end.
  bool MakeHeap();
  // Counts the work of comparing the boxes of all parts; true if the batch must end.
  bool CountBoxes(const Obstacle& object) {
    constexpr std::size_t kBoxesPerStep = 8;
    return interrupt_.MustEndAfter(object.parts_W.size() / kBoxesPerStep);
  }
  // The other side of a pair's group: the link of the obstacle's part, 0 for that of an object.
  static int LinkOf(const Obstacle& object, std::int32_t part) {
    return object.robot == nullptr ? 0 : object.robot->link_of_part[static_cast<std::size_t>(part)];
  }
  template <class OtherOf, class PairOfNear, class Begin, class Visit>
  void EvaluateGroups(OtherOf&& other_of, PairOfNear&& pair_of, Begin&& begin, Visit&& visit);
  template <class PairOfNear, class Visit>
  void EvaluateNearestFirst(double reach_m, PairOfNear&& pair_of, Visit&& visit);
  static bool IsOpen(std::uint64_t tags, std::int32_t tag) {
    return (tags >> (tag % kTags) & 1) != 0;
  }
  bool TestsWorld(const BodyPart& mine) const {
    return !mine.skipped && !mine.self_only && IsOpen(open_.worlds, mine.frame);
  }
  const Engine* EngineFor(ShapeKind a, ShapeKind b, QueryKind query) const {
    return engines_[query == QueryKind::kCollides ? 0 : 1][static_cast<int>(a)]
                   [static_cast<int>(b)];
  }
  // The distance at which the reach starts; `more_m` is the most that the deviations of the
  // object's parts can add to the margin.
  static double Start_m(From from, double margin_m, double more_m) {
    return from == From::kMargin ? std::max(0.0, margin_m + more_m) : 0;
  }

  const WorldSnapshot& world_;
  const QueryBody& body_;
  WorldFilter filter_;
  std::vector<HiddenSpace> hidden_;  // empty if the world is not tested
  PairRuleLookup rules_;
  PairMargins margins_;
  double sigmas_;  // QueryOptions::margin_sigma
  double max_margin_m_;
  EngineChoice choice_;
  std::array<EngineTable, 2> engines_;  // by QueryKind: kCollides, kDistance
  std::vector<BodyPart> parts_;
  bool has_caps_ = false;
  bool has_parts_ = false;  // true if some part is tested against the world
  std::vector<Pose> X_WF_;
  Aabb bounds_W_;
  UnresolvedTags open_ = kAllUnresolved;
  std::vector<NearPair> near_;  // buffer of the NearestFirst searches
  FramePairs frame_pairs_;
  std::vector<std::uint64_t>
      frames_of_pair_;     // by bit of UnresolvedTags::pairs: bits of their frames
  std::int64_t row_ = -1;  // the last row of PlaceBody
  Interrupt interrupt_;
  absl::Status status_;
};

bool IsOpenMesh(const Shape& shape);
// True if verdicts about the shape may be less than exact: an open mesh, or one with closed holes.
inline bool IsUncertain(const Shape& shape) { return IsOpenMesh(shape) || HasCaps(shape); }

// The engine that answers the pair; nullptr if the chosen one does not.
const Engine* ChosenEngine(EngineChoice choice, ShapeKind a, ShapeKind b, QueryKind query);
// "shapes", "surfaces" or "handles".
std::string_view NameOf(PartSource source);

// The cost that the shape adds to a pair, in units of Interrupt (about a microsecond), by its
// number of corners.
int WeightOf(const Shape& shape);

template <class Visit>
void BodySearch::ForEachPair(const Obstacle& object, From from, double reach_m, QueryKind query,
                             Visit&& visit) {
  const ObstacleRules rules = rules_.RulesOf(object);
  const bool has_paddings = !PaddingsOf_m(object).empty();
  const double more_m = sigmas_ * object.geometry->max_sigma_m;
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    const BodyPart& mine = parts_[b];
    if (!TestsWorld(mine)) continue;
    if (CountBoxes(object)) return;
    double margin_m = 0, start_m = 0;  // the same for all parts unless paddings or rules differ
    for (std::size_t o = 0; o < object.parts_W.size(); ++o) {
      const PlacedPart& placed = object.parts_W[o];
      if (o == 0 || rules.by_part() || has_paddings) {
        margin_m = margins_.Of(mine.frame, object, o);
        if (!rules.empty()) {
          const EffectiveRule& rule = rules.At(mine.frame, o);
          if (rule.allowed && !rules.by_part()) break;
          if (rule.allowed) continue;
          margin_m = rule.Margin_m(margin_m);
        }
        margin_m += mine.inflation_m;
        start_m = Start_m(from, margin_m, more_m);
      }
      const double squared_m2 = SquaredDistance_m2(mine.bounds_W, placed.bounds_W);
      const double near_m = start_m + reach_m;
      if (reach_m < 0 || squared_m2 > near_m * near_m) continue;
      const PreparedPart& theirs = object.geometry->parts[o];
      if (filter_.SkipsPart(object, o)) continue;
      const double pair_margin_m = margin_m + sigmas_ * theirs.sigma_m;
      const std::optional<Pair> pair = PairOf(object, b, o, pair_margin_m, query);
      if (!pair) return;
      reach_m = visit(*pair);
      if (interrupt_.CountWork(pair->weight)) return;
    }
  }
}

template <class Visit>
void BodySearch::ForEachHiddenSpace(From from, Visit&& visit) {
  for (const HiddenSpace& space : hidden_) {
    const ObstacleRules rules = rules_.RulesOf(*space.object);
    const double more_m = sigmas_ * space.object->geometry->max_sigma_m;
    for (std::size_t b = 0; b < parts_.size(); ++b) {
      const BodyPart& mine = parts_[b];
      if (!TestsWorld(mine)) continue;
      const auto part = static_cast<std::size_t>(space.part);
      double margin_m = margins_.Of(mine.frame, *space.object, part);
      if (!rules.empty()) {
        const EffectiveRule& rule = rules.At(mine.frame, part);
        if (rule.allowed) continue;
        margin_m = rule.Margin_m(margin_m);
      }
      const double start_m = Start_m(from, margin_m + mine.inflation_m, more_m);
      visit(space, static_cast<std::int32_t>(b), space.LowerBound_m(mine.bounds_W) - start_m);
    }
  }
}

template <class Reach>
Accuracy BodySearch::HiddenAccuracy(const Reach& reach_m) {
  Accuracy accuracy = body_.hidden_m > 0 ? Accuracy::kBounded : Accuracy::kExact;
  ForEachHiddenSpace(From::kMargin, [&](const HiddenSpace&, std::int32_t part, double gap_m) {
    if (gap_m <= reach_m(part)) accuracy = Accuracy::kBounded;
  });
  return accuracy;
}

template <class Visit>
void BodySearch::ForEachSelfPair(From from, double reach_m, QueryKind query, Visit&& visit) {
  const std::span<const EffectiveRule> rules = rules_.SelfPairRules();
  for (std::size_t i = 0; i < body_.self_pairs.size(); ++i) {
    if (!IsOpen(open_.pairs, frame_pairs_.of_self_pair[i])) continue;
    const auto [first, second] = body_.self_pairs[i];
    const BodyPart& a = parts_[static_cast<std::size_t>(first)];
    const BodyPart& b = parts_[static_cast<std::size_t>(second)];
    if (a.skipped || b.skipped) continue;
    double margin_m = margins_.OfSelfPair(a.frame, b.frame);
    if (!rules.empty()) {
      if (rules[i].allowed) continue;
      margin_m = rules[i].Margin_m(margin_m);
    }
    margin_m += a.inflation_m + b.inflation_m;
    const double near_m = Start_m(from, margin_m, 0) + reach_m;
    const double squared_m2 = SquaredDistance_m2(a.bounds_W, b.bounds_W);
    if (reach_m < 0 || squared_m2 > near_m * near_m) continue;
    const std::optional<Pair> pair = SelfPairOf({first, second}, margin_m, query);
    if (!pair) return;
    reach_m = visit(*pair);
    if (interrupt_.CountWork(pair->weight)) return;
  }
}

template <class PairOfNear, class Visit>
void BodySearch::EvaluateNearestFirst(double reach_m, PairOfNear&& pair_of, Visit&& visit) {
  if (!MakeHeap()) return;
  while (!near_.empty() && reach_m >= 0 && near_.front().squared_m2 <= reach_m * reach_m) {
    const NearPair next = near_.front();
    std::pop_heap(near_.begin(), near_.end());
    near_.pop_back();
    const std::optional<Pair> pair = pair_of(next);
    if (!pair) return;
    reach_m = visit(*pair);
    if (interrupt_.CountWork(pair->weight)) return;
  }
}

template <class Visit>
void BodySearch::ForEachPairNearestFirst(const Obstacle& object, double reach_m, Visit&& visit) {
  GatherPairs(object, reach_m);
  EvaluateNearestFirst(
      reach_m,
      [&](const NearPair& near) {
        return PairOf(object, static_cast<std::size_t>(near.first),
                      static_cast<std::size_t>(near.second), 0, QueryKind::kDistance);
      },
      visit);
}

template <class Visit>
void BodySearch::ForEachSelfPairNearestFirst(double reach_m, Visit&& visit) {
  GatherSelfPairs(reach_m);
  EvaluateNearestFirst(
      reach_m,
      [&](const NearPair& near) {
        return SelfPairOf({near.first, near.second}, 0, QueryKind::kDistance);
      },
      visit);
}

template <class OtherOf, class PairOfNear, class Begin, class Visit>
void BodySearch::EvaluateGroups(OtherOf&& other_of, PairOfNear&& pair_of, Begin&& begin,
                                Visit&& visit) {
  const auto group_of = [&](const NearPair& near) {
    return Group{FrameOf(near.first), other_of(near.second)};
  };
  const auto comes_first = [&](const NearPair& a, const NearPair& b) {
    const Group of_a = group_of(a), of_b = group_of(b);
    return of_a != of_b ? of_a < of_b : b < a;  // in a group, the nearest first
  };
  InterruptibleSort(near_, comes_first, &interrupt_);
  for (std::size_t i = 0; i < near_.size() && !ended();) {
    const Group group = group_of(near_[i]);
    double reach_m = begin(group);
    for (; i < near_.size() && group_of(near_[i]) == group; ++i) {
      if (reach_m < 0 || near_[i].squared_m2 > reach_m * reach_m) continue;
      const std::optional<Pair> pair = pair_of(near_[i]);
      if (!pair) return;
      reach_m = visit(*pair);
      if (interrupt_.CountWork(pair->weight)) return;
    }
  }
}

template <class Begin, class Visit>
void BodySearch::ForEachGroupNearestFirst(const Obstacle& object, double reach_m, Begin&& begin,
                                          Visit&& visit) {
  GatherPairs(object, reach_m);
  EvaluateGroups([&](std::int32_t part) { return LinkOf(object, part); },
                 [&](const NearPair& near) {
                   return PairOf({&object, near.first, near.second}, QueryKind::kDistance);
                 },
                 begin, visit);
}

template <class Begin, class Visit>
void BodySearch::ForEachSelfGroupNearestFirst(double reach_m, Begin&& begin, Visit&& visit) {
  GatherSelfPairs(reach_m);
  for (NearPair& near : near_) {
    if (near.first > near.second) std::swap(near.first, near.second);
  }
  EvaluateGroups([&](std::int32_t part) { return FrameOf(part); },
                 [&](const NearPair& near) {
                   return PairOf({nullptr, near.first, near.second}, QueryKind::kDistance);
                 },
                 begin, visit);
}

}  // namespace cwm::collision
