#include "server/core/scan_plausibility.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/core/error.h"

namespace cwm::server {
namespace {

using collision::ObjectKind;
using collision::Owner;
using perception::Association;
using Outcome = Association::Outcome;

// chosen: two things that stand on each other often move alike; three that are all of a scene do
// not.
constexpr std::size_t kMinMoved = 3;
// measured: places of one object differ by less than this between scans of a Kinect.
constexpr double kAlike_m = 0.01;

absl::Status Contradiction(std::string name, const std::string& what) {
  return MakeError(
      absl::StatusCode::kFailedPrecondition,
      absl::StrCat("the scan contradicts the world: ", what,
                   "; to take it all the same, set force"),
      {.reason = "SCAN_CONTRADICTS_WORLD", .metadata = {{"contradiction", std::move(name)}}});
}

bool IsOfPerception(const collision::WorldObject& object) {
  return object.owner == Owner::kPerception && object.attachment == nullptr;
}

// The places of objects before and after a scan that moves all objects that it shows.
struct Displacements {
  std::vector<Vector3> from, to;

  double Mean_m() const {
    double sum_m = 0;
    for (std::size_t i = 0; i < from.size(); ++i) sum_m += (to[i] - from[i]).norm();
    return from.empty() ? 0 : sum_m / static_cast<double>(from.size());
  }

  // True if one rigid motion maps all places to within kAlike_m.
  bool AreAlike() const {
    if (from.size() < kMinMoved) return false;
    const auto count = static_cast<Eigen::Index>(from.size());
    Eigen::Matrix3Xd a(3, count), b(3, count);
    for (Eigen::Index i = 0; i < count; ++i) {
      a.col(i) = from[static_cast<std::size_t>(i)];
      b.col(i) = to[static_cast<std::size_t>(i)];
    }
    const Eigen::Isometry3d motion(Eigen::umeyama(a, b, /*with_scaling=*/false));
    return ((motion * a) - b).colwise().norm().maxCoeff() <= kAlike_m;
  }
};

// Empty if an object of the world was confirmed in place.
Displacements DisplacementsOf(const SceneMatch& match) {
  Displacements moved;
  for (const Association& association : match.associations) {
    if (association.known < 0 || association.object < 0) continue;
    const collision::WorldObject& known = *match.known[static_cast<std::size_t>(association.known)];
    if (!IsOfPerception(known)) continue;
    if (association.outcome == Outcome::kKeep) return {};
    if (association.outcome != Outcome::kMove) continue;
    moved.from.push_back(known.X_WO.translation());
    moved.to.push_back(association.X_WO.translation());
  }
  return moved;
}

struct SupportCounts {
  int all = 0, removed = 0, confirmed = 0;
};

SupportCounts CountSupports(const SceneMatch& match) {
  SupportCounts counts;
  for (const Association& association : match.associations) {
    if (association.known < 0) continue;
    const collision::WorldObject& known = *match.known[static_cast<std::size_t>(association.known)];
    if (known.kind != ObjectKind::kSupport || !IsOfPerception(known)) continue;
    ++counts.all;
    counts.removed += association.outcome == Outcome::kRemove;
    counts.confirmed += association.support >= 0;
  }
  return counts;
}

}  // namespace

absl::Status CheckPlausible(const SceneMatch& match, const perception::SceneInterpretation& scene) {
  const bool holds_any =
      std::ranges::any_of(match.known, [](const auto& object) { return IsOfPerception(*object); });
  if (!holds_any) return absl::OkStatus();
  if (scene.scale_is_implausible) {
    return Contradiction("SCALE",
                         "half of its points lie where its sensor sees nothing, so their unit is "
                         "not metres; for millimetres give a scale of 0.001");
  }
  if (const SupportCounts supports = CountSupports(match);
      supports.removed > 0 && supports.confirmed == 0) {
    return Contradiction(
        "SUPPORTS_GONE",
        absl::StrCat("of ", supports.removed,
                     " supports that it should show it shows none, so the pose of its sensor or "
                     "the unit of its points is likely another"));
  }
  const Displacements moved = DisplacementsOf(match);
  if (moved.AreAlike() && moved.Mean_m() > kMaxDrift_m) {
    return Contradiction(
        "MOVED_ALIKE",
        absl::StrFormat("all %d objects that it shows moved alike, by %.3f m, so the pose of its "
                        "sensor is likely another",
                        moved.from.size(), moved.Mean_m()));
  }
  return absl::OkStatus();
}

absl::Status CheckConfirmsSupport(const SceneMatch& match) {
  const SupportCounts supports = CountSupports(match);
  if (supports.all == 0 || supports.confirmed > 0) return absl::OkStatus();
  return Contradiction("VIEWPOINT",
                       "its points were not seen from the origin of their frame, and it shows none "
                       "of the supports at the pose that was estimated from earlier scans; if its "
                       "coordinates are the world's, give frame world");
}

std::optional<std::string> DriftWarning(const SceneMatch& match) {
  const Displacements moved = DisplacementsOf(match);
  if (!moved.AreAlike() || moved.Mean_m() > kMaxDrift_m) return std::nullopt;
  return absl::StrFormat(
      "all %d objects that the scan shows moved alike, by %.1f mm: the sensor's pose may have "
      "changed",
      moved.from.size(), 1000 * moved.Mean_m());
}

}  // namespace cwm::server
