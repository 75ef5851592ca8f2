#include "collision/query/sphere_check.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collision/geometry/validation.h"
#include "collision/query/body_search.h"
#include "collision/query/pair_rule_lookup.h"
#include "collision/query/sphere_scene.h"
#include "collision/robot/kinematics.h"
#include "collision/spheres/program_cache.h"

namespace cwm::collision {
namespace {

// measured: compiling the spheres around the parts of an arm for its first query takes a tenth of a
// millisecond, which pays off only with at least this many rows.
constexpr std::size_t kMinRows = 256;

using Spheres = std::vector<PlacedSphere>;

// The spheres of the body without attached objects; empty if it is not made of spheres.
std::optional<Spheres> OwnSpheres(const QueryBody& body) {
  Spheres spheres;
  const std::vector<PreparedPart>& parts = body.geometry->parts;
  spheres.reserve(parts.size());
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const int frame = body.FrameOf(static_cast<std::int32_t>(k));
    if (frame >= body.frame_count) break;
    const auto* sphere = std::get_if<Sphere>(&parts[k].shape);
    if (sphere == nullptr) return std::nullopt;
    spheres.push_back(
        {.link = frame, .centre_L = parts[k].X_OP.translation(), .radius_m = sphere->radius_m});
  }
  return spheres;
}

Spheres PlacedSpheresOf(const SphereModel& around) {
  Spheres spheres;
  for (std::size_t link = 0; link < around.links.size(); ++link) {
    for (const LinkSphere& sphere : around.links[link]) {
      spheres.push_back({.link = static_cast<int>(link),
                         .centre_L = sphere.center_L,
                         .radius_m = sphere.radius_m});
    }
  }
  return spheres;
}

// Adds one sphere around each part of the attached objects, enlarged by the object's margin.
void AddAttached(const QueryBody& body, Spheres& spheres) {
  for (std::size_t k = 0; k < body.attached.size(); ++k) {
    const WorldObject& object = *body.attached[k].object;
    const double margin_m = std::max(0.0, object.margin_m);
    for (const PreparedPart& part : object.geometry->parts) {
      spheres.push_back({.link = body.frame_count + static_cast<int>(k),
                         .centre_L = part.bounds_O.center(),
                         .radius_m = 0.5 * part.bounds_O.sizes().norm() + margin_m});
    }
  }
}

std::vector<FixedFrame> FixedFramesOf(const QueryBody& body) {
  std::vector<FixedFrame> fixed_frames;
  for (const AttachedObject& attached : body.attached) {
    fixed_frames.push_back({.link = attached.link, .X_LF = attached.X_FO});
  }
  return fixed_frames;
}

// True if no rule sets a larger margin than `margin_m`, so that pairs proven apart by that margin
// stay free.
bool RulesKeepFreePairs(const PairRuleLookup& rules, double margin_m) {
  const auto keeps = [&](const EffectiveRule& rule) {
    return !rule.has_margin || rule.margin_m <= margin_m;
  };
  const std::span<const EffectiveRule> of_itself = rules.SelfPairRules();
  return rules.max_margin_m() <= margin_m && std::all_of(of_itself.begin(), of_itself.end(), keeps);
}

bool IsSupportedBySimd(const RobotModel& model, const QueryBody& body,
                       const QueryOptions& options) {
  if (model.links.size() != static_cast<std::size_t>(body.frame_count)) return false;
  const EngineChoice engine = options.engine;
  if (engine != EngineChoice::kAuto && engine != EngineChoice::kExact) return false;
  if (options.margin_sigma > 0) return false;
  if (options.unseen == UnseenSpace::kReport) return false;  // the obstacle's identity matters then
  return options.margin_m >= 0 && body.margin_m + options.margin_m >= 0;
}

// The compiled program of the spheres; nullptr if the SIMD kinematics do not support a joint.
std::shared_ptr<const SphereProgram> ProgramOf(const QueryBody& body, const JointRows& joints,
                                               const SphereSet& set, double margin_m) {
  const std::vector<double>& base = joints.states().base;
  if (body.programs && &body.programs->model() == &joints.model()) {
    return body.programs->Find(joints.group(), base, set, margin_m);
  }
  auto program = CompileSpheres(joints.model(), joints.group(), base, set, margin_m);
  if (!program) return nullptr;
  return std::make_shared<const SphereProgram>(*std::move(program));
}

// The frames and pairs of frames with an open mesh of the body.
UnresolvedTags PairsWithOpenMesh(const QueryBody& body, const WorldFilter& filter,
                                 const FramePairs& frame_pairs) {
  const auto is_open = [&](std::int32_t k) {
    const PreparedPart& part = body.geometry->parts[static_cast<std::size_t>(k)];
    return IsOpenMesh(part.shape) && !filter.SkipsPart(body, body.FrameOf(k), part.source);
  };
  const auto bit = [](std::int32_t tag) { return std::uint64_t{1} << (tag % kTags); };
  UnresolvedTags open;
  for (std::size_t k = 0; k < body.geometry->parts.size() && body.tests_world; ++k) {
    const auto part = static_cast<std::int32_t>(k);
    if (is_open(part)) open.worlds |= bit(body.FrameOf(part));
  }
  for (std::size_t k = 0; k < body.self_pairs.size(); ++k) {
    const auto [first, second] = body.self_pairs[k];
    if (is_open(first) || is_open(second)) open.pairs |= bit(frame_pairs.of_self_pair[k]);
  }
  return open;
}

Verdict VerdictOf(StateMark mark, LaneVerdict result) {
  if (mark == StateMark::kOutOfLimits) return Verdict::kOutOfLimits;
  if (mark == StateMark::kTooFar || result == LaneVerdict::kUnresolved) return Verdict::kUndecided;
  return result == LaneVerdict::kFree ? Verdict::kFree : Verdict::kCollision;
}

}  // namespace

SphereCheck::SphereCheck(const JointRows& rows, std::shared_ptr<const SphereProgram> program,
                         CompiledWorld world, SphereRole role)
    : rows_(&rows),
      role_(role),
      program_(std::move(program)),
      scene_(std::move(world.scene)),
      tags_for_accuracy_(world.tags_for_accuracy),
      order_(*program_) {
  const RobotModel& model = rows.model();
  std::vector<double> base = rows.states().base;
  for (const int variable : rows.group().variables) {
    const Variable& of_row = model.variables[static_cast<std::size_t>(variable)];
    // Set within limits, so that only the base's other variables are tested.
    base[static_cast<std::size_t>(variable)] =
        std::isfinite(of_row.lower) ? of_row.lower : std::min(0.0, of_row.upper);
  }
  base_is_within_limits_ = !OutOfLimits(model, base).has_value();
}

std::optional<SphereCheck> SphereCheck::Make(const WorldSnapshot& world, const QueryBody& body,
                                             const BodyRows& rows, const QueryOptions& options) {
  const auto* joints = dynamic_cast<const JointRows*>(&rows);
  if (joints == nullptr || !IsSupportedBySimd(joints->model(), body, options)) return std::nullopt;
  // Prismatic joints beyond kMaxSlide_m make a row UNDECIDED in any case.
  if (joints->range().Reach_m(kMaxSlide_m) > kMaxCoordinate_m) return std::nullopt;
  const double margin_m = body.margin_m + options.margin_m;
  const PairRuleLookup rules(world, body, options);
  if (!RulesKeepFreePairs(rules, std::min(options.margin_m, margin_m))) return std::nullopt;
  const bool has_rules = rules.MayChangeWorldPairs() || !rules.SelfPairRules().empty();

  std::optional<Spheres> spheres = OwnSpheres(body);
  const bool is_the_body = spheres.has_value() && body.attached.empty() && !has_rules;
  if (!is_the_body && rows.size() < kMinRows) return std::nullopt;
  if (!spheres) {
    if (body.bounding_spheres == nullptr) return std::nullopt;
    spheres = PlacedSpheresOf(*body.bounding_spheres);
  }
  AddAttached(body, *spheres);
  std::vector<SpherePair> pairs;
  FramePairs frame_pairs;
  if (is_the_body) {
    pairs.reserve(body.self_pairs.size());
    for (const PartPair& pair : body.self_pairs) pairs.push_back({pair.first, pair.second});
  } else {
    frame_pairs = FramePairsOf(body);
  }
  const std::vector<FixedFrame> fixed_frames = FixedFramesOf(body);
  const std::shared_ptr<const SphereProgram> program =
      ProgramOf(body, *joints,
                {.spheres = *spheres,
                 .fixed_frames = fixed_frames,
                 .pairs = {.spheres = pairs, .links = frame_pairs.pairs}},
                options.margin_m);
  if (!program) return std::nullopt;
  const WorldFilter filter(world, options, body);
  const Pose& X_WB = joints->states().X_WB;
  CompiledWorld of_lanes{.scene = body.tests_world
                                      ? CompileScene(world, filter, *program, X_WB, margin_m)
                                      : EmptyScene(*program),
                         .tags_for_accuracy = {}};
  if (body.best_accuracy < Accuracy::kSurfaceOnly) {
    if (!is_the_body) of_lanes.tags_for_accuracy = PairsWithOpenMesh(body, filter, frame_pairs);
    const bool reaches_uncertain =
        body.tests_world && (ReachesOpenMeshes(world, filter, *program, X_WB, margin_m) ||
                             ReachesHiddenSpaces(world, filter, *program, X_WB, margin_m));
    if (body.hidden_m > 0 || reaches_uncertain) {
      of_lanes.tags_for_accuracy.worlds = BodySearch::kAllUnresolved.worlds;
    }
  }
  return SphereCheck(*joints, program, std::move(of_lanes),
                     is_the_body ? SphereRole::kExact : SphereRole::kBounding);
}

std::span<const Verdict> SphereCheck::Check(std::size_t first, std::size_t count) {
  const std::size_t width = rows_->group().variables.size();
  const std::size_t stride = (count + kMaxLanes - 1) / kMaxLanes * kMaxLanes;
  values_.resize(program_->inputs.size() * stride);
  sorted_values_.resize(values_.size());
  marks_.resize(count);
  verdicts_.resize(count);
  LoadStates(program_->inputs, rows_->states().rows.data() + first * width, width, count, stride,
             values_.data(), marks_.data());
  const std::span<const std::uint32_t> order = order_.Sort(values_.data(), stride, count);
  for (std::size_t k = 0; k < program_->inputs.size(); ++k) {
    const float* from = values_.data() + k * stride;
    float* to = sorted_values_.data() + k * stride;
    for (std::size_t i = 0; i < count; ++i) to[i] = from[order[i]];
    std::fill(to + count, to + stride, 0.0F);
  }
  CheckLanes(stride, count, order);
  if (!base_is_within_limits_) std::ranges::fill(verdicts_, Verdict::kOutOfLimits);
  return verdicts_;
}

void SphereCheck::CheckLanes(std::size_t stride, std::size_t count,
                             std::span<const std::uint32_t> order) {
  if (role_ == SphereRole::kExact) {
    lane_verdicts_.resize(count);
    CheckStates(program_->lanes, scene_, sorted_values_.data(), stride, count, memory_,
                lane_verdicts_.data());
    for (std::size_t i = 0; i < count; ++i) {
      verdicts_[order[i]] = VerdictOf(marks_[order[i]], lane_verdicts_[i]);
    }
    return;
  }
  found_.resize(count);
  open_.resize(count);
  FindUnresolved(program_->lanes, scene_, sorted_values_.data(), stride, count, memory_,
                 found_.data());
  for (std::size_t i = 0; i < count; ++i) {
    const bool is_unknown = marks_[order[i]] == StateMark::kTooFar;
    open_[order[i]] = is_unknown ? BodySearch::kAllUnresolved : found_[i];
  }
  for (std::size_t i = 0; i < count; ++i) {
    const bool is_free = open_[i].worlds == 0 && open_[i].pairs == 0;
    verdicts_[i] = marks_[i] == StateMark::kOutOfLimits ? Verdict::kOutOfLimits
                   : is_free                            ? Verdict::kFree
                                                        : Verdict::kUndecided;
  }
}

}  // namespace cwm::collision
