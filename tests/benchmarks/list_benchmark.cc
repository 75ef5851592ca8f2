// Nothing invented in lists of points: furniture as lasers see it, shuffled images of cameras and
// views merged in one cloud, judged by the rays of all views.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "perception/cloud/parallel_for.h"
#include "perception/interpret_scene.h"
#include "perception/simulation/angles.h"
#include "perception/simulation/unorganised.h"
#include "perception/simulation/virtual_scanner.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/quality/free_space.h"
#include "tests/benchmarks/quality/up_settings.h"

namespace cwm::benchmarks {
namespace {

using perception::PinholeCamera;
using perception::SensorModel;
using perception::SensorNoise;

constexpr int kListThreads = 2;
constexpr int kStride = 5;  // of the rays' columns and rows

enum class ListKind { kLaser, kFineLaser, kShuffled, kMerged };
constexpr std::array<std::string_view, 4> kListNames = {"tilting laser", "laser of 3 mm",
                                                        "shuffled image", "three merged views"};

struct ListScan {
  perception::PointCloud cloud;  // in the frame of the first view
  std::vector<perception::PointCloud> images;
  std::vector<PinholeCamera> cameras;  // one per image
  SensorNoise noise = {};
};

SensorNoise NoiseOf(ListKind kind) {
  if (kind == ListKind::kLaser) return {.model = SensorModel::kTiltingLaser};
  if (kind == ListKind::kFineLaser) return {.model = SensorModel::kGiven, .given_sigma_m = 0.003};
  return {};
}

// The camera of a view; that of a laser is a hundred degrees wide.
PinholeCamera CameraOf(ListKind kind, PinholeCamera camera) {
  if (kind != ListKind::kLaser && kind != ListKind::kFineLaser) return camera;
  camera.width = 800;
  camera.height = 500;
  camera.focal_px = 0.5 * camera.width / std::tan(perception::Radians(50));
  camera.center_x_px = 0.5 * (camera.width - 1);
  camera.center_y_px = 0.5 * (camera.height - 1);
  return camera;
}

// The camera turned about the vertical through a place in the middle of its view.
PinholeCamera Around(PinholeCamera camera, double angle_deg) {
  const Vector3 middle = camera.X_WC * Vector3(0, 0, 1.2);
  camera.X_WC = Eigen::Translation3d(middle) *
                Eigen::AngleAxisd(perception::Radians(angle_deg), Vector3::UnitZ()) *
                Eigen::Translation3d(-middle) * camera.X_WC;
  return camera;
}

ListScan ScanList(ListKind kind, const UpSetting& setting) {
  const perception::SimulatedView view = ViewOf(setting);
  ListScan out;
  out.noise = NoiseOf(kind);
  const PinholeCamera first = CameraOf(kind, view.camera);
  out.cameras = {first};
  if (kind == ListKind::kMerged) {
    out.cameras.push_back(Around(first, 50));
    out.cameras.push_back(Around(first, -50));
  }
  perception::SimulatedCloud merged;
  for (std::size_t v = 0; v < out.cameras.size(); ++v) {
    perception::SimulatedCloud scan =
        Scan(view.scene, out.cameras[v], {.noise = out.noise, .seed = setting.seed + v});
    const Pose X_FirstC = first.X_WC.inverse() * out.cameras[v].X_WC;
    for (const Eigen::Vector3f& p : scan.cloud.points) {
      merged.cloud.points.push_back((X_FirstC * p.cast<double>()).cast<float>());
    }
    merged.object.insert(merged.object.end(), scan.object.begin(), scan.object.end());
    merged.part.insert(merged.part.end(), scan.part.begin(), scan.part.end());
    out.images.push_back(std::move(scan.cloud));
  }
  merged.cloud.width = static_cast<int>(merged.cloud.points.size());
  out.cloud = Shuffled(merged, setting.seed).cloud;
  return out;
}

struct ListOutcome {
  std::string failure = {};
  FreeSpace free_space = {};
  bool has_rays = true;  // it was recognised as seen from one place
};

ListOutcome Judge(ListKind kind, const UpSetting& setting) {
  const ListScan scan = ScanList(kind, setting);
  perception::InterpretOptions options;
  options.noise = scan.noise;
  options.max_threads = 1;
  options.X_WC = scan.cameras.front().X_WC;
  auto found = perception::InterpretScene(scan.cloud, options);
  if (!found.ok()) {
    return {.failure = setting.name() + ": " + std::string(found.status().message())};
  }
  ListOutcome outcome;
  outcome.has_rays = found->seen_from_origin;
  for (std::size_t v = 0; v < scan.images.size(); ++v) {
    const Pose& X_WC = scan.cameras[v].X_WC;
    OtherMeasurements other{.points = {}, .noise = scan.noise, .before_sigma = 3};
    for (std::size_t k = 0; k < scan.images.size(); ++k) {
      if (k == v) continue;
      const Pose X_CK = X_WC.inverse() * scan.cameras[k].X_WC;
      for (const Eigen::Vector3f& p : scan.images[k].points) {
        other.points.push_back((X_CK * p.cast<double>()).cast<float>());
      }
    }
    found->X_WC = X_WC;  // claims are made in the frame of the view's camera
    outcome.free_space.Add(
        MeasureFreeSpace(ClaimsOf(*found), scan.images[v], scan.cameras[v], kStride, other));
  }
  return outcome;
}

std::string ByClaim(const char* how, const std::array<std::int64_t, kClaimCount>& counts) {
  std::string text;
  for (std::size_t c = 0; c < counts.size(); ++c) {
    if (counts[c] == 0) continue;
    text += std::string(", ") + how + " " + std::string(NameOf(static_cast<Claim>(c))) + " " +
            std::to_string(counts[c]);
  }
  return text;
}

std::string LineOf(const std::string& name, const FreeSpace& space) {
  char text[160];
  std::snprintf(text, sizeof(text), "  %-20s %8lld rays: violating %.5f", name.c_str(),
                static_cast<long long>(space.rays), space.share());
  return text + ByClaim("deep in", space.deep) + ByClaim("across", space.crossed);
}

}  // namespace

void MeasureListsOn(const Seeds& seeds, Report& report) {
  struct Case {
    ListKind kind;
    UpSetting setting;
  };
  std::vector<Case> cases;
  for (std::size_t kind = 0; kind < kListNames.size(); ++kind) {
    for (std::size_t place = 0; place < kPlaceNames.size(); ++place) {
      for (int i = 0; i < seeds.count; ++i) {
        cases.push_back({static_cast<ListKind>(kind),
                         {.place = static_cast<Place>(place),
                          .mounting = Mounting::kUpright,
                          .seed = seeds.first + static_cast<std::uint64_t>(i)}});
      }
    }
  }
  std::vector<ListOutcome> outcomes(cases.size());
  perception::ParallelFor(cases.size(), 1, {.max_threads = kListThreads},
                          [&](std::size_t begin, std::size_t end) {
                            for (std::size_t k = begin; k < end; ++k) {
                              outcomes[k] = Judge(cases[k].kind, cases[k].setting);
                            }
                          });
  FreeSpace total;
  std::array<FreeSpace, kListNames.size()> by_kind;
  std::array<FreeSpace, kPlaceNames.size()> by_place;
  std::vector<std::string> lines;
  for (std::size_t k = 0; k < cases.size(); ++k) {
    const ListOutcome& outcome = outcomes[k];
    if (!outcome.failure.empty()) {
      report.Fail(outcome.failure);
      continue;
    }
    total.Add(outcome.free_space);
    by_kind[static_cast<std::size_t>(cases[k].kind)].Add(outcome.free_space);
    by_place[static_cast<std::size_t>(cases[k].setting.place)].Add(outcome.free_space);
    lines.push_back(LineOf(std::string(kListNames[static_cast<std::size_t>(cases[k].kind)]) + ", " +
                               cases[k].setting.name() + (outcome.has_rays ? "" : ", no rays"),
                           outcome.free_space));
  }
  for (std::size_t i = 0; i < kListNames.size(); ++i) {
    report.Detail(LineOf(std::string(kListNames[i]), by_kind[i]));
  }
  for (std::size_t i = 0; i < kPlaceNames.size(); ++i) {
    report.Detail(LineOf(std::string(kPlaceNames[i]), by_place[i]));
  }
  report.Attach("list_scans.txt", lines);
  report.Add({.key = "list_free_space_violation",
              .value = total.share(),
              .unit = "1",
              .how = "share of rays of " + std::to_string(cases.size()) +
                     " lists of points that run deep in a solid, or cross a surface far from all "
                     "points; lasers, shuffled images, three merged views"});
}

void MeasureLists(Report& report) { MeasureListsOn(kSeedsOfLists, report); }

}  // namespace cwm::benchmarks
