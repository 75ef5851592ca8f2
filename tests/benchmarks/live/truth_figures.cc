// The world against the truth while things move, vanish and come back by themselves.
#include <algorithm>
#include <cmath>
#include <cstdio>
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

constexpr double kFirstEvent_s = 3;
constexpr int kStillFrames = 60;  // until the world is settled
constexpr double kEventStep_s = 0.5;
constexpr double kAbsence_s = 3;  // from the last thing that vanishes to the first that comes back
constexpr double kFrame_s = 1.0 / 30;
constexpr int kThings = 20;
constexpr int kPairs = kThings / 2;
constexpr int kMaxScenes = 100;
// In place of the time of an event that was never noticed.
constexpr double kNever_ms = 1e4;
constexpr double kMoves_m[] = {0.02, 0.005, 0.002};

// Every thing jumps by 20, then by 5, then by 2 mm; then every other one vanishes, and comes back
// beside its place in the same order. At each time there are events of two things that stand two
// rows apart.
SequenceScript EventfulTable(std::uint64_t seed) {
  SequenceScript script = TableScript({.thing_count = kThings, .seed = seed});
  double time_s = kFirstEvent_s;
  std::vector<Pose> X_WO;
  for (std::size_t i = 0; i < kThings; ++i) {
    X_WO.push_back(script.scene.objects[kFirstThing + i].X_WO);
  }
  const auto add = [&](std::size_t i, auto what) {
    script.events.push_back({.object = kFirstThing + i,
                             .begin_s = time_s,
                             .end_s = time_s + kFrame_s,
                             .what = std::move(what)});
  };
  const auto pairs = [&](int step, auto add_event) {
    for (int i = 0; i < kPairs; i += step) {
      for (const int k : {i, i + kPairs}) add_event(static_cast<std::size_t>(k));
      time_s += kEventStep_s;
    }
  };
  for (const double distance_m : kMoves_m) {
    pairs(1, [&](std::size_t i) {
      const double angle_rad = 2.4 * static_cast<double>(i);  // in all directions
      X_WO[i] =
          MakeTranslation(distance_m * std::cos(angle_rad), distance_m * std::sin(angle_rad), 0) *
          X_WO[i];
      add(i, perception::MoveEvent{.X_WO = X_WO[i]});
    });
  }
  pairs(2, [&](std::size_t i) { add(i, perception::VanishEvent{}); });
  time_s += kAbsence_s;
  pairs(2, [&](std::size_t i) {
    add(i, perception::AppearEvent{.X_WO = MakeTranslation(0.01, 0.01, 0) * X_WO[i]});
  });
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

void AddSamples(const Recording& recording, std::uint64_t seed, SceneSamples& samples,
                Report& report) {
  constexpr std::size_t from = 1;
  const Timeline& timeline = recording.timeline;
  const std::string name = "  seed " + std::to_string(seed) + ": ";
  const std::vector<int> matches = MatchThings(timeline.front());
  char text[160];
  std::snprintf(text, sizeof(text),
                "%td of %zu things are published when the world has settled, with %zu objects; %zu "
                "of %zu frames processed",
                std::ssize(matches) - std::ranges::count(matches, -1), matches.size(),
                timeline.front().published.size(), timeline.size(), recording.answers.size());
  report.Detail(name + text);
  for (const Notice& notice : JudgeNotices(timeline, from)) {
    samples.Add(NameOf(notice), notice.time_s ? 1e3 * *notice.time_s : kNever_ms);
    if (notice.time_s) continue;
    const Moment& moment = timeline[notice.moment];
    std::snprintf(text, sizeof(text),
                  "moment %zu, %.3f s: thing %zu %s, %.0f %% visible, never noticed", notice.moment,
                  moment.stamp_s - timeline.front().stamp_s, notice.thing, NameOf(notice).c_str(),
                  1e2 * moment.truth[notice.thing].visible_share);
    report.Detail(name + text);
  }
  const RestVerdict rests = JudgeRests(timeline);
  for (const double error_m : rests.errors_m) samples.Add("rest_error_mm", 1e3 * error_m);
  samples.Add("jitter", rests.jitter);
  for (const std::string& line : rests.lines) report.Detail(name + line);
  const ChangeVerdict changes = JudgeChanges(timeline, from);
  for (const std::string& line : changes.lines) report.Detail(name + "unfounded, " + line);
  samples.Add("unfounded_added", changes.unfounded.added);
  samples.Add("unfounded_removed", changes.unfounded.removed);
  samples.Add("unfounded_moved", changes.unfounded.moved);
  samples.Add("unfounded_replaced", changes.unfounded.replaced);
  samples.Add("changes", changes.all.sum());
  const IdentityVerdict identity = JudgeIdentity(timeline, from);
  samples.Add("object_frames", static_cast<double>(identity.object_frames));
  samples.Add("switches", identity.switches);
  samples.Add("returns", identity.returns);
  samples.Add("names_kept", identity.names_kept);
  samples.Add("frames", static_cast<double>(timeline.size() - from));
  samples.Add("dropped", static_cast<double>(recording.answers.size() - timeline.size()));
}

bool PlaySeed(std::uint64_t seed, SceneSamples& samples, Report& report) {
  const perception::SequenceRenderer renderer(EventfulTable(seed));
  const SequenceScript& script = renderer.script();
  auto frames = RenderFrames(renderer, 0, 0, static_cast<int>(script.duration_s * 30));
  LiveWorld world;
  if (!world.up()) {
    report.Fail("the server does not come up");
    return false;
  }
  std::vector<TrueFrame> still(frames.begin(), frames.begin() + kStillFrames);
  frames.erase(frames.begin(), frames.begin() + kStillFrames);
  LiveSensor& sensor = world.AddSensor("camera_1", frames.front().frame);
  if (const std::string error = Settle(world, sensor, still); !error.empty()) {
    report.Fail(error);
    return false;
  }
  MoveToPresent(frames);
  const auto recording = Record(world, sensor, script, kFirstThing, frames);
  if (!recording || recording->timeline.empty()) {
    report.Fail("the stream ended: " + sensor.Finish());
    return false;
  }
  AddSamples(*recording, seed, samples, report);
  return true;
}

void AddNotices(const SceneSamples& samples, Report& report) {
  const struct {
    const char* name;
    double limit_ms;
  } kRows[] = {
      {"added", 100}, {"removed", 100}, {"moved_20", 66}, {"moved_5", 100}, {"moved_2", 300}};
  for (const auto& row : kRows) {
    const std::vector<double> times_ms = samples.Of(row.name);
    if (times_ms.empty()) {
      report.Fail(std::string("nothing visible was ") + row.name);
      continue;
    }
    const auto never = std::ranges::count(times_ms, kNever_ms);
    char how[200];
    std::snprintf(how, sizeof(how),
                  "p95 from the stamp of the first frame that shows it to the stamp of the frame "
                  "whose revision does; %zu events, %ld never noticed (10 000 ms), median %.0f ms",
                  times_ms.size(), static_cast<long>(never), Median(times_ms));
    report.Add(WithLimit({.key = std::string("live_notice_ms_") + row.name,
                          .value = Quantile(times_ms, 0.95),
                          .unit = "ms",
                          .how = how},
                         row.limit_ms));
  }
}

}  // namespace

void MeasureLiveTruth(const SceneOptions& options, Report& report) {
  const auto samples =
      MeasureScenes(options, "truth", kMaxScenes, report, [&](int scene, SceneSamples& scenes) {
        return PlaySeed(1 + static_cast<std::uint64_t>(scene), scenes, report);
      });
  if (!samples) return;
  AddNotices(*samples, report);
  const std::vector<double> rest_errors_mm = samples->Of("rest_error_mm");
  if (rest_errors_mm.empty()) {
    report.Fail("no thing was matched at rest before and after it moved");
  } else {
    const std::string how =
        " of the published less the true displacement between two rests, 1 s "
        "after it stopped; " +
        std::to_string(rest_errors_mm.size()) + " rests";
    report.Add(WithLimit({.key = "live_rest_error_mm",
                          .value = Median(rest_errors_mm),
                          .unit = "mm",
                          .how = "median" + how},
                         1));
    report.Add(WithLimit({.key = "live_rest_error_p95_mm",
                          .value = Quantile(rest_errors_mm, 0.95),
                          .unit = "mm",
                          .how = "p95" + how},
                         2));
  }
  report.Add(WithLimit({.key = "live_rest_jitter",
                        .value = samples->Sum("jitter"),
                        .unit = "1",
                        .how = "changes of published poses from 1 s after a thing stopped"},
                       0));
  const double frames = samples->Sum("frames");
  double unfounded = 0;
  std::string kinds;
  for (const char* kind : {"added", "removed", "moved", "replaced"}) {
    const double count = samples->Sum(std::string("unfounded_") + kind);
    unfounded += count;
    kinds += std::string(", ") + kind + " " + std::to_string(static_cast<int>(count));
  }
  char how[300];
  std::snprintf(how, sizeof(how),
                "changes within 1.5 s of no event of their thing, per 1 000 of %.0f frames (%.0f "
                "dropped)%s; of %.0f changes",
                frames, samples->Sum("dropped"), kinds.c_str(), samples->Sum("changes"));
  report.Add(WithLimit({.key = "live_false_changes",
                        .value = 1e3 * unfounded / frames,
                        .unit = "1/1000",
                        .how = how},
                       0.1));
  const double object_frames = samples->Sum("object_frames"), returns = samples->Sum("returns");
  if (object_frames == 0 || returns == 0) {
    return report.Fail("no thing was matched, or none after it came back");
  }
  std::snprintf(how, sizeof(how),
                "changes of the name of a matched thing that did not leave, per 1 000 "
                "object-frames; %.0f in %.0f",
                samples->Sum("switches"), object_frames);
  report.Add(WithLimit({.key = "live_id_switches",
                        .value = 1e3 * samples->Sum("switches") / object_frames,
                        .unit = "1/1000",
                        .how = how},
                       0.05));
  std::snprintf(how, sizeof(how),
                "of the things that came back about 6 s later, 14 mm beside their place, those "
                "with the name that they had; %.0f returns",
                returns);
  report.Add(WithLimit({.key = "live_names_kept",
                        .value = 1e2 * samples->Sum("names_kept") / returns,
                        .unit = "%",
                        .how = how},
                       95, "at least"));
}

}  // namespace cwm::benchmarks
