// Three sensors against the best one of them: what is seen of things, and how well they are fitted.
#include <algorithm>
#include <cmath>
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
constexpr int kScenes = 10;
constexpr int kFrames = 90;

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

// The world after all frames of these sensors, in turn; empty if a stream ends.
std::optional<SceneScore> ScoreWith(const perception::SequenceScript& script,
                                    std::vector<std::vector<TrueFrame>>& frames,
                                    const std::vector<std::size_t>& sensors) {
  LiveWorld world;
  if (!world.up()) return std::nullopt;
  std::vector<LiveSensor*> streams;
  for (const std::size_t i : sensors) {
    streams.push_back(&world.AddSensor(script.sensors[i].name, frames[i].front().frame));
  }
  const double first_s = frames[sensors.front()].front().frame.stamp_s;
  const Pace pace(first_s);
  for (int k = 0; k < kFrames; ++k) {
    for (std::size_t s = 0; s < sensors.size(); ++s) {
      const RecordedFrame& frame = frames[sensors[s]][static_cast<std::size_t>(k)].frame;
      pace.WaitFor(frame.stamp_s);
      if (!streams[s]->SendAndWait(frame)) return std::nullopt;
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

}  // namespace

void MeasureLiveFusion(Report& report) {
  double single_share = 0, fused_share = 0;
  std::vector<double> single_m, fused_m;
  int twice = 0;
  for (int scene = 0; scene < kScenes; ++scene) {
    const perception::SequenceRenderer renderer(
        TableScript({.thing_count = 12,
                     .duration_s = kFrames / 30.0 + 0.1,
                     .seed = 100 + static_cast<std::uint64_t>(scene),
                     .sensor_count = kSensors}));
    const perception::SequenceScript& script = renderer.script();
    std::vector<std::vector<TrueFrame>> frames;
    for (std::size_t i = 0; i < kSensors; ++i) {
      frames.push_back(RenderFrames(renderer, i, 0, kFrames));
    }
    std::optional<SceneScore> best;
    for (std::size_t i = 0; i < kSensors; ++i) {
      MoveToPresent(frames[i]);
      auto score = ScoreWith(script, frames, {i});
      if (!score) return report.Fail("a stream of one sensor ended");
      if (!best || score->observed_share > best->observed_share) best = std::move(score);
    }
    for (std::size_t i = 0; i < kSensors; ++i) MoveToPresent(frames[i]);
    const auto fused = ScoreWith(script, frames, {0, 1, 2});
    if (!fused) return report.Fail("a stream of three sensors ended");
    single_share += best->observed_share / kScenes;
    fused_share += fused->observed_share / kScenes;
    single_m.insert(single_m.end(), best->radius_errors_m.begin(), best->radius_errors_m.end());
    fused_m.insert(fused_m.end(), fused->radius_errors_m.begin(), fused->radius_errors_m.end());
    twice += fused->twice;
  }
  const std::string how = ", " + std::to_string(kScenes) + " tables of 12 things";
  report.Add(WithLimit({.key = "fusion_gain",
                        .value = 1e2 * (fused_share - single_share),
                        .unit = "points",
                        .how = "mean observed share of the first shape with three sensors, " +
                               std::to_string(1e2 * fused_share) +
                               " %, less that with the best "
                               "one alone" +
                               how},
                       25, "at least"));
  if (single_m.empty() || fused_m.empty()) return report.Fail("no round thing was matched");
  report.Add(WithLimit({.key = "fusion_radius_ratio",
                        .value = Median(fused_m) / Median(single_m),
                        .unit = "x",
                        .how = "median error of the radii of balls and cans with three sensors, to "
                               "that with the best one" +
                               how},
                       0.6));
  report.Add(
      WithLimit({.key = "fusion_twice",
                 .value = static_cast<double>(twice),
                 .unit = "1",
                 .how = "objects published at the place of a thing that another one is" + how},
                0));
}

}  // namespace cwm::benchmarks
