#include "perception/vessels/shell_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "collision/geometry/aabb.h"
#include "perception/cloud/quantile.h"
#include "perception/cloud/tolerances.h"
#include "perception/solids/free_space.h"
#include "perception/vessels/shell_profile.h"

namespace cwm::perception {
namespace {

// derived: a share of 5 % of so many rays is known to 1.3 %.
constexpr std::size_t kRays = 300;

// chosen: the standard deviation of the wall thickness of cups, pans and jugs for a table.
constexpr double kThicknessSpread_m = 0.001;
// derived: the thickness of a wall that is seen from one side: two standard deviations below the
// thickest.
constexpr double kTypicalThickness_m = kWallThickness_m - 2 * kThicknessSpread_m;
// chosen: the largest horizontal thickness, which a slanted wall has; no wall is thicker.
constexpr double kMaxAcross_m = 0.025;
constexpr int kInsideSectors = kSectors / 4;  // derived: the inside is seen over a quarter turn
// derived: the least depth from the rim to the deepest visible place inside. Both are known to
// three standard deviations, and twice the thickest wall is needed; a smaller depth may be a lid's.
constexpr double kMinDepth_sigma = kDistanceGate_sigma * 2;
constexpr double kMinDepth_m = kWallThickness_m * 2;
// chosen: the least share of the points near the shell that lie on it; the rest may be its
// contents.
constexpr double kMinOnShell = 0.6;
// chosen: the largest deviation of the mesh from the shell: a fifth of a Kinect's noise at 0.8 m.
constexpr double kMeshDeviation_m = 3e-4;
// chosen: the least ratio of the shell's points to those of the solids it replaces; otherwise those
// are simpler.
constexpr double kMinPointRatio = 1.05;

// A point in the vessel's frame: z is its axis.
struct Place {
  double radial_m = 0, z_m = 0;
  double away = 0, up = 0;  // components of the normal
  bool passes_axis = false;
  std::size_t sector = 0;
  double gate_m = 0;
};

Pose FrameOf(const RevolvedWall& wall, const Vector3& origin_L) {
  Pose X_MV = Pose::Identity();
  X_MV.linear() = BasisFromZ(wall.Axis());
  X_MV.translation() = wall.Middle() - origin_L;
  return X_MV;
}

std::vector<Place> PlacesIn(const Pose& X_MV, const ModelPoints& points) {
  const Pose X_VM = X_MV.inverse(Eigen::Isometry);
  std::vector<Place> places;
  places.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3 p = X_VM * points.p[i], n = X_VM.linear() * points.n[i];
    const Vector2 level = p.head<2>(), normal = n.head<2>();
    Place& place = places.emplace_back();
    place.radial_m = level.norm();
    place.z_m = p.z();
    const Vector2 away = level / std::max(1e-6, place.radial_m);
    place.away = away.dot(normal);
    place.up = n.z();
    const double beside = away.x() * normal.y() - away.y() * normal.x();
    place.passes_axis = std::abs(beside) <= kNormalMiss_sin * normal.norm();
    const double turn = std::atan2(level.y(), level.x()) / (2 * std::numbers::pi) + 0.5;
    place.sector = std::min<std::size_t>(static_cast<std::size_t>(turn * kSectors), kSectors - 1);
    place.gate_m = points.gate_m[i];
  }
  return places;
}

// Values around the axis. Their middle is the median over the sectors' medians, so that an occluded
// or disturbed sector does not count.
class Around {
 public:
  void Add(std::size_t sector, double value) {
    by_sector_[sector].push_back(value);
    ++count_;
  }
  std::size_t count() const { return count_; }
  auto sectors() const {
    return std::count_if(by_sector_.begin(), by_sector_.end(),
                         [](const std::vector<double>& values) { return !values.empty(); });
  }
  double Middle() const {
    std::vector<double> medians;
    for (const std::vector<double>& values : by_sector_) {
      if (!values.empty()) medians.push_back(Median(values));
    }
    return Median(std::move(medians));
  }

 private:
  std::array<std::vector<double>, kSectors> by_sector_;
  std::size_t count_ = 0;
};

class ShellFitter {
 public:
  ShellFitter(const RevolvedWall& wall, const FitContext& context)
      : wall_(wall),
        c_(context),
        X_MV_(FrameOf(wall, context.points.origin_L)),
        places_(PlacesIn(X_MV_, context.points)),
        low_m_(wall.low_z_m - wall.middle_z_m),
        steps_(static_cast<std::size_t>((wall.high_z_m - wall.low_z_m) / wall.step_m) + 1) {}

  std::optional<Solid> Fit() {
    outside_ = RingsOf(Side::kOutside);
    inside_ = RingsOf(Side::kInside);
    if (!InsideIsSeen()) return std::nullopt;
    const double rim_m = RimHeight_m();
    if (IsLidded(rim_m)) return std::nullopt;
    MeasureThickness();
    const std::vector<WallRing> rings = JoinedRings();
    if (rings.empty()) return std::nullopt;
    const std::vector<Vector2> floor = Floor();
    const double lowest_m = floor.empty() ? LowestInside().z_m : floor.back().y();
    if (rim_m - lowest_m < MinDepth_m()) return std::nullopt;
    ShellOutline outline{.rings = rings,
                         .floor = floor,
                         .step_m = wall_.step_m,
                         .rim_z_m = rim_m,
                         .thickness_m = thickness_m_,
                         .ground_z_m = Ground_m(rings.front().radius_m)};
    // The foot of a vessel is often occluded, so it is assumed to stand unless rays passed where it
    // would.
    const std::optional<Solid> standing = Built(MakeShell(outline));
    if (standing && !IsPassedThrough(*standing)) return standing;
    outline.foot = ShellFoot::kAtSeenEnd;
    const std::optional<Solid> floating = Built(MakeShell(outline));
    if (floating && !IsPassedThrough(*floating)) return floating;
    return std::nullopt;
  }

 private:
  enum class Side { kOutside, kInside };

  double MiddleOf(std::size_t step) const {
    return low_m_ + (static_cast<double>(step) + 0.5) * wall_.step_m;
  }

  // The distance of a place inside the wall's outline; negative outside.
  double Within_m(const Place& place) const {
    return wall_.OuterRadius_m(place.z_m + wall_.middle_z_m) - place.radial_m;
  }

  bool IsOf(Side side, const Place& place) const {
    const double within_m = Within_m(place);
    if (!place.passes_axis || within_m < -place.gate_m) return false;
    if (side == Side::kOutside) return place.away > kSteep_sin && within_m <= place.gate_m;
    return place.away < -kSteep_sin && within_m <= kMaxAcross_m + place.gate_m;
  }

  bool Suffices(std::size_t count) const {
    return static_cast<double>(count) * std::max(1.0, c_.points.weight) >=
           static_cast<double>(kMinInRing);
  }

  std::vector<std::optional<WallRing>> RingsOf(Side side) const {
    std::vector<Around> around(steps_);
    for (const Place& place : places_) {
      if (place.z_m < low_m_ || !IsOf(side, place)) continue;
      const auto step = static_cast<std::size_t>((place.z_m - low_m_) / wall_.step_m);
      if (step < steps_) around[step].Add(place.sector, place.radial_m);
    }
    std::vector<std::optional<WallRing>> rings(steps_);
    for (std::size_t k = 0; k < steps_; ++k) {
      if (!Suffices(around[k].count()) || around[k].sectors() < kMinSectors) continue;
      rings[k] = WallRing{.z_m = MiddleOf(k),
                          .radius_m = around[k].Middle(),
                          .weight = static_cast<double>(around[k].count())};
    }
    return rings;
  }

  bool InsideIsSeen() const {
    std::array<std::size_t, kSectors> in_sector{};
    std::size_t count = 0;
    for (const Place& place : places_) {
      if (!IsOf(Side::kInside, place)) continue;
      ++in_sector[place.sector];
      ++count;
    }
    const auto sectors =
        std::count_if(in_sector.begin(), in_sector.end(), [](std::size_t n) { return n > 0; });
    return static_cast<double>(count) * c_.points.weight >= static_cast<double>(kFiveSamples) &&
           sectors >= kInsideSectors;
  }

  double Sigma_m() const { return Median(c_.points.sigma_m); }

  double MinDepth_m() const { return std::max(kMinDepth_m, kMinDepth_sigma * Sigma_m()); }

  // True if most points inside the wall are level with its rim, which is then closed by a lid. The
  // normals of merged views point to one viewpoint, so the far wall of a can seems to be seen from
  // inside, but its lid shows otherwise.
  bool IsLidded(double rim_m) const {
    std::size_t beside = 0, level = 0;
    for (const Place& place : places_) {
      const double within_m = Within_m(place);
      if (within_m <= kMaxAcross_m || within_m > 2 * kMaxAcross_m) continue;
      ++beside;
      level += std::abs(place.z_m - rim_m) < MinDepth_m();
    }
    return Suffices(level) && 2 * level > beside;
  }

  WallRing LowestInside() const {
    const auto lowest = std::find_if(inside_.begin(), inside_.end(),
                                     [](const std::optional<WallRing>& ring) { return ring; });
    if (lowest != inside_.end()) return **lowest;
    return {.z_m = std::numeric_limits<double>::infinity()};
  }

  // The height at which the side with more points ends.
  double RimHeight_m() const {
    std::array<std::vector<std::uint32_t>, 2> on;
    for (std::uint32_t i = 0; i < places_.size(); ++i) {
      const Place& place = places_[i];
      const double within_m = Within_m(place);
      if (within_m < -place.gate_m || within_m > kMaxAcross_m) continue;
      on[place.away > 0 ? 0 : 1].push_back(i);
    }
    const std::vector<std::uint32_t>& larger = on[0].size() > on[1].size() ? on[0] : on[1];
    const Vector3 axis = X_MV_.linear().col(2);
    // Points on a flat rim fill the ragged end up to their noise.
    return ExtentAlong(axis, c_.points, larger).high_m - axis.dot(X_MV_.translation()) - Sigma_m();
  }

  void MeasureThickness() {
    std::vector<double> across_m;
    for (std::size_t k = 0; k < steps_; ++k) {
      if (!outside_[k] || !inside_[k]) continue;
      const double slope = SlopeAt(outside_, k);
      across_m.push_back((outside_[k]->radius_m - inside_[k]->radius_m) /
                         std::sqrt(1 + slope * slope));
    }
    // The two sides are seen apart, at the near and the far rim, so the slow warp differs between
    // them.
    const double sigma_m = std::hypot(Sigma_m(), c_.noise.WarpSigma_m());
    const double prior = 1 / (kThicknessSpread_m * kThicknessSpread_m);
    thickness_is_measured_ = across_m.size() >= 2;  // a single ring is not reliable
    const double measured = thickness_is_measured_ ? 1 / (sigma_m * sigma_m) : 0;
    thickness_sigma_m_ = 1 / std::sqrt(prior + measured);
    thickness_m_ = (prior * kTypicalThickness_m + measured * Median(across_m)) / (prior + measured);
    thickness_m_ = std::clamp(thickness_m_, kMinVesselWall_m, kMaxAcross_m);
  }

  double SlopeAt(const std::vector<std::optional<WallRing>>& rings, std::size_t k) const {
    const std::size_t below = k > 0 && rings[k - 1] ? k - 1 : k;
    const std::size_t above = k + 1 < steps_ && rings[k + 1] ? k + 1 : k;
    if (above == below) return 0;
    return (rings[above]->radius_m - rings[below]->radius_m) /
           (wall_.step_m * static_cast<double>(above - below));
  }

  // The standard deviation of the outside's radius near the rim. The inside gives it up to the
  // thickness.
  double RimSigma_m() const {
    double outside = 0, inside = 0;
    std::size_t rings = 0;
    for (std::size_t k = steps_; k-- > 0 && rings < kNearSteps;) {
      outside += outside_[k] ? outside_[k]->weight : 0;
      inside += inside_[k] ? inside_[k]->weight : 0;
      rings += outside_[k] || inside_[k];
    }
    const double noise_m = Sigma_m() / std::sqrt(c_.IndependentSamples(1) * (outside + inside));
    const double of_thickness_m = inside / (outside + inside) * thickness_sigma_m_;
    // The near and the far side are within the warp's correlation length of 78 mm, so half of the
    // warp remains.
    return std::hypot(noise_m, c_.noise.WarpSigma_m() / 2, of_thickness_m);
  }

  // The rings of the outside, from the points of both sides.
  std::vector<WallRing> JoinedRings() const {
    std::vector<WallRing> rings;
    for (std::size_t k = 0; k < steps_; ++k) {
      WallRing ring{.z_m = MiddleOf(k)};
      double sum_m = 0;
      if (outside_[k]) {
        ring.shows_outside = true;
        ring.weight += outside_[k]->weight;
        sum_m += outside_[k]->weight * outside_[k]->radius_m;
      }
      if (inside_[k]) {
        const double slope = SlopeAt(inside_, k);
        ring.shows_inside = true;
        ring.weight += inside_[k]->weight;
        sum_m += inside_[k]->weight *
                 (inside_[k]->radius_m + thickness_m_ * std::sqrt(1 + slope * slope));
      }
      if (!(ring.weight > 0)) continue;
      ring.radius_m = sum_m / ring.weight;
      rings.push_back(ring);
    }
    return Smoothed(rings, wall_.step_m);
  }

  // The visible floor from the wall inwards, as long as it does not rise.
  std::vector<Vector2> Floor() const {
    const WallRing lowest = LowestInside();
    const double max_m = lowest.radius_m;
    const auto count = static_cast<std::size_t>(std::max(0.0, max_m) / wall_.step_m) + 1;
    std::vector<Around> around(count);
    // Rays reached the inside wherever it is seen, so points above its lowest ring are no floor.
    const double highest_m = lowest.z_m + wall_.step_m;
    for (const Place& place : places_) {
      if (place.z_m > highest_m || place.up < kWallRise_sin || place.radial_m >= max_m ||
          Within_m(place) < thickness_m_)
        continue;
      around[static_cast<std::size_t>(place.radial_m / wall_.step_m)].Add(place.sector, place.z_m);
    }
    std::vector<Vector2> floor;
    for (std::size_t k = count; k-- > 0;) {
      if (!Suffices(around[k].count())) continue;
      const double z_m = around[k].Middle();
      // A rise by more than noise belongs to the contents.
      if (!floor.empty() && z_m > floor.back().y() + kNoiseReach_m) break;
      floor.emplace_back((static_cast<double>(k) + 0.5) * wall_.step_m, z_m);
    }
    return floor;
  }

  // The height at which the foot would touch the ground, with the tilt of the axis. Empty for a
  // vessel that does not stand on it.
  std::optional<double> Ground_m(double foot_radius_m) const {
    if (!c_.ground.known) return std::nullopt;
    const Vector3 axis = X_MV_.linear().col(2);
    const double rise = axis.dot(c_.ground.up);
    if (rise < std::cos(kSameDirection_rad)) return std::nullopt;
    const double tilt_sine = axis.cross(c_.ground.up).norm();
    return -c_.ground.Height_m(X_MV_.translation()) / rise + foot_radius_m * tilt_sine;
  }

  // True if more rays cross the shell than mixed pixels explain, counting rays to its own points
  // and rays past it. The depth that solids tolerate is thicker than any wall, so every ray that
  // enters the wall counts.
  bool IsPassedThrough(const Solid& shell) const {
    if (CrossingRayShare(shell, c_.free) > kMaxPassing) return true;
    if (!c_.options.from_viewpoint) return false;
    const double reach_m = TightBounds(shell.shape, Pose::Identity()).diagonal().norm();
    const std::size_t stride = std::max<std::size_t>(1, c_.points.size() / kRays);
    double own = 0, crossing = 0;
    for (std::size_t i = 0; i < c_.points.size(); i += stride) {
      const Vector3 to_sensor = (c_.points.viewpoint - c_.points.p[i]).normalized();
      const double clear_m = std::max(kMaxDepth_m, c_.points.gate_m[i]) + thickness_m_;
      ++own;
      crossing += EntersSolid(shell, c_.points.p[i] + clear_m * to_sensor,
                              c_.points.p[i] + reach_m * to_sensor);
    }
    return crossing > kMaxPassing * own;
  }

  std::optional<Solid> Built(std::optional<ShellProfile> profile) const {
    if (!profile) return std::nullopt;
    Solid shell;
    shell.role = profile->measured_share < 0.5 ? PartRole::kCompleted : PartRole::kFitted;
    shell.X_MS = X_MV_ * Eigen::Translation3d(0, 0, profile->middle_z_m);
    shell.shape = MakeMesh(Tessellate(profile->shell, kMeshDeviation_m));
    const Pose X_SM = shell.X_MS.inverse(Eigen::Isometry);
    std::size_t near = 0;
    for (std::uint32_t i = 0; i < places_.size(); ++i) {
      if (Within_m(places_[i]) < -places_[i].gate_m) continue;  // a handle's or another object's
      ++near;
      const double distance_m = SignedDistance_m(profile->shell, X_SM * c_.points.p[i]);
      if (std::abs(distance_m) <= c_.points.gate_m[i]) shell.inliers.push_back(i);
    }
    profile->shell.rim_radius_sigma_m = RimSigma_m();
    if (thickness_is_measured_) profile->shell.wall_thickness_sigma_m = thickness_sigma_m_;
    shell.vessel = std::make_shared<const VesselShell>(std::move(profile->shell));
    if (static_cast<double>(shell.inliers.size()) < kMinOnShell * static_cast<double>(near) ||
        shell.inliers.empty()) {
      return std::nullopt;
    }
    return shell;
  }

  const RevolvedWall& wall_;
  const FitContext& c_;
  Pose X_MV_;
  std::vector<Place> places_;                              // one per point of the context
  double low_m_;                                           // low end of the wall in frame V
  std::size_t steps_;                                      // steps of the profile
  std::vector<std::optional<WallRing>> outside_, inside_;  // per step, empty if not seen
  double thickness_m_ = 0;
  double thickness_sigma_m_ = 0;
  bool thickness_is_measured_ = false;
};

std::size_t CountOn(const Solid& solid, const std::vector<std::uint32_t>& members,
                    const ModelPoints& points) {
  const Pose X_SM = solid.X_MS.inverse(Eigen::Isometry);
  std::size_t count = 0;
  for (std::uint32_t i : members) {
    count += std::abs(SignedDistance_m(solid, X_SM * points.p[i])) <= points.gate_m[i];
  }
  return count;
}

}  // namespace

std::optional<Solid> FitShell(const RevolvedWall& wall, const FitContext& context) {
  return ShellFitter(wall, context).Fit();
}

void ReplaceByShells(const std::vector<RevolvedWall>& walls, const FitContext& context,
                     Assembly& assembly) {
  for (auto wall = walls.begin(); wall != walls.end(); ++wall) {
    context.work.Poll();
    // A wall whose middle lies within an earlier wall consists of points that the earlier one left
    // over.
    const bool is_rest = std::any_of(walls.begin(), wall, [&](const RevolvedWall& before) {
      return before.Protrusion_m(wall->Middle()) < 0;
    });
    if (is_rest) continue;
    std::optional<Solid> shell = FitShell(*wall, context);
    if (!shell) continue;
    std::vector<Solid> kept;
    std::size_t replaced = 0;
    for (const Solid& solid : assembly.solids) {
      const std::size_t on = CountOn(*shell, solid.inliers, context.points);
      if (2 * on > solid.inliers.size()) {
        replaced += solid.inliers.size();
      } else {
        kept.push_back(solid);
      }
    }
    if (static_cast<double>(shell->inliers.size()) <
        kMinPointRatio * static_cast<double>(replaced)) {
      continue;
    }
    kept.push_back(*std::move(shell));
    assembly.solids = std::move(kept);
    const auto note = std::ranges::find(assembly.notes, kSeenFromBothSides);
    if (note != assembly.notes.end()) assembly.notes.erase(note);  // the note on this wall
  }
}

}  // namespace cwm::perception
