#include "perception/vessels/revolved_wall.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <span>

#include "perception/cloud/quantile.h"
#include "perception/cloud/sensor_noise.h"
#include "perception/cloud/tolerances.h"
#include "perception/fit/solid.h"
#include "perception/search/model_points.h"
#include "perception/search/shape_model.h"

namespace cwm::perception {
namespace {

// chosen: steep points that vote for each axis that is tried.
constexpr std::size_t kMaxVoters = 800;
// derived: ten independent steep points, twice as many as there are parameters.
constexpr std::size_t kMinSteep = kOneSample * 10;
// derived: if a quarter of the points lie on a wall, one pair in sixteen is good, and none of the
// pairs is good once in 490 times.
constexpr int kPairs = 96;
// chosen: values of a sector, or sectors of a ring, whose median a single outlier does not move.
constexpr std::size_t kMinForMedian = 3;
// derived: the largest change of a wall's radius per metre of height: its normals rise by less than
// the limit kSteep_sin allows.
const double kMaxSlope = std::sqrt(1 - kSteep_sin * kSteep_sin) / kSteep_sin;
// derived: the largest jump of the radius besides: from inside to outside, and noise.
const double kMaxJump_m = std::hypot(kWallThickness_m, kNoiseReach_m);
// chosen: the standard deviation of a standing vessel's axis, half a degree, since up is estimated.
constexpr double kLeanSigma = 0.009;
// derived: the standard deviation of an axis that follows from a part of the wall.
constexpr double kFreeLeanSigma = kSameDirection_rad;
// derived: in radians, a fifth of the axis' standard deviation. The frame is turned to the axis
// until the turn is smaller.
constexpr double kTurned = kLeanSigma / 5;
// chosen: the least share of the steep points on a wall that is seen over 180 degrees, so from
// inside as well. It need not be a majority, for two pans side by side. All walls of an object but
// the first must be seen that far, since a bow alone is easily a bit of a wall; it also bounds the
// points about an axis that is wrong by some degrees.
constexpr double kMinOnRoundWall = 0.25;
constexpr int kRoundSectors = kSectors / 2;  // derived: 180 degrees
// chosen: the radius of an espresso cup; smaller walls belong to handles and spouts.
constexpr double kMinRadius_m = 0.025;
// Gates of the refinement as multiples of the last one: from the accuracy of normals to that of the
// noise.
constexpr std::array<double, 7> kGates = {4, 3, 2, 1.5, 1, 1, 1};

struct SteepPoint {
  Vector2 place;
  Vector2 direction;  // horizontal direction of the normal, unit
  double z_m = 0;
  double gate_m = 0;
};

std::vector<SteepPoint> SteepPoints(const OrientedPoints& points, const Matrix3& R_LW) {
  const Eigen::Matrix3f R_WL = R_LW.transpose().cast<float>();
  std::vector<SteepPoint> steep;
  const std::size_t stride = (points.size() + kSearchPoints - 1) / kSearchPoints;
  for (std::size_t i = 0; i < points.size(); i += std::max<std::size_t>(stride, 1)) {
    const Vector2 n = (R_WL * points.normals[i]).head<2>().cast<double>();
    const double steepness = n.norm();
    if (steepness < kSteep_sin || !points.points[i].allFinite()) continue;
    const Vector3 p = (R_WL * points.points[i]).cast<double>();
    steep.push_back(
        {p.head<2>(), n / steepness, p.z(), kDistanceGate_sigma * double{points.sigma_m[i]}});
  }
  return steep;
}

bool Agrees(const SteepPoint& point, const Vector2& axis) {
  const Vector2 to = point.place - axis;
  const double miss_m = std::abs(to.x() * point.direction.y() - to.y() * point.direction.x());
  return miss_m <= std::max(kNoiseReach_m, kNormalMiss_sin * to.norm()) &&
         to.norm() <= kMaxVesselRadius_m;
}

double ShareAgreeing(const std::vector<SteepPoint>& steep, const Vector2& axis) {
  const auto agreeing =
      std::ranges::count_if(steep, [&](const SteepPoint& p) { return Agrees(p, axis); });
  return static_cast<double>(agreeing) / static_cast<double>(steep.size());
}

bool IsOutside(const SteepPoint& point, const Vector2& axis) {
  return (point.place - axis).dot(point.direction) > 0;
}

// The sector about the axis, counted from -180 degrees. It is computed without an angle because it
// is needed for every point about every axis that is tried.
std::size_t SectorOf(const Vector2& q) {
  constexpr std::array<double, 5> kTangents = {0.26794919243112270, 0.57735026918962576, 1.0,
                                               1.7320508075688773, 3.7320508075688773};
  static_assert(kSectors == 4 * (kTangents.size() + 1));
  const std::size_t quarter = q.y() < 0 ? (q.x() < 0 ? 0 : 1) : (q.x() >= 0 ? 2 : 3);
  const bool is_crossed = quarter % 2 == 1;  // this quarter begins at the y axis
  const double along = std::abs(is_crossed ? q.y() : q.x());
  const double across = std::abs(is_crossed ? q.x() : q.y());
  std::size_t sector = quarter * (kTangents.size() + 1);
  for (const double tangent : kTangents) sector += across >= tangent * along;
  return sector;
}

// The support of an axis by points all around it. The square root per sector limits flat faces,
// whose many normals pass by any axis far behind them.
double Support(const std::vector<SteepPoint>& steep, const Vector2& axis) {
  std::array<double, kSectors> agreeing{};
  for (const SteepPoint& p : steep) {
    if (Agrees(p, axis)) ++agreeing[SectorOf(p.place - axis)];
  }
  double sum = 0;
  for (const double count : agreeing) sum += std::sqrt(count);
  return sum;
}

// Returns the best axis that the lines of normals pass, from pairs of a few of them.
std::optional<Vector2> AxisOfNormals(const std::vector<SteepPoint>& all) {
  std::vector<SteepPoint> steep;
  for (std::size_t i = 0; i < all.size(); i += 1 + all.size() / kMaxVoters) steep.push_back(all[i]);
  std::mt19937_64 random(1);
  std::optional<Vector2> best;
  double max_support = 0;
  for (int k = 0; k < kPairs; ++k) {
    const SteepPoint& a = steep[random() % steep.size()];
    const SteepPoint& b = steep[random() % steep.size()];
    const double cross = a.direction.x() * b.direction.y() - a.direction.y() * b.direction.x();
    if (std::abs(cross) < kParallel_sin) continue;
    const Vector2 to = b.place - a.place;
    const double way_m = (to.x() * b.direction.y() - to.y() * b.direction.x()) / cross;
    const Vector2 axis = a.place + way_m * a.direction;
    if ((axis - a.place).norm() > kMaxVesselRadius_m) continue;
    const double support = Support(steep, axis);
    if (support > max_support) max_support = support, best = axis;
  }
  return best;
}

// A ring of the wall seen from one side.
struct Ring {
  std::vector<std::size_t> members;
  double radius_m = 0;  // median over sectors, which a handle hardly moves
};

enum class Order { kFirst, kLater };  // the order of the walls of one object

class WallFitter {
 public:
  WallFitter(std::vector<SteepPoint> steep, const Vector2& axis, Order order, double lean_sigma)
      : is_first_(order == Order::kFirst),
        lean_sigma_(lean_sigma),
        steep_(std::move(steep)),
        radius_m_(steep_.size()),
        on_ring_m_(steep_.size()) {
    wall_.foot = axis;
    wall_.low_z_m = std::numeric_limits<double>::infinity();
    wall_.high_z_m = -wall_.low_z_m;
    std::vector<double> gates;
    for (const SteepPoint& p : steep_) {
      gates.push_back(p.gate_m);
      if (!Agrees(p, axis)) continue;
      wall_.low_z_m = std::min(wall_.low_z_m, p.z_m);
      wall_.high_z_m = std::max(wall_.high_z_m, p.z_m);
    }
    wall_.middle_z_m = 0.5 * (wall_.low_z_m + wall_.high_z_m);
    wall_.step_m =
        std::max(kNoiseReach_m, kNoiseReach_sigma / kDistanceGate_sigma * Median(std::move(gates)));
  }

  std::optional<RevolvedWall> Fit() {
    for (const double gate : kGates) {
      FormRings();
      if (!Improve(gate)) return std::nullopt;
    }
    FormRings();
    if (!MostAgree()) return std::nullopt;
    MakeProfile();
    if (Median(wall_.outer_radius_m) < kMinRadius_m) return std::nullopt;
    return wall_;
  }

 private:
  std::size_t StepCount() const {
    return static_cast<std::size_t>((wall_.high_z_m - wall_.low_z_m) / wall_.step_m) + 1;
  }

  // Forms the outer and inner ring of each step. The height and normal of a point determine its
  // ring.
  void FormRings() {
    rings_.assign(2 * StepCount(), {});
    for (std::size_t i = 0; i < steep_.size(); ++i) {
      const SteepPoint& p = steep_[i];
      const Vector2 axis = wall_.AxisAt(p.z_m);
      radius_m_[i] = (p.place - axis).norm();
      on_ring_m_[i] = std::numeric_limits<double>::infinity();
      if (p.z_m < wall_.low_z_m || p.z_m > wall_.high_z_m || !Agrees(p, axis)) continue;
      const auto step = static_cast<std::size_t>((p.z_m - wall_.low_z_m) / wall_.step_m);
      rings_[2 * step + (IsOutside(p, axis) ? 0 : 1)].members.push_back(i);
    }
    for (Ring& ring : rings_) {
      if (ring.members.size() < kMinInRing) continue;
      ring.radius_m = MedianRadius_m(ring);
    }
    DropStrays();
    for (const Ring& ring : rings_) {
      if (ring.members.size() < kMinInRing) continue;
      for (std::size_t i : ring.members) on_ring_m_[i] = radius_m_[i] - ring.radius_m;
    }
  }

  // Drops rings of other objects whose normals happen to pass the axis. Going up and down from the
  // ring of most points, no wall steep enough to be seen widens or narrows that fast.
  void DropStrays() {
    const auto largest_ring = std::max_element(rings_.begin(), rings_.end(), [](auto& a, auto& b) {
      return a.members.size() < b.members.size();
    });
    if (largest_ring->members.size() < kMinInRing) return;
    const auto start = static_cast<std::size_t>(largest_ring - rings_.begin()) / 2;
    const double radius_m = largest_ring->radius_m;
    double reference_m = radius_m;
    std::size_t at = start;
    for (std::size_t step = start; step < StepCount(); ++step) KeepNear(step, at, reference_m);
    reference_m = radius_m, at = start;
    for (std::size_t step = start; step-- > 0;) KeepNear(step, at, reference_m);
  }

  // Empties those rings of the step that are far from `reference_m`, the radius at step `at`; the
  // others become the reference.
  void KeepNear(std::size_t step, std::size_t& at, double& reference_m) {
    const double rise_m = wall_.step_m * static_cast<double>(step > at ? step - at : at - step);
    double kept_m = std::numeric_limits<double>::quiet_NaN();
    for (std::size_t side : {1, 0}) {  // the outside decides if both are seen
      Ring& ring = rings_[2 * step + side];
      if (ring.members.size() < kMinInRing) continue;
      if (std::abs(ring.radius_m - reference_m) > kMaxSlope * rise_m + kMaxJump_m) {
        ring.members.clear();
      } else {
        kept_m = ring.radius_m;
      }
    }
    if (std::isnan(kept_m)) return;
    reference_m = kept_m;
    at = step;
  }

  double MedianRadius_m(const Ring& ring) const {
    std::array<std::vector<double>, kSectors> sectors;
    std::vector<double> all, medians;
    for (std::size_t i : ring.members) {
      const SteepPoint& p = steep_[i];
      sectors[SectorOf(p.place - wall_.AxisAt(p.z_m))].push_back(radius_m_[i]);
      all.push_back(radius_m_[i]);
    }
    for (std::vector<double>& sector : sectors) {
      if (sector.size() >= kMinForMedian) medians.push_back(Median(std::move(sector)));
    }
    return medians.size() >= kMinForMedian ? Median(std::move(medians)) : Median(std::move(all));
  }

  // One Gauss-Newton step toward round rings, each with its own radius, with Tukey's weights. False
  // if the points do not determine the axis.
  bool Improve(double gate) {
    using Row = Eigen::Vector4d;
    Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
    Row right = Row::Zero();
    for (const Ring& ring : rings_) {
      double weights = 0, mean_m = 0;
      Row mean = Row::Zero();
      std::vector<std::pair<double, Row>> rows;  // weight and gradient
      std::vector<double> residuals_m;
      for (std::size_t i : ring.members) {
        const SteepPoint& p = steep_[i];
        const double share = on_ring_m_[i] / (gate * p.gate_m);
        if (!(std::abs(share) < 1)) continue;
        const double sigma_m = p.gate_m / kDistanceGate_sigma;
        const double w = std::pow(1 - share * share, 2) / (sigma_m * sigma_m);
        const Vector2 away = (p.place - wall_.AxisAt(p.z_m)) / std::max(1e-6, radius_m_[i]);
        Row row;
        row << -away, -(p.z_m - wall_.middle_z_m) * away;
        rows.emplace_back(w, row);
        residuals_m.push_back(on_ring_m_[i]);
        weights += w;
        mean += w * row;
        mean_m += w * on_ring_m_[i];
      }
      if (rows.size() < kMinInRing) continue;
      mean /= weights;
      mean_m /= weights;
      for (std::size_t k = 0; k < rows.size(); ++k) {
        const Row row = rows[k].second - mean;
        normal += rows[k].first * row * row.transpose();
        right -= rows[k].first * (residuals_m[k] - mean_m) * row;
      }
    }
    normal /= kPointsPerIndependentSample;
    right /= kPointsPerIndependentSample;
    const double prior = 1 / (lean_sigma_ * lean_sigma_);
    normal.bottomRightCorner<2, 2>().diagonal().array() += prior;
    right.tail<2>() -= prior * wall_.lean;
    if (!(normal(0, 0) > 0 && normal(1, 1) > 0)) return false;
    const Row step = normal.ldlt().solve(right);
    if (!step.allFinite()) return false;
    wall_.foot += step.head<2>();
    wall_.lean += step.tail<2>();
    return true;
  }

  bool IsOn(std::size_t i) const { return std::abs(on_ring_m_[i]) <= steep_[i].gate_m; }

  bool MostAgree() const {
    std::size_t on = 0;
    std::array<std::size_t, kSectors> in_sector{};
    for (std::size_t i = 0; i < steep_.size(); ++i) {
      if (!IsOn(i)) continue;
      ++on;
      ++in_sector[SectorOf(steep_[i].place - wall_.AxisAt(steep_[i].z_m))];
    }
    const auto sectors = std::count_if(in_sector.begin(), in_sector.end(),
                                       [](std::size_t n) { return n >= kMinInRing; });
    const double share = static_cast<double>(on) / static_cast<double>(steep_.size());
    return on >= kMinSteep && ((is_first_ && 2 * on >= steep_.size() && sectors >= kMinSectors) ||
                               (share >= kMinOnRoundWall && sectors >= kRoundSectors));
  }

  void MakeProfile() {
    std::vector<double> radius_m;
    for (std::size_t step = 0; step < StepCount(); ++step) {
      const Ring &outside = rings_[2 * step], &inside = rings_[2 * step + 1];
      radius_m.push_back(outside.members.size() >= kMinInRing ? outside.radius_m
                         : inside.members.size() >= kMinInRing
                             ? inside.radius_m + kWallThickness_m
                             : std::numeric_limits<double>::quiet_NaN());
    }
    // Steps without points copy the radius from below, the lowest ones from above.
    for (std::size_t k = 1; k < radius_m.size(); ++k) {
      if (std::isnan(radius_m[k])) radius_m[k] = radius_m[k - 1];
    }
    for (std::size_t k = radius_m.size(); k-- > 1;) {
      if (std::isnan(radius_m[k - 1])) radius_m[k - 1] = radius_m[k];
    }
    // Each ring takes the median of itself and as many neighbours on either side, which removes
    // false rings such as those of a handle that points at the sensor.
    wall_.outer_radius_m = radius_m;
    for (std::size_t k = 1; k + 1 < radius_m.size(); ++k) {
      const std::size_t reach = std::min({kNearSteps, k, radius_m.size() - 1 - k});
      const auto middle = radius_m.begin() + static_cast<std::ptrdiff_t>(k);
      const auto side = static_cast<std::ptrdiff_t>(reach);
      wall_.outer_radius_m[k] = Median(std::vector<double>(middle - side, middle + side + 1));
    }
  }

  bool is_first_;
  double lean_sigma_;
  std::vector<SteepPoint> steep_;
  std::vector<double> radius_m_,
      on_ring_m_;            // per point: its radius, and its excess over the ring's radius
  std::vector<Ring> rings_;  // outer and inner ring of each step, upwards
  RevolvedWall wall_;
};

}  // namespace

double RevolvedWall::OuterRadius_m(double z_m) const {
  const double at = (z_m - low_z_m) / step_m - 0.5;
  const auto last = static_cast<double>(outer_radius_m.size() - 1);
  const double within = std::clamp(at, 0.0, last);
  const auto below = static_cast<std::size_t>(within);
  const std::size_t above = std::min(below + 1, outer_radius_m.size() - 1);
  return std::lerp(outer_radius_m[below], outer_radius_m[above],
                   within - static_cast<double>(below));
}

double RevolvedWall::Protrusion_m(const Vector3& p_L) const {
  const Vector3 p = R_LW.transpose() * p_L;
  return (p.head<2>() - AxisAt(p.z())).norm() - OuterRadius_m(p.z());
}

std::vector<RevolvedWall> FitRevolvedWalls(const OrientedPoints& points, const Work& work) {
  std::vector<SteepPoint> steep = SteepPoints(points, Matrix3::Identity());
  std::vector<RevolvedWall> walls;
  for (std::size_t k = 0; k < kMaxTries && steep.size() >= kMinSteep; ++k) {
    work.Poll();
    const std::optional<Vector2> axis = AxisOfNormals(steep);
    if (!axis) break;
    const std::optional<RevolvedWall> wall =
        WallFitter(steep, *axis, k == 0 ? Order::kFirst : Order::kLater, kLeanSigma).Fit();
    if (!wall) break;
    walls.push_back(*wall);
    std::erase_if(steep, [&](const SteepPoint& p) {
      return wall->Protrusion_m({p.place.x(), p.place.y(), p.z_m}) <= p.gate_m;
    });
  }
  return walls;
}

std::optional<RevolvedWall> FitRevolvedWall(const OrientedPoints& points, const Vector3& axis_L,
                                            AxisFreedom freedom, const Work& work) {
  const bool is_free = freedom == AxisFreedom::kFree;
  std::optional<RevolvedWall> wall;
  Vector3 along = axis_L;
  for (std::size_t k = 0; k < (is_free ? kMaxTries : 1); ++k) {
    work.Poll();
    const Matrix3 R_LW = BasisFromZ(along);
    std::vector<SteepPoint> steep = SteepPoints(points, R_LW);
    if (steep.size() < kMinSteep) return std::nullopt;
    const std::optional<Vector2> axis = AxisOfNormals(steep);
    if (!axis || ShareAgreeing(steep, *axis) < kMinOnRoundWall) return std::nullopt;
    wall = WallFitter(std::move(steep), *axis, Order::kFirst, is_free ? kFreeLeanSigma : kLeanSigma)
               .Fit();
    if (!wall) return std::nullopt;
    wall->R_LW = R_LW;
    along = wall->Axis();
    if (wall->lean.norm() < kTurned) break;
  }
  return wall;
}

}  // namespace cwm::perception
