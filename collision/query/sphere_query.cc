#include "collision/query/sphere_query.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include "collision/geometry/validation.h"
#include "collision/query/body_search.h"
#include "collision/query/pair_margins.h"
#include "collision/query/pair_rule_lookup.h"
#include "collision/query/sphere_scene.h"
#include "collision/query/world_filter.h"
#include "collision/spheres/program_cache.h"
#include "collision/spheres/solid_spheres.h"

namespace cwm::collision {
namespace {

// measured: compiling the spheres around the parts of an arm for its first query takes a tenth of a
// millisecond, which pays off only with at least this many rows.
constexpr std::size_t kMinRows = 256;

using Spheres = std::vector<PlacedSphere>;

constexpr LaneProof kGapOnly{.of_gap = true, .of_contact = false};
constexpr LaneProof kContactOnly{.of_gap = false, .of_contact = true};

// True if the body's own parts that are tested against the world are spheres.
bool IsMadeOfSpheres(const QueryBody& body) {
  const std::vector<PreparedPart>& parts = body.geometry->parts;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    if (body.FrameOf(static_cast<std::int32_t>(k)) >= body.frame_count) break;
    if (body.IsSelfOnly(static_cast<std::int32_t>(k))) continue;
    if (!std::holds_alternative<Sphere>(parts[k].shape)) return false;
  }
  return true;
}

bool IsSupported(const QueryBody& body, const JointRows& rows, const QueryOptions& options) {
  if (rows.model().links.size() != static_cast<std::size_t>(body.frame_count)) return false;
  const EngineChoice engine = options.engine;
  if (engine != EngineChoice::kAuto && engine != EngineChoice::kExact) return false;
  if (options.margin_sigma > 0) return false;
  // Prismatic joints beyond kMaxSlide_m make a row UNDECIDED in any case.
  return rows.range().Reach_m(kMaxSlide_m) <= kMaxCoordinate_m;
}

// Collects what CompileSpheres and CompileScene need.
class QueryCompiler {
 public:
  QueryCompiler(const WorldSnapshot& world, const QueryBody& body, const QueryOptions& options,
                bool is_made_of_spheres)
      : world_(world),
        body_(body),
        options_(options),
        is_made_of_spheres_(is_made_of_spheres),
        filter_(world, options, body),
        rules_(world, body, options),
        margins_(body, options),
        class_of_frame_(ClassesOf(body, rules_)),
        frame_pairs_(FramePairsOf(body)) {}

  std::optional<SphereQuery> Run(const JointRows& rows) {
    AddOwnSpheres();
    AddAttached();
    AddPairs();
    SphereQuery query{.program = ProgramOf(rows),
                      .scene = {},
                      .proves_contact = is_made_of_spheres_ && body_.containing_count == 0,
                      .tags_for_accuracy = {}};
    if (!query.program) return std::nullopt;
    const Pose& X_WB = rows.states().X_WB;
    query.scene = body_.tests_world ? SceneOf(*query.program, X_WB) : EmptyScene(*query.program);
    const bool is_proof = body_.containing_count > 0;  // of free states
    if (body_.best_accuracy >= Accuracy::kSurfaceOnly && !is_proof) return query;
    query.tags_for_accuracy = PairsWithOpenMesh();
    const double margin_m = MaxMargin_m();
    const bool reaches_uncertain =
        body_.tests_world && (ReachesOpenMeshes(world_, filter_, *query.program, X_WB, margin_m) ||
                              ReachesHiddenSpaces(world_, filter_, *query.program, X_WB, margin_m));
    if (body_.hidden_m > 0 || reaches_uncertain) {
      query.tags_for_accuracy.worlds = BodySearch::kAllUnresolved.worlds;
    }
    return query;
  }

 private:
  // Frames of one class have the same rules and the same margin with every obstacle. Attached
  // objects have margins of their own.
  static std::vector<int> ClassesOf(const QueryBody& body, const PairRuleLookup& rules) {
    const std::vector<int> by_rules = rules.FrameClasses();
    std::map<std::tuple<int, double, int>, int> classes;
    std::vector<int> of_frame;
    for (int frame = 0; frame < body.TotalFrames(); ++frame) {
      const int attached = body.AttachedIn(frame) == nullptr ? 0 : frame;
      const auto key =
          std::tuple(by_rules[static_cast<std::size_t>(frame)], body.PaddingOf_m(frame), attached);
      of_frame.push_back(classes.try_emplace(key, static_cast<int>(classes.size())).first->second);
    }
    return of_frame;
  }

  int ClassOf(int frame) const { return class_of_frame_[static_cast<std::size_t>(frame)]; }

  void Add(int frame, const Vector3& centre, double radius_m, LaneProof proof) {
    spheres_.push_back({.link = frame,
                        .centre_L = centre,
                        .radius_m = radius_m,
                        .proof = proof,
                        .scene_class = ClassOf(frame)});
  }

  // The spheres that the robot is made of, by part, or those around its links.
  void AddOwnSpheres() {
    if (!is_made_of_spheres_) {
      const SphereModel& around = *body_.bounding_spheres;
      for (std::size_t link = 0; link < around.links.size(); ++link) {
        for (const LinkSphere& sphere : around.links[link]) {
          Add(static_cast<int>(link), sphere.center_L, sphere.radius_m, kGapOnly);
        }
      }
      return;
    }
    const std::vector<PreparedPart>& parts = body_.geometry->parts;
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const int frame = body_.FrameOf(static_cast<std::int32_t>(k));
      if (frame >= body_.frame_count || body_.IsSelfOnly(static_cast<std::int32_t>(k))) break;
      Add(frame, parts[k].X_OP.translation(), std::get<Sphere>(parts[k].shape).radius_m,
          body_.containing_count > 0 ? kGapOnly : LaneProof{});
    }
  }

  // Spheres around the parts of attached objects, and spheres within them.
  void AddAttached() {
    for (std::size_t k = 0; k < body_.attached.size(); ++k) {
      const AttachedObject& attached = body_.attached[k];
      const int frame = body_.frame_count + static_cast<int>(k);
      for (const PreparedPart& part : attached.object->geometry->parts) {
        if (filter_.SkipsPart(body_, frame, part.source)) continue;
        const SolidSpheres of_part = SpheresOf(part.shape, part.X_OP);
        for (const Ball& ball : of_part.around) {
          Add(frame, ball.centre, ball.radius_m, of_part.is_exact ? LaneProof{} : kGapOnly);
        }
        for (const Ball& ball : of_part.within) {
          Add(frame, ball.centre, ball.radius_m, kContactOnly);
        }
      }
      fixed_frames_.push_back({.link = attached.link, .X_LF = attached.X_FO});
    }
  }

  bool IsOwnSphere(std::int32_t part) const {
    return is_made_of_spheres_ && body_.FrameOf(part) < body_.frame_count &&
           !body_.IsSelfOnly(part);
  }

  // A part pair of own spheres is a pair of spheres; of others, all spheres of their frames count.
  void AddPairs() {
    const std::span<const EffectiveRule> rules = rules_.SelfPairRules();
    std::vector<bool> is_added(frame_pairs_.pairs.size(), false);
    for (std::size_t k = 0; k < body_.self_pairs.size(); ++k) {
      const auto [first, second] = body_.self_pairs[k];
      const int a = body_.FrameOf(first), b = body_.FrameOf(second);
      double margin_m = margins_.OfSelfPair(a, b);
      if (!rules.empty()) {  // the same for all pairs of parts of two frames
        if (rules[k].allowed) continue;
        margin_m = rules[k].Margin_m(margin_m);
      }
      const std::int32_t index = frame_pairs_.of_self_pair[k], tag = index % kTags;
      if (margin_m >= 0 && IsOwnSphere(first) && IsOwnSphere(second)) {
        sphere_pairs_.push_back({first, second, tag, margin_m});
        continue;
      }
      if (is_added[static_cast<std::size_t>(index)]) continue;
      is_added[static_cast<std::size_t>(index)] = true;
      link_pairs_.push_back({.links = frame_pairs_.pairs[static_cast<std::size_t>(index)],
                             .tag = tag,
                             .proves_gap_only = margin_m < 0,
                             .margin_m = std::max(0.0, margin_m)});
    }
  }

  // nullptr if the SIMD kinematics do not support a joint.
  std::shared_ptr<const SphereProgram> ProgramOf(const JointRows& rows) const {
    const SphereSet set{.spheres = spheres_,
                        .fixed_frames = fixed_frames_,
                        .pairs = {.spheres = sphere_pairs_, .links = link_pairs_}};
    const std::vector<double>& base = rows.states().base;
    if (body_.programs && &body_.programs->model() == &rows.model()) {
      return body_.programs->Find(rows.group(), base, set);
    }
    auto program = CompileSpheres(rows.model(), rows.group(), base, set);
    return program ? std::make_shared<const SphereProgram>(*std::move(program)) : nullptr;
  }

  LaneScene SceneOf(const SphereProgram& program, const Pose& X_WB) {
    std::vector<int> frame_of_class(class_of_frame_.size(), -1);
    for (int frame = 0; frame < body_.TotalFrames(); ++frame) {
      frame_of_class[static_cast<std::size_t>(ClassOf(frame))] = frame;
    }
    const auto terms = [&](int scene_class, const Obstacle& object, std::size_t part) {
      const int frame = frame_of_class[static_cast<std::size_t>(scene_class)];
      double margin_m = margins_.Of(frame, object, part);
      const ObstacleRules rules = rules_.RulesOf(object);
      if (!rules.empty()) {
        const EffectiveRule& rule = rules.At(frame, part);
        if (rule.allowed) return LaneTerms{.is_tested = false};
        margin_m = rule.Margin_m(margin_m);
      }
      const bool is_report = options_.unseen == UnseenSpace::kReport && IsUnseen(object);
      return LaneTerms{.proves_gap_only = margin_m < 0 || is_report,
                       .margin_m = std::max(0.0, margin_m)};
    };
    return CompileScene(world_, filter_, program, X_WB, MaxMargin_m(), terms);
  }

  // The largest margin of a pair with an obstacle.
  double MaxMargin_m() const {
    return std::max({0.0, rules_.max_margin_m(), margins_.MaxOf(world_)});
  }

  // The frames and pairs of frames with an open mesh of the body.
  UnresolvedTags PairsWithOpenMesh() const {
    const auto is_open = [&](std::int32_t k) {
      const PreparedPart& part = body_.geometry->parts[static_cast<std::size_t>(k)];
      return IsUncertain(part.shape) && !filter_.SkipsPart(body_, body_.FrameOf(k), part.source);
    };
    const auto bit = [](std::int32_t tag) { return std::uint64_t{1} << (tag % kTags); };
    UnresolvedTags open;
    bool has_open = false;
    for (std::size_t k = 0; k < body_.geometry->parts.size(); ++k) {
      const auto part = static_cast<std::int32_t>(k);
      if (!is_open(part)) continue;
      has_open = true;
      if (body_.tests_world) open.worlds |= bit(body_.FrameOf(part));
    }
    for (std::size_t k = 0; k < body_.self_pairs.size() && has_open; ++k) {
      const auto [first, second] = body_.self_pairs[k];
      if (is_open(first) || is_open(second)) open.pairs |= bit(frame_pairs_.of_self_pair[k]);
    }
    return open;
  }

  const WorldSnapshot& world_;
  const QueryBody& body_;
  const QueryOptions& options_;
  const bool is_made_of_spheres_;
  const WorldFilter filter_;
  PairRuleLookup rules_;
  const PairMargins margins_;
  const std::vector<int> class_of_frame_;
  const FramePairs frame_pairs_;
  Spheres spheres_;
  std::vector<FixedFrame> fixed_frames_;
  std::vector<SpherePair> sphere_pairs_;
  std::vector<SphereLinkPair> link_pairs_;
};

}  // namespace

std::optional<SphereQuery> CompileQuery(const WorldSnapshot& world, const QueryBody& body,
                                        const JointRows& rows, std::size_t row_count,
                                        const QueryOptions& options) {
  if (!IsSupported(body, rows, options)) return std::nullopt;
  const bool is_made_of_spheres = IsMadeOfSpheres(body);
  if (!is_made_of_spheres && (body.bounding_spheres == nullptr || row_count < kMinRows)) {
    return std::nullopt;
  }
  return QueryCompiler(world, body, options, is_made_of_spheres).Run(rows);
}

}  // namespace cwm::collision
