#include "collision/query/body_search.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/strings/str_cat.h"
#include "collision/geometry/quick_bounds.h"

namespace cwm::collision {
namespace {}  // namespace

const Engine* ChosenEngine(EngineChoice choice, ShapeKind a, ShapeKind b, QueryKind query) {
  const auto if_supported = [&](EngineKind kind) {
    const Engine& engine = GetEngine(kind);
    return engine.Supports(a, b, query) ? &engine : nullptr;
  };
  switch (choice) {
    case EngineChoice::kExact:
      return if_supported(EngineKind::kExact);
    case EngineChoice::kFcl:
      return if_supported(EngineKind::kFcl);
    case EngineChoice::kBullet:
      return if_supported(EngineKind::kBullet);
    case EngineChoice::kAuto:
      break;
  }
  return BestEngine(a, b, query);
}

constexpr int kExactSlot = static_cast<int>(EngineKind::kExact);

std::string_view NameOf(PartSource source) {
  switch (source) {
    case PartSource::kSurface:
      return "surfaces";
    case PartSource::kHandle:
      return "handles";
    case PartSource::kShape:
      break;
  }
  return "shapes";
}

CapError BodySearch::Pair::CapErrorWithin(double reach_m) const {
  if (!has_caps()) return {};
  return CapErrorOf({body.kind, *exact_body, body.X_WS}, {object.kind, *exact_object, object.X_WS},
                    reach_m, work);
}

std::string_view NameOf(EngineChoice choice) {
  switch (choice) {
    case EngineChoice::kExact:
      return collision::NameOf(EngineKind::kExact);
    case EngineChoice::kFcl:
      return collision::NameOf(EngineKind::kFcl);
    case EngineChoice::kBullet:
      return collision::NameOf(EngineKind::kBullet);
    case EngineChoice::kAuto:
      break;
  }
  return "AUTO";
}

bool IsOpenMesh(const Shape& shape) {
  const auto* mesh = std::get_if<Mesh>(&shape);
  return mesh != nullptr && !mesh->watertight;
}

int WeightOf(const Shape& shape) {
  // A search for the minimum translation takes some hundred support points of a hull, and a support
  // point takes a nanosecond for two or three corners.
  constexpr std::size_t kCornersOfUnit = 32;
  const auto of_corners = [](std::size_t corners) {
    return static_cast<int>(corners / kCornersOfUnit);
  };
  // The exact kernels count their work on triangles themselves; FCL and Bullet take up to tens of
  // microseconds.
  constexpr int kOfMesh = 64;
  if (std::holds_alternative<Mesh>(shape)) return kOfMesh;
  if (const auto* convex = std::get_if<Convex>(&shape)) {
    return of_corners(convex->hull->vertices.size());
  }
  const auto* plate = std::get_if<Plate>(&shape);
  if (plate == nullptr) return 0;
  std::size_t corners = 2 * plate->outline.size();
  for (const Polygon& hole : plate->holes) corners += 2 * hole.size();
  return of_corners(corners);
}

BodySearch::BodySearch(const WorldSnapshot& world, const QueryBody& body,
                       const QueryOptions& options, Interrupt interrupt)
    : world_(world),
      body_(body),
      filter_(world, options, body),
      rules_(world, body, options),
      margins_(body, options),
      sigmas_(options.margin_sigma),
      max_margin_m_(std::max(margins_.MaxOf(world), rules_.max_margin_m())),
      choice_(options.engine),
      frame_pairs_(FramePairsOf(body)),
      interrupt_(std::move(interrupt)) {
  for (int a = 0; a < kShapeKindCount; ++a) {
    for (int b = 0; b < kShapeKindCount; ++b) {
      const auto kind_a = static_cast<ShapeKind>(a);
      const auto kind_b = static_cast<ShapeKind>(b);
      engines_[0][a][b] = ChosenEngine(choice_, kind_a, kind_b, QueryKind::kCollides);
      engines_[1][a][b] = ChosenEngine(choice_, kind_a, kind_b, QueryKind::kDistance);
    }
  }
  parts_.reserve(body.geometry->parts.size());
  for (const PreparedPart& part : body.geometry->parts) {
    const ShapeKind kind = KindOf(part.shape);
    const int frame = body.FrameOf(static_cast<std::int32_t>(parts_.size()));
    parts_.push_back({.part = &part,
                      .kind = kind,
                      .cheap_bounds = !HasManyVertices(part.shape),
                      .open_mesh = IsOpenMesh(part.shape),
                      .has_caps = HasCaps(part.shape),
                      .at_frame = part.X_OP.matrix().isIdentity(0),
                      .skipped = filter_.SkipsPart(body, frame, part.source),
                      .self_only = !body.TestsWorld(frame) ||
                                   body.IsSelfOnly(static_cast<std::int32_t>(parts_.size())),
                      .weight = WeightOf(part.shape),
                      .frame = frame,
                      .inflation_m = sigmas_ * part.sigma_m,
                      .X_WP = Pose::Identity(),
                      .bounds_W = Aabb()});
    has_parts_ = has_parts_ || !(parts_.back().skipped || parts_.back().self_only);
  }
  if (tests_world()) hidden_ = HiddenSpacesOf(world, filter_);
  has_caps_ = body.geometry->has_caps || (tests_world() && world.has_caps());
  max_margin_m_ += sigmas_ * (body.geometry->max_sigma_m + world.objects().max_sigma_m());
  X_WF_.resize(static_cast<std::size_t>(body.TotalFrames()), Pose::Identity());
  frames_of_pair_.resize(kTags, 0);
  for (std::size_t k = 0; k < frame_pairs_.pairs.size(); ++k) {
    const LinkPair& pair = frame_pairs_.pairs[k];
    frames_of_pair_[k % kTags] |=
        std::uint64_t{1} << (pair.first % kTags) | std::uint64_t{1} << (pair.second % kTags);
  }
}

FramePairs FramePairsOf(const QueryBody& body) {
  FramePairs of_body;
  of_body.of_self_pair.reserve(body.self_pairs.size());
  absl::flat_hash_map<std::pair<int, int>, std::int32_t> known;
  std::pair<int, int> last(-1, -1);
  std::int32_t index = -1;
  for (const PartPair& pair : body.self_pairs) {
    const std::pair<int, int> frames(body.FrameOf(pair.first), body.FrameOf(pair.second));
    if (frames != last) {  // most pairs have the frames of the one before
      const auto next = static_cast<std::int32_t>(of_body.pairs.size());
      const auto [at, is_new] = known.try_emplace(frames, next);
      if (is_new) of_body.pairs.push_back({frames.first, frames.second});
      index = at->second;
      last = frames;
    }
    of_body.of_self_pair.push_back(index);
  }
  return of_body;
}

UnresolvedTags BodySearch::TagsOf(const PairId& pair) const {
  const auto frame_of = [this](std::int32_t part) {
    return parts_[static_cast<std::size_t>(part)].frame;
  };
  const int frame = frame_of(pair.body_part);
  if (!pair.IsSelfPair()) return {.worlds = std::uint64_t{1} << (frame % kTags)};
  const LinkPair frames{frame, frame_of(pair.object_part)};
  const auto at = std::ranges::find(frame_pairs_.pairs, frames) - frame_pairs_.pairs.begin();
  return {.pairs = std::uint64_t{1} << (at % kTags)};
}

void BodySearch::PlaceBody(const BodyRows& rows, std::size_t row, const UnresolvedTags& open) {
  rows.Place(row, OwnFrames());
  PlaceAttached();
  PlaceParts(X_WF_, row, open);
}

void BodySearch::PlaceBody(std::span<const Pose> X_WF, std::size_t row,
                           const UnresolvedTags& open) {
  if (body_.attached.empty()) return PlaceParts(X_WF, row, open);
  std::ranges::copy(X_WF, OwnFrames().begin());
  PlaceAttached();
  PlaceParts(X_WF_, row, open);
}

void BodySearch::PlaceAttached() {
  const std::size_t own = OwnFrames().size();
  for (std::size_t k = 0; k < body_.attached.size(); ++k) {
    const AttachedObject& attached = body_.attached[k];
    X_WF_[own + k] = X_WF_[static_cast<std::size_t>(attached.link)] * attached.X_FO;
  }
}

void BodySearch::PlaceParts(std::span<const Pose> frames, std::size_t row,
                            const UnresolvedTags& open) {
  row_ = static_cast<std::int64_t>(row);
  bounds_W_.setEmpty();
  open_ = open;
  std::uint64_t needed = open.worlds;
  for (std::uint64_t pairs = open.pairs; pairs != 0; pairs &= pairs - 1) {
    needed |= frames_of_pair_[static_cast<std::size_t>(std::countr_zero(pairs))];
  }
  for (BodyPart& mine : parts_) {
    if (mine.skipped || !IsOpen(needed, mine.frame)) continue;
    const Pose& X_WF = frames[static_cast<std::size_t>(mine.frame)];
    mine.X_WP = mine.at_frame ? X_WF : X_WF * mine.part->X_OP;
    mine.bounds_W = mine.cheap_bounds ? TightBounds(mine.part->shape, mine.X_WP)
                                      : BoundsOfBox(mine.part->bounds_O, X_WF);
    if (TestsWorld(mine)) bounds_W_.extend(mine.bounds_W);
  }
}

std::optional<BodySearch::Pair> BodySearch::PairOf(const Obstacle& object, std::size_t b,
                                                   std::size_t o, double margin_m,
                                                   QueryKind query) {
  const BodyPart& mine = parts_[b];
  const PreparedPart& theirs = object.geometry->parts[o];
  const PairId id{&object, static_cast<std::int32_t>(b), static_cast<std::int32_t>(o)};
  const ShapeKind kind = KindOf(theirs.shape);
  const QueryKind needed = margin_m == 0 ? query : QueryKind::kDistance;
  const Engine* engine = EngineFor(mine.kind, kind, needed);
  if (engine == nullptr) {
    ReportUnsupported(id, needed);
    return std::nullopt;
  }
  const int slot = static_cast<int>(engine->kind());
  Pair pair{id,
            *engine,
            {mine.kind, *mine.part->engines[slot], mine.X_WP},
            {kind, *theirs.engines[slot], object.parts_W[o].X_WP},
            mine.open_mesh || IsOpenMesh(theirs.shape),
            margin_m,
            1 + mine.weight + WeightOf(theirs.shape),
            &interrupt_};
  if (mine.has_caps || HasCaps(theirs.shape)) {
    pair.exact_body = mine.part->engines[kExactSlot];
    pair.exact_object = theirs.engines[kExactSlot];
  }
  return pair;
}

std::optional<BodySearch::Pair> BodySearch::SelfPairOf(const PartPair& parts, double margin_m,
                                                       QueryKind query) {
  const BodyPart& a = parts_[static_cast<std::size_t>(parts.first)];
  const BodyPart& b = parts_[static_cast<std::size_t>(parts.second)];
  const PairId id{nullptr, parts.first, parts.second};
  const QueryKind needed = margin_m == 0 ? query : QueryKind::kDistance;
  const Engine* engine = EngineFor(a.kind, b.kind, needed);
  if (engine == nullptr) {
    ReportUnsupported(id, needed);
    return std::nullopt;
  }
  const int slot = static_cast<int>(engine->kind());
  Pair pair{id,
            *engine,
            {a.kind, *a.part->engines[slot], a.X_WP},
            {b.kind, *b.part->engines[slot], b.X_WP},
            a.open_mesh || b.open_mesh,
            margin_m,
            1 + a.weight + b.weight,
            &interrupt_};
  if (a.has_caps || b.has_caps) {
    pair.exact_body = a.part->engines[kExactSlot];
    pair.exact_object = b.part->engines[kExactSlot];
  }
  return pair;
}

std::optional<BodySearch::Pair> BodySearch::PairOf(const PairId& id, QueryKind query) {
  if (id.IsSelfPair()) return SelfPairOf({id.body_part, id.object_part}, 0, query);
  return PairOf(*id.object, static_cast<std::size_t>(id.body_part),
                static_cast<std::size_t>(id.object_part), 0, query);
}

void BodySearch::GatherPairs(const Obstacle& object, double reach_m) {
  near_.clear();
  const ObstacleRules rules = rules_.RulesOf(object);
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    const BodyPart& mine = parts_[b];
    if (!TestsWorld(mine)) continue;
    if (CountBoxes(object)) return near_.clear();
    for (std::size_t o = 0; o < object.parts_W.size(); ++o) {
      if (!rules.empty() && rules.At(mine.frame, o).allowed) continue;
      const double squared_m2 = SquaredDistance_m2(mine.bounds_W, object.parts_W[o].bounds_W);
      if (reach_m < 0 || squared_m2 > reach_m * reach_m) continue;
      if (filter_.SkipsPart(object, o)) continue;
      near_.push_back({squared_m2, static_cast<std::int32_t>(b), static_cast<std::int32_t>(o)});
    }
  }
}

void BodySearch::GatherSelfPairs(double reach_m) {
  near_.clear();
  const std::span<const EffectiveRule> rules = rules_.SelfPairRules();
  for (std::size_t i = 0; i < body_.self_pairs.size(); ++i) {
    if (!IsOpen(open_.pairs, frame_pairs_.of_self_pair[i])) continue;
    const auto [first, second] = body_.self_pairs[i];
    const BodyPart& a = parts_[static_cast<std::size_t>(first)];
    const BodyPart& b = parts_[static_cast<std::size_t>(second)];
    if (a.skipped || b.skipped || (!rules.empty() && rules[i].allowed)) continue;
    const double squared_m2 = SquaredDistance_m2(a.bounds_W, b.bounds_W);
    if (reach_m < 0 || squared_m2 > reach_m * reach_m) continue;
    near_.push_back({squared_m2, first, second});
  }
}

bool BodySearch::MakeHeap() {
  constexpr std::size_t kHeapAtOnce = std::size_t{1} << 16;  // below a millisecond
  if (near_.size() <= kHeapAtOnce) {
    std::make_heap(near_.begin(), near_.end());
    return true;
  }
  return ForEachBlock(near_.size(), &interrupt_, [this](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      std::push_heap(near_.begin(), near_.begin() + static_cast<std::ptrdiff_t>(i) + 1);
    }
  });
}

double BodySearch::MinBoxDistance_m2(const Obstacle& object) {
  double min_m2 = std::numeric_limits<double>::infinity();
  for (const BodyPart& mine : parts_) {
    if (!TestsWorld(mine)) continue;
    if (CountBoxes(object)) return min_m2;
    for (const PlacedPart& theirs : object.parts_W) {
      min_m2 = std::min(min_m2, SquaredDistance_m2(mine.bounds_W, theirs.bounds_W));
    }
  }
  return min_m2;
}

void BodySearch::ReportUnsupported(const PairId& id, QueryKind query) {
  // absl as packaged by Debian accepts std::string, but not std::string_view.
  const auto text = [](std::string_view name) { return std::string(name); };
  const auto part_of_body = [&](std::int32_t part) {
    return absl::StrCat(text(cwm::NameOf(parts_[static_cast<std::size_t>(part)].kind)),
                        " (body part ", part, ")");
  };
  const auto part_of_object = [&] {
    const PreparedPart& part = id.object->geometry->parts[static_cast<std::size_t>(id.object_part)];
    return absl::StrCat(text(cwm::NameOf(KindOf(part.shape))), " (object '", id.object->name, "', ",
                        text(NameOf(part.source)), "[", part.index, "])");
  };
  status_ = absl::UnimplementedError(absl::StrCat(
      "row ", row_, ": engine ", text(NameOf(choice_)), " does not answer ",
      query == QueryKind::kCollides ? "collision" : "distance", " of ", part_of_body(id.body_part),
      " and ", id.IsSelfPair() ? part_of_body(id.object_part) : part_of_object()));
}

absl::Status BodySearch::Finish() const {
  if (!status_.ok()) return status_;
  if (interrupt_.reason() == Interrupt::Reason::kStopped) {
    return absl::CancelledError("the question was cancelled");
  }
  return absl::OkStatus();
}

}  // namespace cwm::collision
