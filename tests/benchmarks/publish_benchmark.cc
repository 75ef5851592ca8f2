// The cost of publishing a change of one object, with the history kept and every engine ready to
// answer.
#include <malloc.h>

#include <chrono>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "collision/query/query.h"
#include "server/core/world.h"
#include "tests/benchmarks/benchmark_world.h"
#include "tests/benchmarks/benchmarks.h"

namespace cwm::benchmarks {
namespace {

using collision::EngineChoice;
using server::SnapshotPtr;

constexpr int kMoves = 4'000;

double Elapsed_us(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start)
      .count();
}

using Now = std::function<server::Clock::time_point()>;

// A world of the application.
std::shared_ptr<server::World> PublishedWorld(int count, const server::Retention& retention,
                                              const Now& now = server::Clock::now) {
  auto world = std::make_shared<server::World>("bench", "bench", retention, now);
  std::vector<collision::Change> changes;
  const SnapshotPtr large = MakeLargeWorld(count);
  for (const collision::WorldObjectPtr& object : large->objects()) {
    collision::PutObject put;
    put.name = object->name;
    put.X_WO = object->X_WO;
    put.geometry = object->geometry;
    changes.push_back({.what = std::move(put), .expected_object_revision = {}});
  }
  if (!world->Apply(changes, {}).ok()) return nullptr;
  return world;
}

// The verdicts of every engine, one after the other; empty if one of them refuses.
std::vector<std::uint8_t> Verdicts(const collision::WorldSnapshot& world) {
  const collision::QueryBody gripper =
      collision::BodyFromShapes({{.shape = Box{.size_m = {0.1, 0.08, 0.2}}}});
  const std::vector<Pose> poses = RandomPoses(500, 23);
  std::vector<std::uint8_t> all;
  for (const EngineChoice engine :
       {EngineChoice::kExact, EngineChoice::kFcl, EngineChoice::kBullet}) {
    collision::QueryOptions options;
    options.engine = engine;
    const auto answers = collision::CheckCollisions(world, gripper, poses, options);
    if (!answers.ok()) return {};
    for (const auto verdict : answers->verdict) all.push_back(static_cast<std::uint8_t>(verdict));
  }
  return all;
}

void MeasureAt(int count, Report& report) {
  const std::string size = std::to_string(count);
  server::Retention all;  // every revision of a run
  all.exact_snapshots = kMoves + 16;
  const std::shared_ptr<server::World> world = PublishedWorld(count, all);
  if (world == nullptr) return report.Fail("a world of " + size + " objects could not be put");
  const SnapshotPtr first = world->Snapshot();
  const std::vector<std::uint8_t> verdicts_before = Verdicts(*first);

  const std::vector<Pose> poses = RandomPoses(kMoves, 11);
  std::vector<double> times_us;
  times_us.reserve(kMoves);
  const std::size_t heap_before = mallinfo2().uordblks;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const std::size_t at = (7919 * i) % first->objects().size();
    const collision::Change move{
        .what = collision::MoveObject{first->objects()[at]->name, poses[i]},
        .expected_object_revision = {}};
    const auto start = std::chrono::steady_clock::now();
    const auto published = world->Apply({&move, 1}, {});
    times_us.push_back(Elapsed_us(start));
    if (!published.ok()) return report.Fail("a move was refused");
  }
  const double bytes = static_cast<double>(mallinfo2().uordblks - heap_before) / kMoves;

  // A pinned revision answers as before, and the latest one answers by every engine.
  if (verdicts_before.empty() || Verdicts(*world->Snapshot()).empty() ||
      Verdicts(**world->At(server::Exactly{first->revision()}, {}, {})) != verdicts_before) {
    return report.Fail("an engine refused to answer, or a pinned revision answered otherwise");
  }

  // The cost of copying the list of objects alone, for comparison.
  std::vector<collision::WorldObjectPtr> list(first->objects().begin(), first->objects().end());
  std::vector<double> copies_us;
  for (int i = 0; i < 200; ++i) {
    const auto start = std::chrono::steady_clock::now();
    const std::vector<collision::WorldObjectPtr> copy = list;
    copies_us.push_back(Elapsed_us(start));
    list.front() = copy.back();
  }
  const double median_us = Median(times_us), copy_us = Median(copies_us);
  char text[160];
  std::snprintf(text, sizeof(text), "  %6d objects %8.2f us a move %8.0f bytes a revision kept",
                count, median_us, bytes);
  report.Detail(text);
  report.Add({.key = "publish_us_" + size,
              .value = median_us,
              .unit = "us",
              .baseline = "a copy of the list of objects",
              .baseline_value = copy_us,
              .ratio = copy_us / median_us,
              .how = "World::Apply of a move among " + size +
                     " objects to a random place, history kept, median of 4 000"});
  report.Add({.key = "publish_bytes_" + size,
              .value = bytes,
              .unit = "B",
              .how = "heap that each of those revisions adds, snapshot and event"});
}

// The cost in a world that follows a sensor for minutes: each revision thins those before.
void MeasureThinned(int count, Report& report) {
  const std::string size = std::to_string(count);
  constexpr std::size_t kWarmUp = 1'500;
  auto time = std::make_shared<server::Clock::time_point>(server::Clock::now());
  const std::shared_ptr<server::World> world =
      PublishedWorld(count, server::Retention(), [time] { return *time; });
  if (world == nullptr) return report.Fail("a world of " + size + " objects could not be put");
  const SnapshotPtr first = world->Snapshot();
  const std::vector<Pose> poses = RandomPoses(kMoves + kWarmUp, 12);
  std::vector<double> times_us;
  times_us.reserve(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    *time += std::chrono::microseconds(33'333);
    const std::size_t at = (7919 * i) % first->objects().size();
    const collision::Change move{
        .what = collision::MoveObject{first->objects()[at]->name, poses[i]},
        .expected_object_revision = {}};
    const auto start = std::chrono::steady_clock::now();
    const auto published = world->Apply({&move, 1}, {});
    times_us.push_back(Elapsed_us(start));
    if (!published.ok()) return report.Fail("a move was refused");
  }
  times_us.erase(times_us.begin(), times_us.begin() + kWarmUp);
  report.Add({.key = "publish_thinned_us_" + size,
              .value = Median(times_us),
              .unit = "us",
              .how = "the same at 30 revisions a second with the default history"});
}

}  // namespace

void MeasurePublishing(Report& report) {
  report.Detail("One object's change published, in process, one thread:");
  for (const int count : {200, 10'000}) {
    MeasureAt(count, report);
    MeasureThinned(count, report);
  }
}

}  // namespace cwm::benchmarks
