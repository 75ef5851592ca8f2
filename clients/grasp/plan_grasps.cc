#include "clients/grasp/plan_grasps.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "clients/cpp/call_error.h"
#include "clients/grasp/sample_object.h"

namespace cwm::grasp {
namespace {

absl::Status CheckRange(const char* option, double value, double min, double max,
                        const char* rule) {
  if (std::isfinite(value) && value >= min && value <= max) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(option, ": ", value, " must be ", rule));
}

using ObjectsByName = std::map<std::string, Object>;

// The number of letters to change, insert or remove.
std::size_t EditDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t changed = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, changed});
    }
  }
  return row.back();
}

absl::Status UnknownObjectError(const std::string& name, const ObjectsByName& objects) {
  std::string nearest;
  std::size_t min_distance = name.size() / 2 + 1;  // a larger distance means another word
  for (const auto& [known, object] : objects) {
    const std::size_t distance = EditDistance(name, known);
    if (distance >= min_distance) continue;
    min_distance = distance;
    nearest = known;
  }
  std::string message = absl::StrCat("object \"", name, "\" is not in the world");
  if (!nearest.empty()) absl::StrAppend(&message, "; did you mean \"", nearest, "\"?");
  return absl::NotFoundError(message);
}

// The reason why the object cannot be grasped; empty: it can.
std::string UngraspableReason(const Object& object) {
  if (object.kind == ObjectKind::kSupport) return "is a support: it stays where it is";
  if (object.kind == ObjectKind::kUnseen) return "is unseen space: nothing is known of it";
  if (object.kind == ObjectKind::kMover) return "is a mover: nothing of it is modelled";
  if (!object.bounds) return "has no bounds: it reaches without end";
  if (object.attachment) {
    return absl::StrCat("is held by ", object.attachment->robot, "/", object.attachment->link);
  }
  return "";
}

absl::StatusOr<std::vector<Object>> Targets(const PlanRequest& request,
                                            const ObjectsByName& objects) {
  std::vector<Object> targets;
  if (request.objects.empty()) {
    for (const auto& [name, object] : objects) {
      const bool unexplained = object.kind == ObjectKind::kResidual;
      if (!unexplained && UngraspableReason(object).empty()) targets.push_back(object);
    }
    return targets;
  }
  ObjectsByName wanted;  // each object once, by name
  for (const std::string& name : request.objects) {
    const auto found = objects.find(name);
    if (found == objects.end()) return UnknownObjectError(name, objects);
    const std::string why = UngraspableReason(found->second);
    if (!why.empty()) {
      return absl::InvalidArgumentError(absl::StrCat("object \"", name, "\" ", why));
    }
    wanted[name] = found->second;
  }
  for (const auto& [name, object] : wanted) targets.push_back(object);
  return targets;
}

// The obstacles of the candidates, the most frequent first: "71 by table, 12 by its own shape".
std::string FormatObstacles(const ObjectPlan& plan) {
  std::vector<std::pair<std::int64_t, std::string>> blockers;
  for (const auto& [name, count] : plan.blocked_by) {
    const bool own = name == plan.object.name;
    blockers.emplace_back(count, own ? "its own shape" : name.empty() ? "what is unsure" : name);
  }
  std::stable_sort(blockers.begin(), blockers.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::string text;
  for (const auto& [count, name] : blockers) {
    absl::StrAppend(&text, text.empty() ? "" : ", ", count, " by ", name);
  }
  return text;
}

std::string FailureReason(const Candidates& candidates, const ObjectPlan& plan,
                          const PlanRequest& request) {
  const double max_width_m = request.gripper.opening_m - 2 * request.clearance_m;
  if (plan.tried_count > 0) {
    std::int64_t blocked = 0;
    for (const auto& [name, count] : plan.blocked_by) blocked += count;
    if (2 * blocked >= plan.tried_count) {
      return absl::StrFormat("no free approach: %d of %d blocked, %s", blocked, plan.tried_count,
                             FormatObstacles(plan));
    }
    return absl::StrFormat("no hold: the pads of %d of %d slip or miss", plan.tried_count - blocked,
                           plan.tried_count);
  }
  if (candidates.min_width_m > max_width_m) {
    return absl::StrFormat("too wide by %.1f mm: %.1f mm at its narrowest, %.1f mm fit",
                           1e3 * (candidates.min_width_m - max_width_m),
                           1e3 * candidates.min_width_m, 1e3 * max_width_m);
  }
  if (candidates.min_tilt_rad >= 0) {
    return absl::StrFormat("slips: its wall is tilted by %.1f deg, friction %.2g holds %.1f deg",
                           candidates.min_tilt_rad * 180 / std::numbers::pi, request.friction,
                           std::atan(request.friction) * 180 / std::numbers::pi);
  }
  return "no opposite surfaces are known of it";
}

// True if the grasps are the same for a robot: a few millimetres and degrees apart, possibly after
// half a turn about the approach.
bool AreSimilar(const Grasp& a, const Grasp& b) {
  constexpr double kNear_m = 0.005, kNear_rad = 0.35;
  const Eigen::Isometry3d& X_WA = a.candidate.X_FG;
  const Eigen::Isometry3d& X_WB = b.candidate.X_FG;
  if ((X_WA.translation() - X_WB.translation()).norm() > kNear_m) return false;
  const Eigen::Matrix3d R_AB = X_WA.linear().transpose() * X_WB.linear();
  const Eigen::AngleAxisd as_is(R_AB);
  const Eigen::AngleAxisd turned(R_AB * Eigen::Vector3d(-1, -1, 1).asDiagonal());
  return std::min(std::abs(as_is.angle()), std::abs(turned.angle())) < kNear_rad;
}

// The best grasps first, each different from all better ones.
std::vector<Grasp> BestDistinct(std::vector<Grasp> grasps, int max_count) {
  std::stable_sort(grasps.begin(), grasps.end(),
                   [](const Grasp& a, const Grasp& b) { return a.score > b.score; });
  std::vector<Grasp> best;
  for (const Grasp& grasp : grasps) {
    if (best.size() == static_cast<std::size_t>(max_count)) break;
    const bool known = std::any_of(best.begin(), best.end(),
                                   [&](const Grasp& better) { return AreSimilar(better, grasp); });
    if (!known) best.push_back(grasp);
  }
  return best;
}

// The attempts of one object.
struct ObjectAttempts {
  Candidates candidates;
  std::size_t first_attempt = 0;
};

ObjectPlan PlanOf(const Object& object, const ObjectAttempts& tried,
                  const std::vector<Assessment>& assessments, const PlanRequest& request,
                  const GraspQuery& query) {
  ObjectPlan plan{.object = object};
  plan.tried_count = static_cast<std::int64_t>(tried.candidates.list.size());
  for (std::size_t i = 0; i < tried.candidates.list.size(); ++i) {
    const Assessment& assessment = assessments[tried.first_attempt + i];
    if (assessment.failure == GraspFailure::kBlocked) ++plan.blocked_by[assessment.obstacle];
    if (assessment.failure != GraspFailure::kNone) continue;
    Grasp grasp{.candidate = tried.candidates.list[i], .assessment = assessment};
    grasp.factors = FactorsOf(grasp.candidate, assessment, object, query);
    grasp.score = ScoreOf(grasp.factors);
    plan.grasps.push_back(grasp);
  }
  plan.free_count = static_cast<std::int64_t>(plan.grasps.size());
  plan.grasps = BestDistinct(std::move(plan.grasps), request.top);
  if (plan.free_count == 0) plan.failure_reason = FailureReason(tried.candidates, plan, request);
  return plan;
}

Plan PlanTargets(const WorldView& world, const std::vector<Object>& targets,
                 const PlanRequest& request) {
  Plan plan{
      .world = world.name(), .world_uid = world.uid(), .revision = world.revision(), .objects = {}};
  const SamplerOptions options{
      .gripper = request.gripper, .friction = request.friction, .min_gap_m = request.clearance_m};
  std::vector<ObjectAttempts> tried;
  std::vector<Attempt> attempts;
  for (const Object& object : targets) {
    ObjectAttempts of_object{.candidates = SampleObject(object, options),
                             .first_attempt = attempts.size()};
    for (const Candidate& candidate : of_object.candidates.list) {
      attempts.push_back({.X_WG = candidate.X_FG, .target = object.name});
    }
    tried.push_back(std::move(of_object));
  }
  const GraspQuery query = MakeGraspQuery(request);
  const std::vector<Assessment> assessments = Assess(world, query, attempts);
  for (std::size_t i = 0; i < targets.size(); ++i) {
    plan.objects.push_back(PlanOf(targets[i], tried[i], assessments, request, query));
  }
  return plan;
}

}  // namespace

absl::Status Validate(const PlanRequest& request) {
  for (const absl::Status& status :
       {Validate(request.gripper), CheckRange("--friction", request.friction, 0, 10, "0 to 10"),
        CheckRange("--approach", request.approach_m, 0, 1, "0 to 1 m"),
        CheckRange("--clearance", request.clearance_m, 0, request.gripper.opening_m / 2,
                   "0 to half of --opening"),
        CheckRange("--top", request.top, 1, 10000, "1 to 10000")}) {
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

GraspQuery MakeGraspQuery(const PlanRequest& request) {
  return {.gripper = request.gripper,
          .friction = request.friction,
          .approach_m = request.approach_m,
          .clearance_m = request.clearance_m};
}

absl::StatusOr<Plan> PlanGrasps(const WorldView& world, const PlanRequest& request) {
  if (absl::Status status = Validate(request); !status.ok()) return status;
  try {
    const WorldView pinned = world.At();
    ObjectsByName objects;
    for (Object& object : pinned.Objects()) {
      const std::string name = object.name;
      objects[name] = std::move(object);
    }
    const auto targets = Targets(request, objects);
    if (!targets.ok()) return targets.status();
    return PlanTargets(pinned, *targets, request);
  } catch (const Error& error) {
    return client::StatusFromError(error);
  }
}

}  // namespace cwm::grasp
