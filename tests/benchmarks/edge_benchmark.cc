// Certified edges of robots with exact geometry and of robots of spheres, and what something in the
// hand or a rule costs.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "collision/motion/check_paths.h"
#include "collision/query/attached_objects.h"
#include "collision/query/robot_body.h"
#include "collision/robot/kinematics.h"
#include "tests/benchmarks/benchmark_arms.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/panda_problems.h"
#include "tests/benchmarks/state_draws.h"

namespace cwm::benchmarks {
namespace {

using namespace collision;

constexpr int kEdges = 200, kSphereEdges = 4'096;
// Edges of one request: a planner asks for many spheres' edges at once, and for few of meshes.
constexpr int kSphereBatch = 256;
constexpr int kSamples = 33, kFineSamples = 1'024;
constexpr double kHeldRadius_m = 0.033, kHeldLength_m = 0.12;

// A world of boxes in reach of an arm.
std::shared_ptr<const WorldSnapshot> BoxesAround(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> angle(-std::numbers::pi, std::numbers::pi),
      reach(0.45, 0.9), height(-0.2, 0.9);
  std::vector<Change> changes;
  for (int k = 0; k < count; ++k) {
    const double at = angle(random), far = reach(random);
    PutObject put;
    put.name = "box" + std::to_string(k);
    put.X_WO = MakeTranslation(far * std::cos(at), far * std::sin(at), height(random));
    put.geometry = BodyFromShapes({{.shape = Box{{0.1, 0.1, 0.15}}}}).geometry;
    changes.push_back({.what = std::move(put), .expected_object_revision = {}});
  }
  return *Apply(std::make_shared<const WorldSnapshot>(), changes);
}

// Edges of one radian from free states.
struct EdgeTally {
  std::vector<double> ms;
  int contacts = 0, undecided = 0, grazing = 0, false_free = 0, false_contact = 0;
  double sampled_s = 0, certified_s = 0;
};

struct EdgeTask {
  std::string name;
  const RobotModel& model;
  const JointGroup& group;
  const QueryBody& body;
  const WorldSnapshot& world;
  int edges = kEdges;
  int batch = 1;
};

JointRows RowsOf(const EdgeTask& task, const std::vector<double>& rows) {
  return {task.model, task.group, {.base = DefaultVariables(task.model), .rows = rows}};
}

std::vector<Verdict> VerdictsOf(const EdgeTask& task, const std::vector<double>& rows) {
  return CheckCollisions(task.world, task.body, RowsOf(task, rows),
                         {.naming = Naming::kWhereTested})
      ->verdict;
}

bool IsFree(const EdgeTask& task, const std::vector<double>& rows) {
  return std::ranges::all_of(VerdictsOf(task, rows), [](Verdict v) { return v == Verdict::kFree; });
}

// Appends states evenly spaced between two fractions of an edge.
void Sample(const std::vector<double>& ends, std::size_t edge, std::size_t width, double begin,
            double end, int samples, std::vector<double>& rows) {
  const double* const from = ends.data() + 2 * edge * width;
  for (int k = 0; k < samples; ++k) {
    const double share = begin + (end - begin) * k / std::max(1, samples - 1);
    for (std::size_t v = 0; v < width; ++v) {
      rows.push_back(std::lerp(from[v], from[v + width], share));
    }
  }
}

// Compares the answers with samples of the edges.
void Verify(const EdgeTask& task, const std::vector<double>& ends, const MotionColumns& answer,
            EdgeTally& tally) {
  const std::size_t width = task.group.variables.size();
  for (std::size_t e = 0; e < answer.verdict.size(); ++e) {
    const MotionVerdict verdict = answer.verdict[e];
    tally.contacts += verdict == MotionVerdict::kContact;
    tally.undecided += verdict == MotionVerdict::kUndecided;
    tally.grazing += verdict == MotionVerdict::kGrazing;
    std::vector<double> rows;
    if (verdict == MotionVerdict::kFree) {
      Sample(ends, e, width, 0, 1, kFineSamples, rows);
      tally.false_free += !IsFree(task, rows);
    } else if (verdict == MotionVerdict::kContact) {
      Sample(ends, e, width, answer.hi[e], answer.hi[e], 1, rows);
      tally.false_contact += IsFree(task, rows);
      rows.clear();
      Sample(ends, e, width, 0, answer.lo[e], kFineSamples, rows);
      tally.false_free += answer.lo[e] > 0 && !IsFree(task, rows);
    }
  }
}

EdgeTally EdgesOf(const EdgeTask& task) {
  StateDraws draws(task.model, task.group, 23);
  const std::size_t width = task.group.variables.size();
  EdgeTally tally;
  for (int done = 0; done < task.edges; done += task.batch) {
    std::vector<double> ends, samples;
    std::vector<Path> paths;
    while (std::ssize(paths) < task.batch) {
      const std::vector<double> from = draws.Next();
      if (!IsFree(task, from)) continue;
      const std::vector<double> to = draws.OneRadianFrom(from);
      paths.push_back({.first_row = ends.size() / width});
      ends.insert(ends.end(), from.begin(), from.end());
      ends.insert(ends.end(), to.begin(), to.end());
      Sample(ends, paths.size() - 1, width, 0, 1, kSamples, samples);
    }
    double start_s = ThreadSeconds();
    VerdictsOf(task, samples);
    tally.sampled_s += ThreadSeconds() - start_s;
    start_s = ThreadSeconds();
    const MotionColumns answer =
        *CheckPaths(task.world, task.body,
                    JointWaypoints(task.model, task.body, RowsOf(task, ends)), paths, {});
    const double spent_s = ThreadSeconds() - start_s;
    tally.certified_s += spent_s;
    tally.ms.push_back(1e3 * spent_s / task.batch);
    Verify(task, ends, answer, tally);
  }
  return tally;
}

void Describe(const EdgeTask& task, const EdgeTally& tally, Report& report) {
  char text[320];
  std::snprintf(
      text, sizeof(text),
      "  %-16s %d edges of 1 rad: %.4f ms in the mean (33 samples %.4f), %.4f at p50, %.4f "
      "at p99, %.4f at most; %d in contact, %d grazing, %d undecided, %d told free where a "
      "sample hits, %d told in contact where none does",
      task.name.c_str(), task.edges, Mean(tally.ms), 1e3 * tally.sampled_s / task.edges,
      Quantile(tally.ms, 0.5), Quantile(tally.ms, 0.99), Quantile(tally.ms, 1), tally.contacts,
      tally.grazing, tally.undecided, tally.false_free, tally.false_contact);
  report.Detail(text);
}

void AddEdges(const EdgeTask& task, const std::string& key, Report& report) {
  const EdgeTally tally = EdgesOf(task);
  Describe(task, tally, report);
  report.Add({.key = key, .value = Mean(tally.ms), .unit = "ms", .how = "mean of the edges"});
  report.Add({.key = key + "_p99",
              .value = Quantile(tally.ms, 0.99),
              .unit = "ms",
              .how = "of the same edges"});
  report.Add({.key = key + "_false",
              .value = static_cast<double>(tally.false_free + tally.false_contact),
              .unit = "edges",
              .how = "told free, though one of 1 024 samples collides, or told in contact where "
                     "the state is free"});
}

// The time of a state among 128, of spheres with and without something in the hand, and with and
// without a rule, in turn.
void AddCliffs(const PandaProblems& panda, Report& report) {
  constexpr std::size_t kRows = 128;
  constexpr int kRounds = 400;
  const RobotModel& model = *panda.robot->model;
  PutRobot robot{.name = "panda", .robot = panda.robot, .state = DefaultVariables(model)};
  const auto plain = *Apply(BoxesAround(12, 3),
                            std::vector<Change>{{.what = robot, .expected_object_revision = {}}});
  PutObject can;
  can.name = "can";
  can.X_WO = MakeTranslation(0, 0, 3);
  can.geometry = BodyFromShapes({{.shape = Cylinder{kHeldRadius_m, kHeldLength_m}}}).geometry;
  const auto held = *Apply(
      plain, std::vector<Change>{
                 {.what = can, .expected_object_revision = {}},
                 {.what = AttachObject{.name = "can",
                                       .robot = "panda",
                                       .link = "panda_hand",
                                       .X_LO = MakeTranslation(0, 0, 0.12),
                                       .touch_links = {"panda_leftfinger", "panda_rightfinger"}},
                  .expected_object_revision = {}}});
  const auto allow = [](const NamedThing& a, const NamedThing& b) {
    return Change{.what = AllowCollision{.pair = {a, b}}, .expected_object_revision = {}};
  };
  const auto ruled =
      *Apply(plain, std::vector<Change>{allow({"panda", "panda_link5"}, {"box0"}),
                                        allow({"panda", "panda_link0"}, {"panda", "panda_link5"})});
  StateDraws draws(model, *panda.arm, 31);
  std::vector<double> rows;
  for (std::size_t k = 0; k < kRows; ++k) {
    const std::vector<double> row = draws.Next();
    rows.insert(rows.end(), row.begin(), row.end());
  }
  const auto seconds_of = [&](const WorldSnapshot& world) {
    const WorldRobotPtr of_world = world.FindRobot("panda");
    QueryBody body =
        BodyFromSpheres(*panda.robot, *panda.robot->prepared_spheres_as_given, RobotScope::kBoth);
    body.self = "panda";
    body.robot = panda.robot->model;
    body.programs = panda.robot->programs;
    body = WithAttachedObjects(std::move(body), world, *of_world, RobotScope::kBoth);
    const double start_s = ThreadSeconds();
    const auto answer = CheckCollisions(
        world, body, JointRows(model, *panda.arm, {.base = DefaultVariables(model), .rows = rows}),
        {.naming = Naming::kWhereTested});
    return answer.ok() ? ThreadSeconds() - start_s : 0;
  };
  double plain_s = 0, held_s = 0, ruled_s = 0;
  for (int round = 0; round < kRounds; ++round) {
    plain_s += seconds_of(*plain);
    held_s += seconds_of(*held);
    ruled_s += seconds_of(*ruled);
  }
  const double per_state_us = 1e6 / (static_cast<double>(kRows) * kRounds);
  char text[200];
  std::snprintf(text, sizeof(text),
                "  panda spheres, 128 states a request: %.2f us a state, %.2f with a can in the "
                "hand, %.2f with two rules",
                plain_s * per_state_us, held_s * per_state_us, ruled_s * per_state_us);
  report.Detail(text);
  report.Add({.key = "attached_ratio",
              .value = held_s / plain_s,
              .unit = "1",
              .how = "a state with a can in the hand over one without"});
  report.Add({.key = "rule_ratio",
              .value = ruled_s / plain_s,
              .unit = "1",
              .how = "a state with two rules of checked pairs over one without"});
}

// The share of the states free of self-collision that the spheres around the links prove free.
double ContainingShare(const RobotGeometry& robot, const JointGroup& group,
                       const WorldSnapshot& world) {
  const RobotModel& model = *robot.model;
  StateDraws draws(model, group, 37);
  std::vector<double> rows;
  for (int k = 0; k < 2'000; ++k) {
    const std::vector<double> row = draws.Next();
    rows.insert(rows.end(), row.begin(), row.end());
  }
  const auto verdicts_of = [&](const QueryBody& body) {
    return CheckCollisions(world, body,
                           JointRows(model, group, {.base = DefaultVariables(model), .rows = rows}),
                           {.naming = Naming::kWhereTested})
        ->verdict;
  };
  const auto exact = verdicts_of(BodyFromRobot(robot, RobotScope::kSelf));
  const auto proven = verdicts_of(BodyFromBounds(robot, *robot.prepared_bounds, RobotScope::kSelf));
  int free = 0, told = 0;
  for (std::size_t k = 0; k < exact.size(); ++k) {
    if (exact[k] != Verdict::kFree) continue;
    ++free;
    told += proven[k] == Verdict::kFree;
  }
  return static_cast<double>(told) / std::max(1, free);
}

}  // namespace

void MeasureEdges(Report& report) {
  const auto world = BoxesAround(12, 3);
  const std::optional<PandaProblems> panda = ReadPandaProblems();
  if (!panda) return report.Fail("edges of the Panda: motion_bench_maker is not in CWM_DATA");
  const RobotModel& model = *panda->robot->model;
  QueryBody spheres =
      BodyFromSpheres(*panda->robot, *panda->robot->prepared_spheres_as_given, RobotScope::kBoth);
  spheres.programs = panda->robot->programs;
  const EdgeTask of_spheres{"panda spheres", model,        *panda->arm, spheres,
                            *world,          kSphereEdges, kSphereBatch};
  const EdgeTally tally = EdgesOf(of_spheres);
  Describe(of_spheres, tally, report);
  report.Add({.key = "edge_spheres_ratio",
              .value = tally.certified_s / std::max(1e-9, tally.sampled_s),
              .unit = "1",
              .how = "a certified edge of the Panda's spheres over 33 samples of it, 256 edges a "
                     "request; " +
                     std::to_string(tally.false_free + tally.false_contact) + " false"});
  AddCliffs(*panda, report);
  double least_share = ContainingShare(*panda->robot, *panda->arm, *world);
  const auto add = [&](const std::string& name, const std::shared_ptr<const RobotModel>& of_arm,
                       const JointGroup& group) {
    const auto robot = PrepareRobot(of_arm, std::nullopt);
    const QueryBody body = BodyFromRobot(*robot, RobotScope::kBoth);
    least_share = std::min(least_share, ContainingShare(*robot, group, *world));
    AddEdges({name, *of_arm, group, body, *world}, "edge_exact_ms_" + name, report);
  };
  const BenchmarkArm six = SixJointArm(), fourteen = FourteenJointArms();
  add("six", six.model, six.model->all);
  add("fourteen", fourteen.model, fourteen.model->all);
  const QueryBody exact = BodyFromRobot(*panda->robot, RobotScope::kBoth);
  AddEdges({"panda", model, *panda->arm, exact, *world}, "edge_exact_ms_panda", report);
  constexpr std::size_t kFineTriangles = 40'000;
  const auto fine = WithFinerMeshes(model, kFineTriangles);
  add("panda_fine", fine, *fine->FindGroup("panda_arm"));
  report.Add({.key = "containing_free_share",
              .value = least_share,
              .unit = "1",
              .how = "states free of self-collision that SPHERES_CONTAINING calls free, the worst "
                     "of these robots"});
}

}  // namespace cwm::benchmarks
