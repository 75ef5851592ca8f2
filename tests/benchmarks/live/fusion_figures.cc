// Three sensors against the best one of them: what is seen of things, and how well they are fitted.
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

constexpr std::size_t kSensors = 3;
constexpr int kMaxScenes = 500;
constexpr int kFrames = 45;
constexpr std::uint64_t kFirstSeed = 100;

struct SceneScore {
  double observed_share = 0;  // mean over the matched things
  std::vector<double> radius_errors_m = {};
  int twice = 0;  // further objects at the place of a matched thing
  int matched = 0;
};

// The radius of a thing of one round part, at its middle.
std::optional<double> TrueRadius_m(const perception::SimulatedObject& thing) {
  const Shape& shape = thing.parts.front().shape;
  if (const auto* sphere = std::get_if<Sphere>(&shape)) return sphere->radius_m;
  if (const auto* cylinder = std::get_if<Cylinder>(&shape)) return cylinder->radius_m;
  return std::nullopt;
}

std::optional<double> PublishedRadius_m(const v1::Object& object) {
  if (object.shapes_size() == 0) return std::nullopt;
  const v1::ShapePart& part = object.shapes(0);
  if (part.has_sphere()) return part.sphere().radius_m();
  if (part.has_cylinder()) return part.cylinder().radius_m();
  return std::nullopt;
}

SceneScore ScoreOf(const perception::SequenceScript& script, const Moment& moment,
                   const PublishedObjects& published) {
  SceneScore score;
  const std::vector<int> matches = MatchThings(moment);
  for (std::size_t t = 0; t < matches.size(); ++t) {
    if (matches[t] < 0) continue;
    const v1::Object& object =
        *published.at(moment.published[static_cast<std::size_t>(matches[t])].name);
    ++score.matched;
    if (object.shapes_size() > 0)
      score.observed_share += object.shapes(0).fit().observed_fraction();
    const auto radius_m = PublishedRadius_m(object);
    const auto true_m = TrueRadius_m(script.scene.objects[kFirstThing + t]);
    if (radius_m && true_m) score.radius_errors_m.push_back(std::abs(*radius_m - *true_m));
    for (std::size_t p = 0; p < moment.published.size(); ++p) {
      const bool is_there = (moment.published[p].center_W - moment.truth[t].center_W).norm() <
                            0.5 * moment.truth[t].diagonal_m;
      score.twice += is_there && static_cast<int>(p) != matches[t];
    }
  }
  if (score.matched > 0) score.observed_share /= score.matched;
  return score;
}

// The world after all frames of these sensors, in turn; empty if a stream ends. What a frame begins
// is interpreted before the next one.
std::optional<SceneScore> ScoreWith(const perception::SequenceScript& script,
                                    const std::vector<std::vector<TrueFrame>>& frames,
                                    const std::vector<std::size_t>& sensors) {
  LiveWorld world;
  if (!world.up()) return std::nullopt;
  std::vector<LiveSensor*> streams;
  for (const std::size_t i : sensors) {
    streams.push_back(&world.AddSensor(script.sensors[i].name, frames[i].front().frame));
  }
  for (std::size_t k = 0; k < kFrames; ++k) {
    for (std::size_t s = 0; s < sensors.size(); ++s) {
      if (!SendAndSettle(world, *streams[s], frames[sensors[s]][k].frame)) return std::nullopt;
    }
  }
  const std::int64_t revision = world.Revision();
  if (!world.published().WaitFor(revision)) return std::nullopt;
  const PublishedObjects published = world.published().At(revision);
  const TrueFrame& last = frames[sensors.front()][kFrames - 1];
  return ScoreOf(script,
                 {.truth = TruthOf(script, kFirstThing, last), .published = ThingsOf(published)},
                 published);
}

// One table, seen by each sensor alone and by all of them.
bool MeasureTable(int scene, SceneSamples& samples, Report& report) {
  const perception::SequenceRenderer renderer(
      TableScript({.thing_count = 12,
                   .duration_s = kFrames / 30.0 + 0.1,
                   .seed = kFirstSeed + static_cast<std::uint64_t>(scene),
                   .sensor_count = kSensors}));
  const perception::SequenceScript& script = renderer.script();
  std::vector<std::vector<TrueFrame>> frames;
  for (std::size_t i = 0; i < kSensors; ++i) {
    frames.push_back(RenderFrames(renderer, i, 0, kFrames));
  }
  MoveToPast(frames);
  std::optional<SceneScore> best;
  for (std::size_t i = 0; i < kSensors; ++i) {
    auto score = ScoreWith(script, frames, {i});
    if (!score) {
      report.Fail("a stream of one sensor ended");
      return false;
    }
    if (!best || score->observed_share > best->observed_share) best = std::move(score);
  }
  const auto fused = ScoreWith(script, frames, {0, 1, 2});
  if (!fused) {
    report.Fail("a stream of three sensors ended");
    return false;
  }
  samples.Add("single_share", best->observed_share);
  samples.Add("fused_share", fused->observed_share);
  samples.Add("single_matched", best->matched);
  samples.Add("fused_matched", fused->matched);
  for (const double error_m : best->radius_errors_m) samples.Add("single_radius_m", error_m);
  for (const double error_m : fused->radius_errors_m) samples.Add("fused_radius_m", error_m);
  samples.Add("single_twice", best->twice);
  samples.Add("fused_twice", fused->twice);
  if (fused->twice > 0) {
    report.Detail("  seed " + std::to_string(kFirstSeed + static_cast<std::uint64_t>(scene)) +
                  ": " + std::to_string(fused->twice) + " objects where another one is");
  }
  return true;
}

}  // namespace

void MeasureLiveFusion(const SceneOptions& options, Report& report) {
  const auto samples = MeasureScenes(
      options, "fusion", kMaxScenes, report,
      [&](int scene, SceneSamples& scenes) { return MeasureTable(scene, scenes, report); });
  if (!samples) return;
  const int count = samples->scene_count();
  const std::string how = ", " + std::to_string(count) + " tables of 12 things";
  const double single = samples->Sum("single_share") / count;
  const double fused = samples->Sum("fused_share") / count;
  char text[200];
  std::snprintf(text, sizeof(text),
                "mean observed share of the first shape with three sensors, %.1f %%, less that "
                "with the best one alone, %.1f %%; things found %.0f and %.0f",
                1e2 * fused, 1e2 * single, samples->Sum("fused_matched"),
                samples->Sum("single_matched"));
  report.Add(WithLimit(
      {.key = "fusion_gain", .value = 1e2 * (fused - single), .unit = "points", .how = text + how},
      25, "at least"));
  const std::vector<double> single_m = samples->Of("single_radius_m");
  const std::vector<double> fused_m = samples->Of("fused_radius_m");
  if (single_m.empty() || fused_m.empty()) return report.Fail("no round thing was matched");
  std::snprintf(text, sizeof(text),
                "median error of the radii of balls and cans with three sensors, %.2f mm of %zu, "
                "to that with the best one, %.2f mm of %zu",
                1e3 * Median(fused_m), fused_m.size(), 1e3 * Median(single_m), single_m.size());
  report.Add(WithLimit({.key = "fusion_radius_ratio",
                        .value = Median(fused_m) / Median(single_m),
                        .unit = "x",
                        .how = text + how},
                       0.6));
  report.Add(
      WithLimit({.key = "fusion_twice",
                 .value = samples->Sum("fused_twice"),
                 .unit = "1",
                 .how = "objects published at the place of a thing that another one is, "
                        "with three sensors; with the best one alone " +
                        std::to_string(static_cast<int>(samples->Sum("single_twice"))) + how},
                0));
}

}  // namespace cwm::benchmarks
