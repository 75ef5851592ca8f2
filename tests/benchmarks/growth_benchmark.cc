// Growth of time and memory with the size of the cloud, through the running server: one kitchen
// sampled more and more densely, and more and more kitchens side by side, in a ring around the one
// viewpoint from which all are seen.
#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "clients/cpp/cloud_upload.h"
#include "collision/geometry/aabb.h"
#include "perception/cloud/parallel_for.h"
#include "perception/simulation/random_draws.h"
#include "perception/simulation/ray_casting.h"
#include "perception/simulation/scenes.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/running_server.h"

namespace cwm::benchmarks {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kThreads = 2;
constexpr std::int64_t kMillion = 1'000'000;
constexpr int kMillions = 15;  // of the largest clouds, and the number of kitchens in a ring
constexpr double kDegree = std::numbers::pi / 180;
// From the middle of the ring down to the counters: as far away as kitchens of 2 m side by side
// need.
constexpr double kViewDistance_m = 6.8, kPitch_rad = 45 * kDegree;
// A scanning laser like the paper's: 3 mm on bright to 10 mm on dark surfaces. The server is told
// the larger one, as the worst that it must expect.
constexpr double kBrightSigma_m = 0.003, kDarkSigma_m = 0.010;

// A part of a scene in its world, with its bounds for the rays.
struct Target {
  Pose X_SW;
  Shape shape;
  Aabb bounds_W;
  double sigma_m = 0;
};

std::vector<Target> Targets(const perception::SimulatedScene& scene) {
  std::vector<Target> targets;
  int count = 0;
  for (const perception::SimulatedObject& object : scene.objects) {
    for (const Placed<>& part : object.parts) {
      const Pose X_WS = object.X_WO * part.X_FS;
      Target& target = targets.emplace_back();
      target.X_SW = X_WS.inverse();
      target.shape = part.shape;
      target.bounds_W = TightBounds(part.shape, X_WS);
      // Brightness differs from object to object.
      target.sigma_m = std::lerp(kBrightSigma_m, kDarkSigma_m, 0.25 * (count++ % 5));
    }
  }
  return targets;
}

bool Meets(const Vector3& origin, const Vector3& direction, const Aabb& bounds) {
  const Vector3 a = (bounds.min() - origin).cwiseQuotient(direction);
  const Vector3 b = (bounds.max() - origin).cwiseQuotient(direction);
  return a.cwiseMin(b).maxCoeff() <= a.cwiseMax(b).minCoeff() && a.cwiseMax(b).minCoeff() > 0;
}

struct Sample {
  Vector3 p_W;
  double sigma_m = 0;
};

std::optional<Sample> Cast(const std::vector<Target>& targets, const Vector3& origin,
                           const Vector3& direction) {
  std::optional<Sample> nearest;
  double nearest_t = 8;  // the foot of the counter is 7.2 m away; nothing is farther
  for (const Target& target : targets) {
    if (!Meets(origin, direction, target.bounds_W)) continue;
    const auto hit =
        perception::CastRay(target.shape, {target.X_SW * origin, target.X_SW.linear() * direction});
    if (!hit || hit->t >= nearest_t) continue;
    nearest_t = hit->t;
    nearest = Sample{origin + hit->t * direction, target.sigma_m};
  }
  return nearest;
}

// The viewpoint in the world of one kitchen.
Vector3 Eye_W() {
  const Vector3 to_counter(std::cos(kPitch_rad), 0, -std::sin(kPitch_rad));
  const Pose X_WC = perception::KitchenCamera().X_WC;
  constexpr double kCameraDistance_m = 0.9;  // and the same pitch
  return X_WC.translation() - (kViewDistance_m - kCameraDistance_m) * to_counter;
}

// Exactly `count` points as a laser on a pan-tilt unit at the viewpoint measures them, in a level
// frame with its origin there: the rays are spread evenly over one kitchen, from the foot of the
// counter to the top of the wall, with noise along them.
std::vector<Eigen::Vector3f> ScanKitchen(std::int64_t count, std::uint64_t seed) {
  constexpr double kPan_rad = 180 * kDegree / kMillions;
  const Vector3 eye_W = Eye_W();
  const std::vector<Target> targets = Targets(perception::KitchenCounter());
  std::vector<Eigen::Vector3f> points(static_cast<std::size_t>(count));
  constexpr std::size_t kRun = 10'000;  // points that share a stream of draws
  perception::ParallelFor(
      (points.size() + kRun - 1) / kRun, 1, {.max_threads = kThreads},
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t run = begin; run < end; ++run) {
          perception::RandomDraws draws(seed, run);
          std::size_t k = run * kRun;
          while (k < std::min(points.size(), (run + 1) * kRun)) {
            const double pan = draws.Uniform(-kPan_rad, kPan_rad);
            const double tilt = draws.Uniform(-53, -31) * kDegree;
            const Vector3 direction(std::cos(pan) * std::cos(tilt), std::sin(pan) * std::cos(tilt),
                                    std::sin(tilt));
            const std::optional<Sample> hit = Cast(targets, eye_W, direction);
            if (!hit) continue;
            const Vector3 p_W = hit->p_W + hit->sigma_m * draws.Normal() * direction;
            points[k++] = (p_W - eye_W).cast<float>();
          }
        }
      });
  return points;
}

formats::CloudFile ToFile(const std::vector<Eigen::Vector3f>& points) {
  formats::CloudFile file;
  file.fields = {{.name = "x"}, {.name = "y"}, {.name = "z"}};
  file.point_step = formats::AssignOffsets(file.fields);
  file.width = static_cast<std::int64_t>(points.size());
  file.bytes.resize(points.size() * sizeof(Eigen::Vector3f));
  std::memcpy(file.bytes.data(), points.data()->data(), file.bytes.size());
  return file;
}

// Kitchens `first` to `last` - 1 of the ring, each scanned with the same number of points.
formats::CloudFile Kitchens(int first, int last, std::int64_t points_each) {
  std::vector<Eigen::Vector3f> all;
  for (int k = first; k < last; ++k) {
    const Eigen::AngleAxisf turn(static_cast<float>(360 * kDegree * k / kMillions),
                                 Eigen::Vector3f::UnitZ());
    for (const Eigen::Vector3f& p : ScanKitchen(points_each, static_cast<std::uint64_t>(k))) {
      all.push_back(turn * p);
    }
  }
  return ToFile(all);
}

double PeakGibibytes(pid_t pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  std::string word;
  double kibibytes = 0;
  while (status >> word) {
    if (word == "VmHWM:") status >> kibibytes;
  }
  return kibibytes / (1024 * 1024);
}

// Processor time of all threads so far, user and system, because the machine is shared with others.
double CpuSeconds(pid_t pid) {
  constexpr int kUserTime = 14;  // fields of proc(5)'s stat, from 1; system time follows
  std::ifstream stat("/proc/" + std::to_string(pid) + "/stat");
  std::string word;
  double ticks = 0;
  for (int field = 1; field <= kUserTime + 1 && stat >> word; ++field) {
    if (field >= kUserTime) ticks += std::stod(word);
  }
  return ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
}

struct Growth {
  double seconds = 0;
  double peak_gib = 0;
};

// Ingests the cloud into a new server each time, so that the peak memory is that of this cloud.
std::optional<Growth> Ingest(const formats::CloudFile& file, Report& report) {
  const RunningServer server;
  if (!server.up()) {
    report.Fail("the server did not come up: no figures of growth");
    return std::nullopt;
  }
  v1::IngestCloudHeader header;
  header.set_world("kitchens");
  header.mutable_sensor_model()->set_kind(v1::SensorModel::KIND_CONSTANT);
  header.mutable_sensor_model()->set_sigma_m(kDarkSigma_m);
  header.mutable_x_world_sensor()->set_qw(1);
  header.mutable_x_world_sensor()->set_tz_m(Eye_W().z());
  const Clock::time_point start = Clock::now();
  const auto reply = client::IngestCloud(server.connection(), header, file);
  const std::chrono::duration<double> elapsed = Clock::now() - start;
  if (!reply.ok()) {
    report.Fail("an ingest failed: " + std::string(reply.status().message()));
    return std::nullopt;
  }
  char text[200];
  std::snprintf(
      text, sizeof(text),
      "  %9.1f M points %8.2f s %8.3f us a point, %.2f s of CPU, peak %.2f GiB; %d supports, "
      "%d objects",
      static_cast<double>(file.size()) / kMillion, elapsed.count(),
      1e6 * elapsed.count() / static_cast<double>(file.size()), CpuSeconds(server.pid()),
      PeakGibibytes(server.pid()), reply->supports_size(), reply->objects_size());
  report.Detail(text);
  return Growth{elapsed.count(), PeakGibibytes(server.pid())};
}

struct Series {
  Growth last;
  double growth = 0;  // time per point at 15 M over that at 1 M
};

std::optional<Series> MeasureOneKitchen(Report& report) {
  report.Detail("One kitchen, sampled more densely, IngestCloud as a whole, upload included:");
  std::vector<Growth> growths;
  for (const int millions : {1, 5, kMillions}) {
    const auto growth = Ingest(ToFile(ScanKitchen(millions * kMillion, 1)), report);
    if (!growth) return std::nullopt;
    growths.push_back(*growth);
  }
  const Growth& last = growths.back();
  return Series{last, last.seconds / kMillions / growths.front().seconds};
}

// Kitchens differ in their noise alone, and yet the slowest takes twice as long as the fastest: the
// figure compares fifteen with the first, the detail with the same fifteen one by one.
std::optional<Series> MeasureKitchens(Report& report) {
  report.Detail("Kitchens of a million points each, alone and then side by side:");
  double alone_seconds = 0, first_seconds = 0;
  for (int k = 0; k < kMillions; ++k) {
    const auto growth = Ingest(Kitchens(k, k + 1, kMillion), report);
    if (!growth) return std::nullopt;
    alone_seconds += growth->seconds;
    if (k == 0) first_seconds = growth->seconds;
  }
  if (!Ingest(Kitchens(0, 5, kMillion), report)) return std::nullopt;
  const auto all = Ingest(Kitchens(0, kMillions, kMillion), report);
  if (!all) return std::nullopt;
  char text[100];
  std::snprintf(text, sizeof(text), "  %d side by side over the same one by one: %.3f", kMillions,
                all->seconds / alone_seconds);
  report.Detail(text);
  return Series{*all, all->seconds / kMillions / first_seconds};
}

}  // namespace

void MeasureGrowth(Report& report) {
  const auto one = MeasureOneKitchen(report);
  const auto many = MeasureKitchens(report);
  if (!one || !many) return;
  report.Add(
      {.key = "growth_15m",
       .value = one->growth,
       .unit = "1",
       .how = "time per point at 15 million over that at 1 million, one kitchen, sigma 3-10 mm"});
  report.Add({.key = "growth_15_kitchens",
              .value = many->growth,
              .unit = "1",
              .how = "time per point of 15 kitchens of a million points over that of one"});
  report.Add({.key = "seconds_15m",
              .value = std::max(one->last.seconds, many->last.seconds),
              .unit = "s",
              .how = "whole IngestCloud of 15 million points, the slower of both series"});
  report.Add({.key = "gib_15m",
              .value = std::max(one->last.peak_gib, many->last.peak_gib),
              .unit = "GiB",
              .how = "peak resident memory of the server (VmHWM), the larger of both series"});
}

}  // namespace cwm::benchmarks
