// Real sequences in which nothing moves, and rendered things pasted into one of them.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <thread>
#include <utility>

#include "clients/cpp/cloud_upload.h"
#include "perception/simulation/random_draws.h"
#include "tests/benchmarks/live/judge.h"
#include "tests/benchmarks/live/live_benchmarks.h"
#include "tests/benchmarks/live/live_scenes.h"
#include "tests/benchmarks/live/real_frames.h"
#include "tests/benchmarks/live/timeline_recorder.h"
#include "tests/benchmarks/server/server_benchmarks.h"

namespace cwm::benchmarks {
namespace {

using perception::SequenceScript;

constexpr double kRate_hz = 30;
constexpr int kInserted = 34;     // three events of each
constexpr int kMaxMoments = 3;    // within which an event must be told
constexpr double kMove_m = 0.06;  // of an inserted thing

// Real frames have no truth: it stays empty.
TrueFrame Untold(RecordedFrame frame) { return {.frame = std::move(frame)}; }

// The pose that the server estimates from a frame: z up, the origin at the sensor. Makes no world.
absl::StatusOr<Pose> EstimatePose(const client::Connection& connection,
                                  const RecordedFrame& frame) {
  formats::CloudFile cloud;
  cloud.width = frame.width;
  cloud.height = frame.height;
  for (const char* name : {"x", "y", "z"}) cloud.fields.push_back({.name = name});
  cloud.point_step = formats::AssignOffsets(cloud.fields);
  for (std::size_t pixel = 0; pixel < frame.depth.size() / 2; ++pixel) {
    Eigen::Vector3f p_C = PointInWorld(frame, pixel).cast<float>();  // its X_WC is the identity
    if (frame.at(pixel) == 0) p_C.setConstant(NAN);
    cloud.bytes.append(reinterpret_cast<const char*>(p_C.data()), cloud.point_step);
  }
  v1::IngestCloudHeader header;
  header.set_sensor("camera_1");
  header.set_mode(v1::INGEST_MODE_SEGMENT_ONLY);
  const auto response = client::IngestCloud(connection, header, cloud);
  if (!response.ok()) return response.status();
  return PoseOf(response->x_world_sensor());
}

// Frames of the sequence in turn, forwards and backwards, each with its own stamp.
RecordedFrame NthFrame(const std::vector<RecordedFrame>& frames, int n) {
  const int period = 2 * static_cast<int>(frames.size()) - 2;
  const int phase = n % period;
  RecordedFrame frame = frames[static_cast<std::size_t>(std::min(phase, period - phase))];
  frame.stamp_s = n / kRate_hz;
  return frame;
}

// A place for the foot of a thing on something level that the frame shows, at most 2 m away: the
// points around it have one height. Empty after too many attempts.
std::optional<Vector3> FindPlace(const RecordedFrame& frame, perception::RandomDraws& draws) {
  constexpr int kAttempts = 20'000, kBorder_px = 90, kHalf_px = 18, kStep_px = 6;
  constexpr double kMaxDepth_m = 2, kLevel_m = 0.015;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const int u = kBorder_px + draws.Below(frame.width - 2 * kBorder_px);
    const int v = kBorder_px + draws.Below(frame.height - 2 * kBorder_px);
    const auto pixel_at = [&](int du, int dv) {
      return static_cast<std::size_t>((v + dv) * frame.width + u + du);
    };
    const Vector3 p_W = PointInWorld(frame, pixel_at(0, 0));
    if (frame.at(pixel_at(0, 0)) == 0 || frame.at(pixel_at(0, 0)) * kDepthUnit_m > kMaxDepth_m) {
      continue;
    }
    bool is_level = true;
    for (int dv = -kHalf_px; dv <= kHalf_px && is_level; dv += kStep_px) {
      for (int du = -kHalf_px; du <= kHalf_px && is_level; du += kStep_px) {
        const std::size_t pixel = pixel_at(du, dv);
        is_level =
            frame.at(pixel) != 0 && std::abs(PointInWorld(frame, pixel).z() - p_W.z()) <= kLevel_m;
      }
    }
    if (is_level) return p_W;
  }
  return std::nullopt;
}

// Things that are put onto level places of the frame one after the other; each is moved a second
// later by 6 cm within 0.2 s, and taken away after another second.
SequenceScript InsertedThings(const RecordedFrame& frame, double begin_s) {
  constexpr double kStay_s = 1, kMoveTime_s = 0.2, kPause_s = 0.8;
  const SequenceScript source = TableScript({.thing_count = 20, .seed = 7});
  SequenceScript script;
  script.scene.objects.clear();
  perception::RandomDraws draws(39, 1);
  double time_s = begin_s;
  for (std::size_t i = 0; i < kInserted; ++i) {
    const auto place = FindPlace(frame, draws);
    if (!place) break;
    const std::size_t shape = kFirstThing + i % (source.scene.objects.size() - kFirstThing);
    perception::SimulatedObject thing = source.scene.objects[shape];
    thing.name = "inserted_" + std::to_string(i);
    const double angle_rad = draws.Uniform(0, 6.28);
    thing.X_WO = MakeTranslation(place->x(), place->y(), place->z());
    const Pose moved =
        MakeTranslation(kMove_m * std::cos(angle_rad), kMove_m * std::sin(angle_rad), 0) *
        thing.X_WO;
    const std::size_t object = script.scene.objects.size();
    script.events.push_back(
        {.object = object, .begin_s = time_s, .what = perception::AppearEvent{.X_WO = thing.X_WO}});
    script.events.push_back({.object = object,
                             .begin_s = time_s + kStay_s,
                             .end_s = time_s + kStay_s + kMoveTime_s,
                             .what = perception::MoveEvent{.X_WO = moved}});
    time_s += 2 * kStay_s + kMoveTime_s;
    script.events.push_back(
        {.object = object, .begin_s = time_s, .what = perception::VanishEvent{}});
    time_s += kPause_s;
    script.scene.objects.push_back(std::move(thing));
  }
  script.duration_s = time_s + 1;
  perception::SequenceSensor sensor;
  sensor.name = "camera_1";
  sensor.camera = {.width = frame.width,
                   .height = frame.height,
                   .focal_px = frame.pinhole.focal_u_px,
                   .center_x_px = frame.pinhole.center_u_px,
                   .center_y_px = frame.pinhole.center_v_px};
  sensor.mount = frame.X_WC;
  sensor.rate_hz = kRate_hz;
  script.sensors.push_back(std::move(sensor));
  return script;
}

// The nearer of the real and the rendered depth, pixel by pixel.
void Paste(const RecordedFrame& real, TrueFrame& rendered) {
  std::string& depth = rendered.frame.depth;
  for (std::size_t pixel = 0; pixel < depth.size() / 2; ++pixel) {
    const std::uint16_t thing = rendered.frame.at(pixel), scene = real.at(pixel);
    const bool is_no_return = scene == 0 || scene == 65'535;
    if (thing != 0 && (is_no_return || thing < scene)) continue;
    std::copy_n(real.depth.begin() + static_cast<std::ptrdiff_t>(2 * pixel), 2,
                depth.begin() + static_cast<std::ptrdiff_t>(2 * pixel));
  }
}

std::string TextOf(const ChangeCounts& counts) {
  char text[120];
  std::snprintf(text, sizeof(text), "%d added, %d removed, %d moved, %d replaced", counts.added,
                counts.removed, counts.moved, counts.replaced);
  return text;
}

void MeasureRealStatic(const std::vector<RecordedFrame>& real, Report& report) {
  constexpr int kMore = 600, kSecond = 30;
  LiveWorld world;
  if (!world.up()) return report.Fail("the server does not come up");
  std::vector<TrueFrame> frames;
  for (int i = 0; i < kSecond; ++i) frames.push_back(Untold(NthFrame({real[0], real[1]}, i)));
  LiveSensor& sensor = world.AddSensor("camera_1", frames.front().frame);
  if (const std::string error = Settle(world, sensor, frames); !error.empty()) {
    return report.Fail("Xtion: " + error);
  }
  const std::int64_t second = world.Revision();
  frames.clear();
  for (std::size_t i = 2; i < real.size(); ++i) {
    frames.push_back(Untold(NthFrame(real, static_cast<int>(i))));
  }
  MoveToPresent(frames);
  if (!Play(sensor, frames)) return report.Fail("the stream ended: " + sensor.Finish());
  std::this_thread::sleep_for(std::chrono::seconds(2));  // regions are interpreted beside
  const std::int64_t before = world.Revision();
  report.Add(WithLimit({.key = "live_static_revisions_real",
                        .value = static_cast<double>(before - second),
                        .unit = "1",
                        .how = "revisions after the second of the eight frames of a fixed Xtion; "
                               "the first two are repeated until the world is interpreted"},
                       0));
  frames.clear();
  for (int i = 0; i < kMore; ++i) {
    frames.push_back(Untold(NthFrame(real, static_cast<int>(real.size()) + i)));
  }
  MoveToPresent(frames);
  const auto recording = Record(world, sensor, {}, 0, frames);
  if (!recording) return report.Fail("the stream ended: " + sensor.Finish());
  const ChangeVerdict changes = JudgeChanges(recording->timeline, 0);
  for (const std::string& line : changes.lines) report.Detail("  Xtion: " + line);
  report.Add(WithLimit(
      {.key = "live_false_changes_real",
       .value = 1e3 * changes.all.sum() / static_cast<double>(recording->timeline.size()),
       .unit = "1/1000",
       .how =
           "changes per 1 000 frames in 20 s of the same eight frames, forwards and backwards; " +
           TextOf(changes.all) + "; revisions " + std::to_string(world.Revision() - before)},
      0.1));
}

void MeasureInserted(const std::vector<RecordedFrame>& real, Report& report) {
  constexpr double kBegin_s = 3;
  constexpr int kStillFrames = 60;
  const SequenceScript script = InsertedThings(real.front(), kBegin_s);
  if (script.scene.objects.size() < kInserted) {
    return report.Fail("the real frames have too few level places");
  }
  const perception::SequenceRenderer renderer(script);
  auto frames =
      RenderFrames(renderer, 0, 0, static_cast<int>(std::lround(script.duration_s * kRate_hz)));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    Paste(NthFrame(real, static_cast<int>(i)), frames[i]);
  }
  LiveWorld world;
  if (!world.up()) return report.Fail("the server does not come up");
  std::vector<TrueFrame> still(frames.begin(), frames.begin() + kStillFrames);
  frames.erase(frames.begin(), frames.begin() + kStillFrames);
  LiveSensor& sensor = world.AddSensor("camera_1", frames.front().frame);
  if (const std::string error = Settle(world, sensor, still); !error.empty()) {
    return report.Fail("Xtion: " + error);
  }
  MoveToPresent(frames);
  const auto recording = Record(world, sensor, script, 0, frames);
  if (!recording) return report.Fail("the stream ended: " + sensor.Finish());
  int told = 0, events = 0;
  int missed[3] = {0, 0, 0};
  for (const Notice& notice : JudgeNotices(recording->timeline, 0)) {
    ++events;
    const bool is_told = notice.moments && *notice.moments <= kMaxMoments;
    told += is_told ? 1 : 0;
    missed[static_cast<int>(notice.kind)] += is_told ? 0 : 1;
  }
  if (events == 0) return report.Fail("no inserted thing is visible");
  char how[240];
  std::snprintf(how, sizeof(how),
                "of %d events of %d rendered things in the real frames, those told within three "
                "frames; not told: %d put, %d taken, %d moved by 6 cm",
                events, kInserted, missed[0], missed[1], missed[2]);
  report.Add(WithLimit(
      {.key = "live_real_inserted", .value = 1e2 * told / events, .unit = "%", .how = how}, 95,
      "at least"));
}

void MeasureMoving(Report& report) {
  std::vector<TrueFrame> frames;
  for (RecordedFrame& frame : ReadMovingFrames()) frames.push_back(Untold(std::move(frame)));
  if (frames.empty()) return report.Detail("depth_sequence is not in CWM_DATA");
  LiveWorld world;
  if (!world.up()) return report.Fail("the server does not come up");
  MoveToPresent(frames);
  LiveSensor& sensor = world.AddSensor("camera_1", frames.front().frame, /*is_fixed=*/false);
  const auto first = sensor.SendAndWait(frames.front().frame);
  if (!first) return report.Fail("the stream ended: " + sensor.Finish());
  frames.erase(frames.begin());
  MoveToPresent(frames);
  const auto recording = Record(world, sensor, {}, 0, frames);
  if (!recording) return report.Fail("the stream ended: " + sensor.Finish());
  const ChangeVerdict changes = JudgeChanges(recording->timeline, 0);
  const std::size_t things =
      recording->timeline.empty() ? 0 : recording->timeline.back().published.size();
  report.Add(
      {.key = "live_moving_camera_changes",
       .value = static_cast<double>(changes.all.removed + changes.all.moved + changes.all.replaced),
       .unit = "1",
       .how = "removed, moved and replaced in 200 frames of a camera that moves in a static "
              "kitchen; " +
              TextOf(changes.all) + "; at the end " + std::to_string(things) + " objects, of " +
              std::to_string(recording->timeline.size()) + " processed frames"});
}

}  // namespace

void MeasureLiveReal(Report& report) {
  std::vector<RecordedFrame> frames = ReadStaticFrames();
  if (frames.size() < 2) {
    report.Detail("real/xtion_static is not in CWM_DATA");
  } else {
    const MeasuredServer server;
    const auto X_WC = EstimatePose(server.connection(), frames.front());
    if (!X_WC.ok()) return report.Fail("no pose of the Xtion: " + X_WC.status().ToString());
    for (RecordedFrame& frame : frames) frame.X_WC = *X_WC;
    MeasureRealStatic(frames, report);
    MeasureInserted(frames, report);
  }
  MeasureMoving(report);
}

}  // namespace cwm::benchmarks
