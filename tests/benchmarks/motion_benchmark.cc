// The correctness of certified motions, against dense sampling of the same edges, of a box among
// thirty objects and of the Panda's meshes in the scenes of MotionBenchMaker.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "collision/motion/check_motions.h"
#include "collision/query/robot_body.h"
#include "collision/robot/kinematics.h"
#include "tests/benchmarks/benchmark_world.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/panda_problems.h"

namespace cwm::benchmarks {
namespace {

using namespace collision;

constexpr std::size_t kBodyEdges = 20'000, kSteps = 10'000;
constexpr std::size_t kMoreBodyEdges = 100'000, kFewSteps = 500;
// The body moves some millimetres between two of the few samples: from a sample with a wider gap
// than this it cannot step over anything. Nearer to objects, samples are as dense as in the first
// measurement.
constexpr double kNear_m = 5e-3;
constexpr std::size_t kFiner = kSteps / kFewSteps;
constexpr std::size_t kPandaEdges = 2'000;
constexpr std::size_t kThreads = 2;
constexpr double kSlow_m = 1e-3;  // over the whole edge: brackets may then be wider

// Poses along an edge, evenly spaced from fraction `begin` to `end`.
class SampledEdge : public BodyRows {
 public:
  SampledEdge(const BodyMotion& motion, double begin, double end, std::size_t steps)
      : motion_(motion), begin_(begin), end_(end), steps_(steps) {}
  std::size_t size() const override { return steps_ + 1; }
  double FractionOf(std::size_t row) const {
    return begin_ + (end_ - begin_) * static_cast<double>(row) / static_cast<double>(steps_);
  }
  void Place(std::size_t row, std::span<Pose> X_WF) const override {
    motion_.Place(FractionOf(row), X_WF);
  }
  // A finer sampling from one of its samples to another.
  SampledEdge Finer(std::size_t first, std::size_t last) const {
    return {motion_, FractionOf(first), FractionOf(last), (last - first) * kFiner};
  }

 private:
  const BodyMotion& motion_;
  const double begin_, end_;
  const std::size_t steps_;
};

// How an edge is sampled.
struct Sampling {
  std::size_t steps = 0;
  bool is_refined = false;  // where a sample is nearer than kNear_m
};

struct Tally {
  std::size_t edges = 0, contacts = 0, undecided = 0, grazing = 0;
  std::size_t false_free = 0, false_contact = 0;
  std::size_t finer_samples = 0;
  double certified_s = 0;

  Tally& operator+=(const Tally& more) {
    edges += more.edges;
    contacts += more.contacts;
    undecided += more.undecided;
    grazing += more.grazing;
    false_free += more.false_free;
    false_contact += more.false_contact;
    finer_samples += more.finer_samples;
    certified_s += more.certified_s;
    return *this;
  }
};

// Compares the verdicts on edges with samples of them.
class MotionChecker {
 public:
  MotionChecker(const WorldSnapshot& world, const QueryBody& body) : world_(world), body_(body) {}

  void Check(std::unique_ptr<BodyMotion> motion, const Sampling& sampling, Tally& tally) const {
    const std::vector<std::unique_ptr<BodyMotion>> edges = Only(std::move(motion));
    const auto start = std::chrono::steady_clock::now();
    const MotionColumns answer = *CheckMotions(world_, body_, edges, {});
    tally.certified_s +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const BodyMotion& edge = *edges.front();
    ++tally.edges;
    switch (answer.verdict.front()) {
      case MotionVerdict::kFree:
        tally.false_free += Meets(SampledEdge(edge, 0, 1, sampling.steps), sampling, tally) ? 1 : 0;
        return;
      case MotionVerdict::kContact: {
        ++tally.contacts;
        const double lo = answer.lo.front(), hi = answer.hi.front();
        const bool meets = Collides(SampledEdge(edge, hi, hi, 1));
        tally.false_contact += !meets || IsTooWide(edge, lo, hi) ? 1 : 0;
        const auto before =
            static_cast<std::size_t>(std::ceil(lo * static_cast<double>(sampling.steps)));
        if (before > 0) {
          tally.false_free += Meets(SampledEdge(edge, 0, lo, before), sampling, tally) ? 1 : 0;
        }
        return;
      }
      case MotionVerdict::kGrazing:
        ++tally.grazing;
        return;
      case MotionVerdict::kUndecided:
      case MotionVerdict::kNotComputed:
      case MotionVerdict::kOutOfLimits:
        ++tally.undecided;
        return;
    }
  }

 private:
  static std::vector<std::unique_ptr<BodyMotion>> Only(std::unique_ptr<BodyMotion> motion) {
    std::vector<std::unique_ptr<BodyMotion>> edges;
    edges.push_back(std::move(motion));
    return edges;
  }

  // True if a bracket is wider than promised although the gap closes faster than kSlow_m per edge.
  bool IsTooWide(const BodyMotion& edge, double lo, double hi) const {
    if (hi - lo <= kMaxBracketWidth * (1 + 1e-9)) return false;
    const PairColumns at = *GetDistances(world_, body_, SampledEdge(edge, lo, hi, 1), {});
    return at.distance_m.front() - at.distance_m.back() > kSlow_m * (hi - lo);
  }

  bool Meets(const SampledEdge& samples, const Sampling& sampling, Tally& tally) const {
    return Collides(samples) || (sampling.is_refined && CollidesNearby(samples, tally));
  }

  // True if a finer sample between near samples, or beside a near one, collides.
  bool CollidesNearby(const SampledEdge& samples, Tally& tally) const {
    const PairColumns near = *GetDistances(world_, body_, samples, {.max_distance_m = kNear_m});
    const auto is_near = [&](std::size_t row) {
      return near.row_begin[row + 1] > near.row_begin[row];
    };
    const std::size_t last = samples.size() - 1;
    for (std::size_t row = 0; row < last; ++row) {
      if (!is_near(row) && !is_near(row + 1)) continue;
      std::size_t end = row + 1;
      while (end < last && (is_near(end) || is_near(end + 1))) ++end;
      const SampledEdge finer = samples.Finer(row, end);
      tally.finer_samples += finer.size();
      if (Collides(finer)) return true;
      row = end;  // the next one is near to nothing
    }
    return false;
  }

  bool Collides(const SampledEdge& samples) const {
    const CollisionColumns columns = *CheckCollisions(world_, body_, samples, {});
    return std::ranges::find(columns.verdict, Verdict::kCollision) != columns.verdict.end();
  }

  const WorldSnapshot& world_;
  const QueryBody& body_;
};

// Runs `check(k, tally)` for all k below `count` on all threads and adds up the tallies.
template <class Check>
Tally OnThreads(std::size_t count, const Check& check) {
  std::array<Tally, kThreads> tallies;
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      for (std::size_t k = t; k < count; k += kThreads) check(k, tallies[t]);
    });
  }
  for (std::thread& thread : threads) thread.join();
  Tally all;
  for (const Tally& tally : tallies) all += tally;
  return all;
}

Tally OfBody(std::size_t edges, const Sampling& sampling, unsigned seed) {
  const auto world = MakeBenchmarkWorld();
  const QueryBody body =
      BodyFromShapes({{.shape = Box{.size_m = {0.1, 0.08, 0.2}}},
                      {.X_FS = MakeTranslation(0, 0, 0.15), .shape = Sphere{.radius_m = 0.05}}});
  const std::vector<Pose> from = RandomPoses(static_cast<int>(edges), seed),
                          to = RandomPoses(static_cast<int>(edges), seed + 1);
  const MotionChecker checker(*world, body);
  return OnThreads(edges, [&](std::size_t k, Tally& tally) {
    // Every other edge is a short one, as a planner's are.
    Pose end = to[k];
    if (k % 2 == 0) {
      end.translation() =
          from[k].translation() + 0.1 * (to[k].translation() - from[k].translation());
      end.linear() = Quaternion(from[k].linear()).slerp(0.1, Quaternion(to[k].linear())).matrix();
    }
    checker.Check(std::make_unique<RigidMotion>(body, from[k], end), sampling, tally);
  });
}

// Edges from near the goal to near the goal, or to anywhere.
Tally OfPanda(const PandaProblems& all) {
  const QueryBody body = BodyFromRobot(*all.robot, RobotScope::kBoth);
  const RobotModel& model = *all.robot->model;
  return OnThreads(kPandaEdges, [&](std::size_t k, Tally& tally) {
    const PandaProblem& problem = all.problems[k % all.problems.size()];
    const std::vector<double> states = RandomStates(all, problem, 4, k);
    const JointRows rows(model, *all.arm, {.base = DefaultVariables(model), .rows = states});
    const std::vector<double> from = rows.State(1), to = rows.State(k % 2 == 0 ? 3 : 2);
    MotionChecker(*problem.world, body)
        .Check(std::make_unique<JointMotion>(model, body, Pose::Identity(), from, to),
               {.steps = kSteps}, tally);
  });
}

void Describe(const std::string& what, const Tally& tally, Report& report) {
  char text[320];
  std::snprintf(text, sizeof(text),
                "%s: %zu edges, %zu in contact, %zu grazing, %zu undecided, %zu false free, %zu "
                "false contact, %zu finer samples; %.1f us an edge",
                what.c_str(), tally.edges, tally.contacts, tally.grazing, tally.undecided,
                tally.false_free, tally.false_contact, tally.finer_samples,
                1e6 * tally.certified_s / static_cast<double>(tally.edges));
  report.Detail(text);
}

}  // namespace

void MeasureMotions(Report& report) {
  Tally all = OfBody(kBodyEdges, {.steps = kSteps}, 51);
  Describe("a body of two shapes among 30, 10 000 samples an edge", all, report);
  const Tally more = OfBody(kMoreBodyEdges, {.steps = kFewSteps, .is_refined = true}, 61);
  Describe("the same, 500 samples an edge, twenty times as many where closer than 5 mm", more,
           report);
  all += more;
  const std::optional<PandaProblems> problems = ReadPandaProblems();
  if (!problems) {
    return report.Fail("motions of the Panda: motion_bench_maker is not in CWM_DATA");
  }
  const Tally panda = OfPanda(*problems);
  Describe("the Panda's meshes, 10 000 samples an edge", panda, report);
  all += panda;
  const auto edges = static_cast<double>(all.edges);
  report.Add(
      {.key = "motion_false",
       .value = static_cast<double>(all.false_free + all.false_contact),
       .unit = "edges",
       .how = "of " + std::to_string(all.edges) +
              " edges: a sample in collision where it was told free, none where it was told "
              "to be in contact, or a bracket too wide; of 100 000 at 500 samples an edge and "
              "twenty times as many where closer than 5 mm, else 10 000"});
  report.Add({.key = "motion_undecided",
              .value = static_cast<double>(all.undecided) / edges,
              .unit = "1",
              .how = "share of the same edges"});
}

}  // namespace cwm::benchmarks
