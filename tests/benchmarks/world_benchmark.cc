// The costs of changes and of queries as the world grows.
#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "collision/query/query.h"
#include "tests/benchmarks/benchmark_world.h"
#include "tests/benchmarks/benchmarks.h"

namespace cwm::benchmarks {
namespace {

using SnapshotPtr = std::shared_ptr<const collision::WorldSnapshot>;

double Elapsed_us(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start)
      .count();
}

struct ChangeCost {
  double median_us = 0;
  double bytes = 0;  // that a kept revision adds
};

// Moves one object after another to places within its world; all revisions are kept.
ChangeCost MoveOneByOne(const SnapshotPtr& world) {
  constexpr int kMoves = 4000;
  const std::vector<Pose> poses = RandomPoses(kMoves, 11);
  std::vector<SnapshotPtr> kept = {world};
  std::vector<double> times_us;
  const std::size_t before = mallinfo2().uordblks;
  for (int i = 0; i < kMoves; ++i) {
    const auto count = world->objects().size();
    const std::string& name = world->objects()[(7919 * static_cast<std::size_t>(i)) % count]->name;
    const collision::Change move{.what = collision::MoveObject{name, poses[i]},
                                 .expected_object_revision = {}};
    const auto start = std::chrono::steady_clock::now();
    auto next = collision::Apply(kept.back(), {&move, 1});
    times_us.push_back(Elapsed_us(start));
    kept.push_back(*std::move(next));
  }
  const double bytes = static_cast<double>(mallinfo2().uordblks - before) / kMoves;
  return {Median(times_us), bytes};
}

// Five moves at once, as a what-if overlay: applied to a snapshot that is not kept.
double OverlayCost_us(const SnapshotPtr& world) {
  constexpr int kOverlays = 2000;
  constexpr std::size_t kChanges = 5;
  const std::vector<Pose> poses = RandomPoses(kOverlays * kChanges, 13);
  std::vector<double> times_us;
  for (std::size_t i = 0; i < kOverlays; ++i) {
    std::vector<collision::Change> changes;
    for (std::size_t k = 0; k < kChanges; ++k) {
      const std::size_t at = (7919 * (kChanges * i + k)) % world->objects().size();
      changes.push_back(
          {.what = collision::MoveObject{world->objects()[at]->name, poses[kChanges * i + k]},
           .expected_object_revision = {}});
    }
    const auto start = std::chrono::steady_clock::now();
    const auto with_overlay = collision::Apply(world, changes);
    times_us.push_back(Elapsed_us(start));
    if (!with_overlay.ok()) return std::numeric_limits<double>::quiet_NaN();
  }
  return Median(times_us);
}

double DistancesPerSecond(const SnapshotPtr& world) {
  const collision::QueryBody gripper =
      collision::BodyFromShapes({{.shape = Box{.size_m = {0.1, 0.08, 0.2}}}});
  const std::vector<Pose> poses = RandomPoses(20'000, 7);
  double best_us = 1e300;
  for (int round = 0; round < 5; ++round) {
    const auto start = std::chrono::steady_clock::now();
    if (!collision::GetDistances(*world, gripper, poses, {}).ok()) return 0;
    best_us = std::min(best_us, Elapsed_us(start));
  }
  return 1e6 * static_cast<double>(poses.size()) / best_us;
}

// A world with rules: allowances and margins in turn between everything ("*") and each of `count`
// objects.
SnapshotPtr WithRules(const SnapshotPtr& world, std::size_t count) {
  std::vector<collision::Change> changes;
  for (std::size_t i = 0; i < count; ++i) {
    const collision::NamedPair pair = {{"*"}, {world->objects()[i]->name}};
    collision::Change change{.what = collision::AllowCollision{.pair = pair},
                             .expected_object_revision = {}};
    if (i % 2 == 0) change.what = collision::SetPairMargin{.pair = pair, .margin_m = 0.01};
    changes.push_back(std::move(change));
  }
  return *collision::Apply(world, changes);
}

// The cost of a query of one row: the fixed cost of a call.
double CallCost_us(const SnapshotPtr& world) {
  const collision::QueryBody gripper =
      collision::BodyFromShapes({{.shape = Box{.size_m = {0.1, 0.08, 0.2}}}});
  std::vector<double> times_us;
  for (const Pose& pose : RandomPoses(4'000, 17)) {
    const auto start = std::chrono::steady_clock::now();
    if (!collision::CheckCollisions(*world, gripper, {&pose, 1}, {}).ok()) return 0;
    times_us.push_back(Elapsed_us(start));
  }
  return Median(times_us);
}

// The cost of rules for a query that all of them apply to.
void MeasureRules(Report& report) {
  constexpr std::size_t kRules = 400;
  const SnapshotPtr plain = MakeLargeWorld(1'000), ruled = WithRules(plain, kRules);
  const double plain_us = CallCost_us(plain), ruled_us = CallCost_us(ruled);
  const double share = DistancesPerSecond(ruled) / DistancesPerSecond(plain);
  char text[160];
  std::snprintf(
      text, sizeof(text),
      "  1000 objects: a call of one row %.2f us, with %zu rules %.2f us; distances/s of a "
      "batch at %.2f of those without",
      plain_us, kRules, ruled_us, share);
  report.Detail(text);
  report.Add({.key = "rules_call_us",
              .value = ruled_us - plain_us,
              .unit = "us",
              .how = "what 400 rules of pairs add to a question of one row, median of 4 000"});
}

}  // namespace

void MeasureWorlds(Report& report) {
  report.Detail("Worlds in process, one thread: a move of one object, and the nearest object:");
  double distances_per_s_100 = 0;
  for (const int count : {30, 100, 1'000, 2'000, 10'000}) {
    const SnapshotPtr world = MakeLargeWorld(count);
    const double distances_per_s = DistancesPerSecond(world);
    if (count == 100) distances_per_s_100 = distances_per_s;
    const ChangeCost cost = MoveOneByOne(world);
    char text[160];
    std::snprintf(text, sizeof(text),
                  "  %6d objects %8.2f us a move %8.0f bytes a revision %10.0f distances/s", count,
                  cost.median_us, cost.bytes, distances_per_s);
    report.Detail(text);
    const std::string size = std::to_string(count);
    report.Add({.key = "change_us_" + size,
                .value = cost.median_us,
                .unit = "us",
                .how = "Apply of a move of one object among " + size + ", median of 4 000"});
    if (count == 1'000) {
      report.Add({.key = "overlay_us",
                  .value = OverlayCost_us(world),
                  .unit = "us",
                  .how = "five moves applied to a snapshot of 1 000 objects, median of 2 000"});
    }
    if (count == 10'000) {
      report.Add({.key = "nearest_growth",
                  .value = distances_per_s_100 / distances_per_s,
                  .unit = "",
                  .how = "time for the nearest of 10 000 objects over that for the nearest of 100, "
                         "equally dense; logarithmic would be 2"});
      report.Add({.key = "change_bytes_" + size,
                  .value = cost.bytes,
                  .unit = "B",
                  .how = "heap that each of 4 000 kept revisions adds, one move each"});
    }
    if (count == 2'000 || count == 10'000) {
      report.Add({.key = "distances_per_s_" + size,
                  .value = distances_per_s,
                  .unit = "1/s",
                  .how = "nearest object to a box at random poses, one thread, best of 5"});
    }
  }
  MeasureRules(report);
}

}  // namespace cwm::benchmarks
