// The world against the truth while things move, vanish and come back by themselves.
#include <algorithm>
#include <cstdio>
#include <map>
#include <string>
#include <utility>

#include "tests/benchmarks/live/judge.h"
#include "tests/benchmarks/live/live_benchmarks.h"
#include "tests/benchmarks/live/live_scenes.h"
#include "tests/benchmarks/live/timeline_recorder.h"
#include "tests/benchmarks/server/server_benchmarks.h"

namespace cwm::benchmarks {
namespace {

using perception::SequenceScript;

constexpr double kFirstEvent_s = 4;  // the world is settled
constexpr double kEventStep_s = 0.5;
constexpr double kFrame_s = 1.0 / 30;
constexpr int kThings = 20;
constexpr int kTaken = 10;  // every other thing
// In place of the time of an event that was never noticed.
constexpr double kNever_ms = 1e4;
constexpr double kMoves_m[] = {0.02, 0.005, 0.002};

// Every thing jumps by 20, then by 5, then by 2 mm; then every other one vanishes, and comes back
// beside its place in the same order.
SequenceScript EventfulTable(std::uint64_t seed) {
  SequenceScript script = TableScript({.thing_count = kThings, .seed = seed});
  double time_s = kFirstEvent_s;
  std::vector<Pose> X_WO;
  for (int i = 0; i < kThings; ++i) {
    X_WO.push_back(script.scene.objects[kFirstThing + static_cast<std::size_t>(i)].X_WO);
  }
  const auto add = [&](int i, auto what) {
    script.events.push_back({.object = kFirstThing + static_cast<std::size_t>(i),
                             .begin_s = time_s,
                             .end_s = time_s + kFrame_s,
                             .what = std::move(what)});
    time_s += kEventStep_s;
  };
  for (const double distance_m : kMoves_m) {
    for (int i = 0; i < kThings; ++i) {
      Pose& pose = X_WO[static_cast<std::size_t>(i)];
      const double angle_rad = 2.4 * i;  // in all directions
      pose =
          MakeTranslation(distance_m * std::cos(angle_rad), distance_m * std::sin(angle_rad), 0) *
          pose;
      add(i, perception::MoveEvent{.X_WO = pose});
    }
  }
  for (int i = 0; i < kTaken; ++i) add(2 * i, perception::VanishEvent{});
  for (int i = 0; i < kTaken; ++i) {
    add(2 * i, perception::AppearEvent{.X_WO = MakeTranslation(0.01, 0.01, 0) *
                                               X_WO[static_cast<std::size_t>(2 * i)]});
  }
  std::ranges::stable_sort(script.events, {}, &perception::ObjectEvent::begin_s);
  script.duration_s = time_s + 2;
  return script;
}

// "added", "removed", "moved_20" and so on.
std::string NameOf(const Notice& notice) {
  switch (notice.kind) {
    case Notice::Kind::kAdded:
      return "added";
    case Notice::Kind::kRemoved:
      return "removed";
    case Notice::Kind::kMoved:
      break;
  }
  return "moved_" + std::to_string(static_cast<int>(std::lround(1e3 * notice.distance_m)));
}

struct Sums {
  std::map<std::string, std::vector<double>> notice_ms;
  std::vector<double> rest_errors_mm;
  int jitter = 0;
  ChangeVerdict changes;
  IdentityVerdict identity;
  std::size_t frames = 0;
};

void Add(const Recording& recording, std::uint64_t seed, Sums& sums, Report& report) {
  constexpr std::size_t from = 1;
  const Timeline& timeline = recording.timeline;
  if (timeline.empty()) return;
  const std::vector<int> matches = MatchThings(timeline.front());
  report.Detail(
      "  seed " + std::to_string(seed) + ": " +
      std::to_string(matches.size() - static_cast<std::size_t>(std::ranges::count(matches, -1))) +
      " of " + std::to_string(matches.size()) +
      " things are published when the world has settled, with " +
      std::to_string(timeline.front().published.size()) + " objects");
  for (const Notice& notice : JudgeNotices(timeline, from)) {
    sums.notice_ms[NameOf(notice)].push_back(notice.time_s ? 1e3 * *notice.time_s : kNever_ms);
  }
  const RestVerdict rests = JudgeRests(timeline);
  for (const double error_m : rests.errors_m) sums.rest_errors_mm.push_back(1e3 * error_m);
  sums.jitter += rests.jitter;
  const ChangeVerdict changes = JudgeChanges(timeline, from);
  for (const std::string& line : changes.lines)
    report.Detail("  unfounded, seed " + std::to_string(seed) + ": " + line);
  const auto add = [](const ChangeCounts& more, ChangeCounts& sum) {
    sum.added += more.added;
    sum.removed += more.removed;
    sum.moved += more.moved;
    sum.replaced += more.replaced;
  };
  add(changes.all, sums.changes.all);
  add(changes.unfounded, sums.changes.unfounded);
  const IdentityVerdict identity = JudgeIdentity(timeline, from);
  sums.identity.object_frames += identity.object_frames;
  sums.identity.switches += identity.switches;
  sums.identity.returns += identity.returns;
  sums.identity.names_kept += identity.names_kept;
  sums.frames += timeline.size() - std::min(from, timeline.size());
}

bool PlaySeed(std::uint64_t seed, Sums& sums, Report& report) {
  constexpr int kSecond = 30;
  const perception::SequenceRenderer renderer(EventfulTable(seed));
  const SequenceScript& script = renderer.script();
  auto frames = RenderFrames(renderer, 0, 0, static_cast<int>(script.duration_s * 30));
  LiveWorld world;
  if (!world.up()) {
    report.Fail("the server does not come up");
    return false;
  }
  std::vector<TrueFrame> still(frames.begin(), frames.begin() + 2 * kSecond);
  frames.erase(frames.begin(), frames.begin() + 2 * kSecond);
  LiveSensor& sensor = world.AddSensor("camera_1", frames.front().frame);
  if (const std::string error = Settle(world, sensor, still); !error.empty()) {
    report.Fail(error);
    return false;
  }
  MoveToPresent(frames);
  const auto recording = Record(world, sensor, script, kFirstThing, frames);
  if (!recording) {
    report.Fail("the stream ended: " + sensor.Finish());
    return false;
  }
  Add(*recording, seed, sums, report);
  return true;
}

void AddNotices(const Sums& sums, Report& report) {
  const struct {
    const char* name;
    double limit_ms;
  } kRows[] = {
      {"added", 100}, {"removed", 100}, {"moved_20", 66}, {"moved_5", 100}, {"moved_2", 300}};
  for (const auto& row : kRows) {
    const auto times = sums.notice_ms.find(row.name);
    if (times == sums.notice_ms.end()) {
      report.Fail(std::string("nothing visible was ") + row.name);
      continue;
    }
    const auto never = std::ranges::count(times->second, kNever_ms);
    char how[200];
    std::snprintf(how, sizeof(how),
                  "p95 from the stamp of the first frame that shows it to the stamp of the frame "
                  "whose revision does; %zu events, %ld never noticed (10 000 ms), median %.0f ms",
                  times->second.size(), static_cast<long>(never), Median(times->second));
    report.Add(WithLimit({.key = std::string("live_notice_ms_") + row.name,
                          .value = Quantile(times->second, 0.95),
                          .unit = "ms",
                          .how = how},
                         row.limit_ms));
  }
}

}  // namespace

void MeasureLiveTruth(Report& report) {
  Sums sums;
  for (const std::uint64_t seed : {1, 2}) {
    if (!PlaySeed(seed, sums, report)) return;
  }
  AddNotices(sums, report);
  if (sums.rest_errors_mm.empty()) {
    report.Fail("no thing was matched at rest before and after it moved");
  } else {
    const std::string how =
        " of the published less the true displacement between two rests, 1 s "
        "after it stopped; " +
        std::to_string(sums.rest_errors_mm.size()) + " rests";
    report.Add(WithLimit({.key = "live_rest_error_mm",
                          .value = Median(sums.rest_errors_mm),
                          .unit = "mm",
                          .how = "median" + how},
                         1));
    report.Add(WithLimit({.key = "live_rest_error_p95_mm",
                          .value = Quantile(sums.rest_errors_mm, 0.95),
                          .unit = "mm",
                          .how = "p95" + how},
                         2));
  }
  report.Add(WithLimit({.key = "live_rest_jitter",
                        .value = static_cast<double>(sums.jitter),
                        .unit = "1",
                        .how = "changes of published poses from 1 s after a thing stopped"},
                       0));
  const ChangeCounts& unfounded = sums.changes.unfounded;
  char how[300];
  std::snprintf(how, sizeof(how),
                "changes within 1.5 s of no event of their thing, per 1 000 of %zu frames: added "
                "%d, removed %d, moved %d, replaced %d of %d changes",
                sums.frames, unfounded.added, unfounded.removed, unfounded.moved,
                unfounded.replaced, sums.changes.all.sum());
  report.Add(WithLimit({.key = "live_false_changes",
                        .value = 1e3 * unfounded.sum() / static_cast<double>(sums.frames),
                        .unit = "1/1000",
                        .how = how},
                       0.1));
  const IdentityVerdict& identity = sums.identity;
  if (identity.object_frames == 0 || identity.returns == 0) {
    return report.Fail("no thing was matched, or none after it came back");
  }
  report.Add(WithLimit(
      {.key = "live_id_switches",
       .value = 1e3 * identity.switches / static_cast<double>(identity.object_frames),
       .unit = "1/1000",
       .how =
           "changes of the name of a matched thing that did not leave, per 1 000 object-frames; " +
           std::to_string(identity.switches) + " in " + std::to_string(identity.object_frames)},
      0.05));
  report.Add(WithLimit({.key = "live_names_kept",
                        .value = 1e2 * identity.names_kept / identity.returns,
                        .unit = "%",
                        .how = "of the things that came back 5 s later, 14 mm beside their place, "
                               "those with the name that they had; " +
                               std::to_string(identity.returns) + " returns"},
                       95, "at least"));
}

}  // namespace cwm::benchmarks
