// Where FCL tells another verdict of the Panda's meshes than the exact engine, over a million
// states of which many are next to contact, and why.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <span>
#include <vector>

#include "collision/engines/engine.h"
#include "collision/geometry/signed_distance.h"
#include "collision/geometry/tessellate.h"
#include "collision/geometry/winding.h"
#include "collision/query/robot_body.h"
#include "collision/robot/kinematics.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/contact_states.h"
#include "tests/benchmarks/fcl_robot.h"

namespace cwm::benchmarks {
namespace {

using namespace collision;

constexpr std::size_t kStates = 1000000;
// What nobody can measure: the surfaces are given in single precision, FCL's own tolerances are
// 1e-6.
constexpr double kTouching_m = 1e-6;

enum class Why { kContained, kTouching, kUnknown };

struct Tally {
  std::size_t states = 0, colliding = 0, near = 0, different = 0;
  std::array<std::size_t, 3> by_reason = {};
};

struct PlacedPart {
  const PreparedPart& part;
  Pose X_WP;
};

// Whether all corners of one lie in the other: by solid angles or formulas, not by the trees and
// hulls that the engine looks at. If surfaces crossed, some would not.
bool HoldsAllOf(const PlacedPart& holder, const PlacedPart& other) {
  const Pose X_HO = holder.X_WP.inverse(Eigen::Isometry) * other.X_WP;
  const auto* mesh = std::get_if<Mesh>(&holder.part.shape);
  if (mesh != nullptr && !mesh->watertight) return false;
  const std::vector<Vector3> corners = Tessellate(other.part.shape).vertices;
  return std::all_of(corners.begin(), corners.end(), [&](const Vector3& p_O) {
    const Vector3 p = X_HO * p_O;
    if (mesh == nullptr) return SignedDistance_m(holder.part.shape, p) < 0;
    return std::abs(WindingNumber(*mesh->mesh, p)) > 0.5;
  });
}

// Whether FCL tells the other verdict after the second part has moved by no more than kTouching_m.
bool ChangesWithinTouching(const FclRobot& fcl, const FclRobot::Pair& pair, bool told) {
  for (const double x : {-1.0, 0.0, 1.0}) {
    for (const double y : {-1.0, 0.0, 1.0}) {
      for (const double z : {-1.0, 0.0, 1.0}) {
        const Vector3 d(x, y, z);
        if (d.isZero()) continue;
        if (fcl.PairCollides(pair, kTouching_m * d.normalized()) != told) return true;
      }
    }
  }
  return false;
}

class Explainer {
 public:
  Explainer(const QueryBody& body, const WorldSnapshot& world, const FclRobot& fcl)
      : body_(body), fcl_(fcl) {
    for (const WorldObjectPtr& object : world.objects()) {
      for (std::size_t k = 0; k < object->parts_W.size(); ++k) {
        world_.push_back({object->geometry->parts[k], object->parts_W[k].X_WP});
      }
    }
  }

  // Of a state in which the verdicts differ, as `fcl` was last asked: every pair of which they do
  // must be explained, and there must be one.
  Why Explain(std::span<const Pose> X_WF) const {
    bool any = false, contained = true;
    const auto must_be_told = [&](const FclRobot::Pair& pair) {
      const Why why = WhyOf(pair, X_WF);
      any = any || why != Why::kUnknown;
      contained = contained && why == Why::kContained;
      return why != Why::kUnknown;
    };
    for (const FclRobot::Pair& pair : Different(X_WF)) {
      if (!must_be_told(pair)) return Why::kUnknown;
    }
    if (!any) return Why::kUnknown;
    return contained ? Why::kContained : Why::kTouching;
  }

 private:
  PlacedPart Part(std::size_t k, std::span<const Pose> X_WF) const {
    const PreparedPart& part = body_.geometry->parts[k];
    return {part, X_WF[static_cast<std::size_t>(body_.frame_of_part[k])] * part.X_OP};
  }

  PlacedPart Other(const FclRobot::Pair& pair, std::span<const Pose> X_WF) const {
    return pair.is_of_itself ? Part(pair.other, X_WF) : world_[pair.other];
  }

  bool Ours(const FclRobot::Pair& pair, std::span<const Pose> X_WF) const {
    const auto placed = [](const PlacedPart& p) {
      return PlacedGeometry{KindOf(p.part.shape),
                            *p.part.engines[static_cast<int>(EngineKind::kExact)], p.X_WP};
    };
    const PlacedPart first = Part(pair.part, X_WF), second = Other(pair, X_WF);
    return GetEngine(EngineKind::kExact).Collides(placed(first), placed(second));
  }

  std::vector<FclRobot::Pair> Different(std::span<const Pose> X_WF) const {
    std::vector<FclRobot::Pair> pairs;
    const auto add = [&](const FclRobot::Pair& pair) {
      if (Ours(pair, X_WF) != fcl_.PairCollides(pair, Vector3::Zero())) pairs.push_back(pair);
    };
    for (const PartPair& pair : body_.self_pairs) {
      add({static_cast<std::size_t>(pair.first), static_cast<std::size_t>(pair.second), true});
    }
    for (std::size_t part = 0; part < body_.geometry->parts.size(); ++part) {
      for (std::size_t other = 0; other < world_.size(); ++other) add({part, other, false});
    }
    return pairs;
  }

  // FCL's meshes are surfaces: what one holds wholly collides with nothing.
  Why WhyOf(const FclRobot::Pair& pair, std::span<const Pose> X_WF) const {
    const bool fcl = fcl_.PairCollides(pair, Vector3::Zero());
    const PlacedPart first = Part(pair.part, X_WF), second = Other(pair, X_WF);
    if (ChangesWithinTouching(fcl_, pair, fcl)) return Why::kTouching;
    if (!fcl && (HoldsAllOf(first, second) || HoldsAllOf(second, first))) {
      return Why::kContained;
    }
    return Why::kUnknown;
  }

  const QueryBody& body_;
  const FclRobot& fcl_;
  std::vector<PlacedPart> world_;
};

void Compare(const PandaProblems& all, const PandaProblem& problem, std::size_t count,
             std::uint64_t seed, Tally& tally) {
  const QueryBody body = BodyFromRobot(*all.robot, RobotScope::kBoth);
  const ContactStates states = StatesAboutContact(all, problem, count, seed);
  const JointRows rows(*all.robot->model, *all.arm,
                       {.base = DefaultVariables(*all.robot->model), .rows = states.rows});
  const CollisionColumns columns = *CheckCollisions(*problem.world, body, rows, {});
  FclRobot fcl(body, *problem.world);
  const Explainer explainer(body, *problem.world, fcl);
  std::vector<Pose> X_WL(all.robot->model->links.size());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    rows.Place(k, X_WL);
    const bool ours = columns.verdict[k] == Verdict::kCollision;
    ++tally.states;
    tally.colliding += ours ? 1 : 0;
    tally.near += states.is_near[k];
    if (fcl.CollidesPlainly(X_WL) == ours) continue;
    ++tally.different;
    ++tally.by_reason[static_cast<std::size_t>(explainer.Explain(X_WL))];
  }
}

}  // namespace

void MeasureUnexplained(Report& report) {
  const std::optional<PandaProblems> all = ReadPandaProblems();
  if (!all) {
    report.Detail("skipped: motion_bench_maker is not in CWM_DATA");
    return;
  }
  const std::size_t each = (kStates + all->problems.size() - 1) / all->problems.size();
  Tally tally;
  for (std::size_t k = 0; k < all->problems.size(); ++k) {
    Compare(*all, all->problems[k], each, k, tally);
  }
  const auto of = [&](Why why) { return tally.by_reason[static_cast<std::size_t>(why)]; };
  char text[240];
  std::snprintf(
      text, sizeof(text),
      "%zu states of the Panda's meshes in %zu scenes, %zu in collision, %zu within %g mm of "
      "contact: FCL tells otherwise of %zu, %zu of them one part inside of another, %zu "
      "within %g m of touching",
      tally.states, all->problems.size(), tally.colliding, tally.near, 1e3 * kNextToContact_m,
      tally.different, of(Why::kContained), of(Why::kTouching), kTouching_m);
  report.Detail(text);
  report.Add({.key = "mbm_unexplained",
              .value = static_cast<double>(of(Why::kUnknown)),
              .unit = "states",
              .how = "verdicts other than FCL's in a million states, half in collision, a quarter "
                     "next to contact, that neither containment nor touching explains"});
}

}  // namespace cwm::benchmarks
