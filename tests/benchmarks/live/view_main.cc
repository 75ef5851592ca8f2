// Measures the comparison of frames alone, without a server: the expected view of known bodies, a
// frame in which nothing changes, false alarms of scenes at rest, and small things that appear.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "perception/live/sensor_view.h"
#include "perception/simulation/frame_errors.h"
#include "perception/simulation/look_at.h"
#include "perception/simulation/random_scenes.h"
#include "perception/simulation/range_image.h"
#include "tests/benchmarks/report.h"
#include "tests/benchmarks/usage.h"
#include "tests/perception/live/known_scene.h"

namespace cwm::benchmarks {
namespace {

using namespace cwm::perception;

constexpr char kUsage[] =
    "cwm-bench-live-view [--frames N] [--json FILE]\n"
    "--frames: of scenes at rest in all (3000).\n";

double ThreadTime_ms() {
  timespec now = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

// The median time of several calls.
double MedianTime_ms(int calls, const std::function<void(int)>& call) {
  std::vector<double> times_ms;
  for (int i = 0; i < calls; ++i) {
    const double start_ms = ThreadTime_ms();
    call(i);
    times_ms.push_back(ThreadTime_ms() - start_ms);
  }
  return Median(times_ms);
}

Stamp StampOf(int frame) { return Stamp(std::chrono::milliseconds(33 * frame)); }

// Frames of a Kinect that stands still before a scene.
class FrameSource {
 public:
  FrameSource(const SimulatedScene& scene, const PinholeCamera& camera, std::uint64_t device_seed)
      : camera_(camera), device_(DrawDeviceErrors(SensorNoise(), camera, device_seed)) {
    Show(scene);
  }

  void Show(const SimulatedScene& scene) {
    const RangeImage image = Render(scene, camera_);
    returns_ = {.width = camera_.width, .height = camera_.height, .pixels = {}};
    returns_.pixels.resize(image.pixels.size());
    ComputeReturns(scene, image, camera_, device_, 0, camera_.height, returns_);
  }

  SensorFrame Next() {
    MeasuredDepth measured = DrawFrame(returns_, device_.noise, device_.seed * 1000000 + frame_);
    auto image = std::make_shared<DepthImage>();
    image->width = measured.width;
    image->height = measured.height;
    image->depth_m = std::move(measured.depth_m);
    return {.stamp = StampOf(frame_++), .X_WC = camera_.X_WC, .image = std::move(image)};
  }

 private:
  PinholeCamera camera_;
  DeviceErrors device_;
  DeviceReturns returns_;
  int frame_ = 0;
};

// A table with a grid of boxes, cans, balls and cones, seen from 1.2 m.
SimulatedView GridScene(int columns, int rows, double spacing_m) {
  SimulatedView view;
  view.camera.X_WC = LookAt(Vector3(0, 0, 0), ViewingDirection{.distance_m = 1.2, .down_rad = 1});
  const auto add = [&](const Shape& shape, const Vector3& place) {
    view.scene.objects.push_back({.name = "",
                                  .parts = {{.X_FS = Pose::Identity(), .shape = shape}},
                                  .X_WO = MakePose(place, Quaternion::Identity())});
  };
  add(Plate{.outline = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}, .holes = {}, .thickness_m = 0.03},
      Vector3::Zero());
  view.scene.objects.back().is_support = true;
  const double width_m = 0.6 * spacing_m;
  const std::vector<Shape> shapes = {Box{{width_m, width_m, width_m}},
                                     Cylinder{width_m / 2, width_m}, Sphere{width_m / 2},
                                     Cone{width_m / 2, width_m / 3, width_m}};
  for (int i = 0; i < columns * rows; ++i) {
    const int row = i / columns;
    const int column = i % columns;
    const double x = spacing_m * (row - 0.5 * (rows - 1));
    const double y = spacing_m * (column - 0.5 * (columns - 1));
    add(shapes[static_cast<std::size_t>(i) % shapes.size()], {x, y, width_m / 2});
  }
  return view;
}

void MeasureExpectedView(Report& report) {
  const SimulatedView grid = GridScene(5, 4, 0.15);
  std::vector<KnownBody> bodies = KnownBodies(grid.scene);
  ExpectedView view(CameraOf(grid.camera));
  const double whole_ms = MedianTime_ms(50, [&](int i) {
    Pose X_WC = grid.camera.X_WC;
    X_WC.translation().x() += 1e-6 * (i + 1);
    view.Update(bodies, X_WC);
  });
  view.Update(bodies, grid.camera.X_WC);
  const double same_ms = MedianTime_ms(50, [&](int) { view.Update(bodies, grid.camera.X_WC); });
  const double moved_ms = MedianTime_ms(50, [&](int) {
    bodies.back().X_WB.translation().x() += 0.001;
    view.Update(bodies, grid.camera.X_WC);
  });
  report.Add({.key = "live_view_render_ms",
              .value = whole_ms,
              .unit = "ms",
              .how = "a plate and 20 shapes at 640 x 480, one thread, median of 50; asked: 2"});
  report.Add({.key = "live_view_same_ms",
              .value = same_ms,
              .unit = "ms",
              .how = "the same when nothing changed"});
  report.Add({.key = "live_view_moved_ms",
              .value = moved_ms,
              .unit = "ms",
              .how = "the same when one shape moved"});
}

// The time of a frame after the reference was learnt, of a scene where nothing changes.
double StaticFrame_ms(const SimulatedView& scene) {
  const std::vector<KnownBody> bodies = KnownBodies(scene.scene);
  FrameSource source(scene.scene, scene.camera, 1);
  SensorView view("sensor", CameraOf(scene.camera), SensorNoise());
  constexpr int kLearning = 40;
  for (int i = 0; i < kLearning; ++i) view.Observe(source.Next(), bodies, {});
  std::vector<SensorFrame> frames;
  for (int i = 0; i < 20; ++i) frames.push_back(source.Next());
  return MedianTime_ms(100, [&](int i) {
    view.Observe(frames[static_cast<std::size_t>(i) % frames.size()], bodies, {});
  });
}

void MeasureStaticFrame(Report& report) {
  const double few_ms = StaticFrame_ms(GridScene(5, 4, 0.15));
  const double many_ms = StaticFrame_ms(GridScene(20, 10, 0.05));
  report.Add({.key = "live_view_static_ms",
              .value = few_ms,
              .unit = "ms",
              .how = "comparison, evidence and learning of a frame in which nothing changed, 640 x "
                     "480, 20 known objects, CPU, median of 100; asked: 2"});
  report.Add({.key = "live_view_static_ratio",
              .value = many_ms / few_ms,
              .unit = "",
              .how = "the same with 200 known objects, by that with 20; asked: 1.2"});
}

void MeasureFalseAlarms(int frames, Report& report) {
  int hot_frames = 0;
  int seen = 0;
  double deviating = 0;
  const int per_family = frames / static_cast<int>(kSceneFamilies.size());
  for (const NamedFamily& family : kSceneFamilies) {
    const SimulatedView scene = RandomScene(family.family, 71);
    const std::vector<KnownBody> bodies = KnownBodies(scene.scene);
    FrameSource source(scene.scene, scene.camera, 71);
    SensorView view("sensor", CameraOf(scene.camera), SensorNoise());
    for (int i = 0; i < per_family; ++i, ++seen) {
      const FrameEvidence evidence = view.Observe(source.Next(), bodies, {});
      if (!evidence.regions.empty()) ++hot_frames;
      deviating += static_cast<double>(
          evidence.classes->counts[static_cast<std::size_t>(PixelClass::kNearer)] +
          evidence.classes->counts[static_cast<std::size_t>(PixelClass::kFarther)]);
    }
  }
  report.Add({.key = "live_view_false_frames",
              .value = static_cast<double>(hot_frames),
              .unit = "",
              .how = "frames with a hot block of " + std::to_string(seen) +
                     " of all families of scenes at rest, from the first frame on; asked: 0"});
  report.Add({.key = "live_view_deviating_pixels",
              .value = deviating / seen,
              .unit = "",
              .how = "pixels of these frames that are nearer or farther, mean"});
}

// Cubes of 20 mm at 1 m that appear on a table, in the third frame and later.
void MeasureSmallThings(Report& report) {
  SimulatedView view = GridScene(0, 0, 1);
  view.camera.X_WC = LookAt(Vector3(0, 0, 0), ViewingDirection{.distance_m = 1, .down_rad = 1});
  const std::vector<KnownBody> bodies = KnownBodies(view.scene);
  constexpr int kThings = 40;
  int told = 0;
  for (int i = 0; i < kThings; ++i) {
    FrameSource source(view.scene, view.camera, static_cast<std::uint64_t>(i) + 1);
    SensorView sensor("sensor", CameraOf(view.camera), SensorNoise());
    const int frames = i % 2 == 0 ? 3 : 30;
    for (int k = 0; k < frames; ++k) sensor.Observe(source.Next(), bodies, {});
    SimulatedScene with_thing = view.scene;
    const Vector3 place(0.01 * (i % 7) - 0.03, 0.013 * (i % 5) - 0.03, 0.01);
    with_thing.objects.push_back(
        {.name = "",
         .parts = {{.X_FS = Pose::Identity(), .shape = Box{{0.02, 0.02, 0.02}}}},
         .X_WO = MakePose(place, Quaternion::Identity())});
    source.Show(with_thing);
    if (!sensor.Observe(source.Next(), bodies, {}).regions.empty()) ++told;
  }
  report.Add({.key = "live_view_small_told",
              .value = 100.0 * told / kThings,
              .unit = "%",
              .how = "cubes of 20 mm that appear at 1 m and are hot in their first frame, of " +
                     std::to_string(kThings) + "; asked: 100"});
}

}  // namespace
}  // namespace cwm::benchmarks

int main(int argc, char** argv) {
  using namespace cwm::benchmarks;
  if (PrintsUsage(argc, argv, kUsage)) return 0;
  int frames = 3000;
  std::string json;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string option = argv[i];
    if (option == "--frames") frames = std::atoi(argv[i + 1]);
    if (option == "--json") json = argv[i + 1];
  }
  Report report;
  MeasureExpectedView(report);
  MeasureStaticFrame(report);
  MeasureSmallThings(report);
  MeasureFalseAlarms(std::max(10, frames), report);
  report.Print();
  if (!json.empty()) report.WriteJson(json);
  return report.failed() ? 1 : 0;
}
