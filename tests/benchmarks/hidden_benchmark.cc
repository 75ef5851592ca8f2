// The hidden insides of things: centres of true solids that the interpretation leaves free, and the
// volume that completed parts add beyond the truth.
#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "collision/geometry/signed_distance.h"
#include "collision/geometry/triangle.h"
#include "perception/cloud/parallel_for.h"
#include "perception/interpret_scene.h"
#include "perception/simulation/virtual_scanner.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/quality/claimed_geometry.h"
#include "tests/benchmarks/quality/simulated_case.h"
#include "tests/benchmarks/quality/up_settings.h"

namespace cwm::benchmarks {
namespace {

using namespace perception;

constexpr int kHiddenThreads = 2;
// A thing of fewer points is hidden itself.
constexpr int kMinSeen = 200;
// The grid on which volumes are counted.
constexpr double kVolumeStep_m = 0.01;
// Parts with more volume beyond the truth are named.
constexpr double kRemarkedExcess_m3 = 0.001;

struct HiddenTally {
  int solids = 0, free = 0;    // true solids, and those with their centre free and exact
  int parts = 0, bounded = 0;  // boxes and plates, and those with something hidden
  double excess_m3 = 0;        // of completed parts beyond the truth
  double hidden_m3 = 0;        // of the truth beyond fitted parts
  std::vector<std::string> remarks = {};

  void Add(const HiddenTally& other) {
    solids += other.solids, free += other.free;
    parts += other.parts, bounded += other.bounded;
    excess_m3 += other.excess_m3, hidden_m3 += other.hidden_m3;
    remarks.insert(remarks.end(), other.remarks.begin(), other.remarks.end());
  }
};

bool IsSolid(const Shape& shape) {
  return std::holds_alternative<Box>(shape) || std::holds_alternative<Cylinder>(shape) ||
         std::holds_alternative<Sphere>(shape) || std::holds_alternative<Cone>(shape);
}

// A solid of the truth in the camera's frame.
struct TrueSolid {
  Pose X_CS = Pose::Identity();
  Shape shape = {};
  std::string name = {};
  bool is_seen = false;
  bool is_thing = false;  // convex, and no structure
};

// Walls, legs and the sides of shelves and bins, whose other side nobody asks for.
bool IsStructure(const SimulatedObject& object) {
  const std::string& name = object.name;
  return IsFurniture(object) || name.ends_with("wall") || name == "leg" || name == "side" ||
         name == "bin_floor";
}

std::vector<TrueSolid> SolidsOf(const SimulatedScene& scene, const PinholeCamera& camera,
                                const SimulatedCloud& scan) {
  std::map<std::pair<std::int32_t, std::int32_t>, int> seen;
  for (std::size_t i = 0; i < scan.object.size(); ++i) ++seen[{scan.object[i], scan.part[i]}];
  std::vector<TrueSolid> solids;
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    const SimulatedObject& object = scene.objects[o];
    for (std::size_t p = 0; p < object.parts.size(); ++p) {
      const Placed<>& part = object.parts[p];
      const bool is_thing =
          !IsStructure(object) && IsSolid(part.shape) && object.RoleOf(p) == PieceRole::kBody;
      const auto points = seen.find({static_cast<std::int32_t>(o), static_cast<std::int32_t>(p)});
      solids.push_back({.X_CS = camera.X_WC.inverse() * object.X_WO * part.X_FS,
                        .shape = part.shape,
                        .name = object.name,
                        .is_seen = points != seen.end() && points->second >= kMinSeen,
                        .is_thing = is_thing});
    }
  }
  return solids;
}

// Claims of one role, with their inside.
struct ClaimedInside {
  const ClaimedGeometry& claims;

  double Distance_m(const Vector3& p_C, std::optional<Claim> only = std::nullopt) const {
    double least_m = std::numeric_limits<double>::infinity();
    for (const ClaimedSolid& solid : claims.solids) {
      if (only && solid.claim != *only) continue;
      least_m = std::min(least_m,
                         SignedDistance_m(solid.shape, solid.X_CS.inverse(Eigen::Isometry) * p_C));
    }
    return least_m;
  }
};

// True if answers about the place say that something may be hidden there.
bool IsBounded(const SceneInterpretation& found, const Vector3& p_C) {
  const Vector3 p_W = found.X_WC * p_C;
  return std::ranges::any_of(found.objects, [&](const DetectedObject& object) {
    const Vector3 p_O = object.X_WO.inverse(Eigen::Isometry) * p_W;
    return std::ranges::any_of(object.model->shapes, [&](const ShapePart& part) {
      return part.hidden && SignedDistance_m(part.hidden->shape,
                                             part.hidden->X_FS.inverse(Eigen::Isometry) * p_O) <= 0;
    });
  });
}

// True if a triangle of a surface is nearer than this: answers then say that they know no inside.
bool IsNearerToSurface(const ClaimedGeometry& claims, const Vector3& p_C, double distance_m) {
  return std::ranges::any_of(claims.triangles, [&](const ClaimedTriangle& triangle) {
    const auto& [a, b, c] = triangle.corners_C;
    return (NearestOnTriangle(a, b, c, p_C) - p_C).norm() < distance_m;
  });
}

template <class Visit>
void ForEachPlace(const Aabb& bounds, const Visit& visit) {
  const Eigen::Array3i counts = (bounds.sizes() / kVolumeStep_m).array().ceil().cast<int>().max(1);
  const Vector3 step = bounds.sizes().array() / counts.cast<double>();
  const double volume_m3 = step.prod();
  for (int i = 0; i < counts.x(); ++i) {
    for (int j = 0; j < counts.y(); ++j) {
      for (int k = 0; k < counts.z(); ++k) {
        const Vector3 at(i + 0.5, j + 0.5, k + 0.5);
        visit(Vector3(bounds.min() + step.cwiseProduct(at)), volume_m3);
      }
    }
  }
}

double TruthDistance_m(const std::vector<TrueSolid>& all, const Vector3& p_C) {
  double least_m = std::numeric_limits<double>::infinity();
  for (const TrueSolid& solid : all) {
    least_m =
        std::min(least_m, SignedDistance_m(solid.shape, solid.X_CS.inverse(Eigen::Isometry) * p_C));
  }
  return least_m;
}

// Counts the volume of a completed part that is in no true solid.
void AddExcess(const std::string& name, const Shape& shape, const Pose& X_CS,
               const std::vector<TrueSolid>& solids, HiddenTally& tally) {
  double excess_m3 = 0;
  ForEachPlace(TightBounds(shape, X_CS), [&](const Vector3& p_C, double volume_m3) {
    if (SignedDistance_m(shape, X_CS.inverse(Eigen::Isometry) * p_C) > 0) return;
    if (TruthDistance_m(solids, p_C) > 0) excess_m3 += volume_m3;
  });
  tally.excess_m3 += excess_m3;
  if (excess_m3 < kRemarkedExcess_m3) return;
  const Vector3 size_m = TightBounds(shape, Pose::Identity()).sizes();
  char text[160];
  std::snprintf(text, sizeof(text), "%s: %.1f l of a completed part of %.0f x %.0f x %.0f mm",
                name.c_str(), 1000 * excess_m3, 1000 * size_m.x(), 1000 * size_m.y(),
                1000 * size_m.z());
  tally.remarks.emplace_back(text);
}

HiddenTally JudgeHidden(const std::string& name, const SimulatedView& view, std::uint64_t seed,
                        const SensorNoise& noise) {
  const SimulatedCloud scan = Scan(view.scene, view.camera, {.noise = noise, .seed = seed});
  InterpretOptions options;
  options.noise = noise;
  options.max_threads = 1;
  options.X_WC = view.camera.X_WC;
  const auto found = InterpretScene(scan.cloud, options);
  HiddenTally tally;
  if (!found.ok()) return tally;
  const ClaimedGeometry claims = ClaimsOf(*found);
  const ClaimedInside inside{claims};
  const std::vector<TrueSolid> solids = SolidsOf(view.scene, view.camera, scan);
  for (const TrueSolid& solid : solids) {
    if (!solid.is_seen || !solid.is_thing) continue;
    ++tally.solids;
    const double distance_m = inside.Distance_m(solid.X_CS.translation());
    if (distance_m > 0 && !IsBounded(*found, solid.X_CS.translation()) &&
        !IsNearerToSurface(claims, solid.X_CS.translation(), distance_m)) {
      ++tally.free;
      const Vector3 size_m = TightBounds(solid.shape, Pose::Identity()).sizes();
      char text[160];
      std::snprintf(text, sizeof(text), "%s: %s of %.0f x %.0f x %.0f mm is free by %.0f mm",
                    name.c_str(), solid.name.c_str(), 1000 * size_m.x(), 1000 * size_m.y(),
                    1000 * size_m.z(), 1000 * distance_m);
      tally.remarks.emplace_back(text);
    }
    ForEachPlace(TightBounds(solid.shape, solid.X_CS), [&](const Vector3& p_C, double volume_m3) {
      if (SignedDistance_m(solid.shape, solid.X_CS.inverse(Eigen::Isometry) * p_C) > 0) return;
      if (inside.Distance_m(p_C, Claim::kFitted) > 0) tally.hidden_m3 += volume_m3;
    });
  }
  for (const DetectedObject& object : found->objects) {
    for (const ShapePart& part : object.model->shapes) {
      const bool is_flat =
          std::holds_alternative<Box>(part.shape) || std::holds_alternative<Plate>(part.shape);
      tally.parts += is_flat;
      tally.bounded += part.hidden.has_value();
      // The plates of walls are residual, and as far off as the sensor is warped at their range.
      if (part.role != PartRole::kCompleted || object.kind != DetectedKind::kObject) continue;
      const Pose X_CS = found->X_WC.inverse(Eigen::Isometry) * object.X_WO * part.X_OS;
      AddExcess(name, part.shape, X_CS, solids, tally);
    }
  }
  return tally;
}

struct HiddenCase {
  std::string name;
  SimulatedView view;
  std::uint64_t seed = 0;
};

std::vector<HiddenCase> HiddenCases(const Seeds& seeds) {
  std::vector<HiddenCase> cases;
  for (std::uint64_t seed = seeds.first;
       seed < seeds.first + static_cast<std::uint64_t>(seeds.count); ++seed) {
    for (const SceneFamily family :
         {SceneFamily::kTable, SceneFamily::kClutter, SceneFamily::kStacks, SceneFamily::kHeaps,
          SceneFamily::kRows}) {
      cases.push_back({NameOf(CaseName{family, seed}), RandomScene(family, seed), seed});
    }
    for (const Place place : {Place::kRoom, Place::kShelf, Place::kBin, Place::kSingle}) {
      const UpSetting setting{.place = place,
                              .mounting = seed % 2 == 0 ? Mounting::kUpright : Mounting::kTilted,
                              .seed = seed};
      cases.push_back({setting.name(), ViewOf(setting), seed});
    }
  }
  return cases;
}

}  // namespace

void MeasureHiddenOn(const Seeds& seeds, Report& report) {
  const std::vector<HiddenCase> cases = HiddenCases(seeds);
  std::vector<HiddenTally> tallies(cases.size());
  ParallelFor(cases.size(), 1, {.max_threads = kHiddenThreads},
              [&](std::size_t begin, std::size_t end) {
                for (std::size_t k = begin; k < end; ++k) {
                  tallies[k] = JudgeHidden(cases[k].name, cases[k].view, cases[k].seed, {});
                }
              });
  HiddenTally total;
  std::map<std::string, HiddenTally> parts;
  for (std::size_t k = 0; k < cases.size(); ++k) {
    total.Add(tallies[k]);
    parts[cases[k].name.substr(0, cases[k].name.find_first_of(" ,"))].Add(tallies[k]);
  }
  for (const auto& [name, tally] : parts) {
    char text[160];
    std::snprintf(
        text, sizeof(text),
        "  %-12s %4d solids, %3d with a free centre; of %d flat parts %d hide something; %.1f l "
        "hidden, %.1f l in excess",
        name.c_str(), tally.solids, tally.free, tally.parts, tally.bounded, 1000 * tally.hidden_m3,
        1000 * tally.excess_m3);
    report.Detail(text);
  }
  report.Attach("hidden_solids.txt", total.remarks);
  report.Add({.key = "hidden_centres_free_exact",
              .value = static_cast<double>(total.free),
              .unit = "solids",
              .how = "of " + std::to_string(total.solids) +
                     " solids of 200 points or more, with their centre free and exact"});
  report.Add({.key = "completed_excess",
              .value = total.excess_m3 / std::max(1e-9, total.hidden_m3),
              .unit = "1",
              .how =
                  "volume of completed parts of objects beyond the truth, over that of the truth "
                  "beyond fitted parts"});
}

void MeasureHidden(Report& report) { MeasureHiddenOn(kSeedsOfHidden, report); }

}  // namespace cwm::benchmarks
