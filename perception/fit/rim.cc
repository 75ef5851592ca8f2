#include "perception/fit/rim.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "perception/cloud/decompositions.h"
#include "perception/cloud/quantile.h"

namespace cwm::perception {
namespace {

// derived: edges are sought this far to both sides of where the wall suggests them: three times the
// error of a wall's radius, and twice the noise across the ray (1.2 mm at 0.8 m).
constexpr double kRimReach_m = 0.008;
// chosen: as a share of the radius; the inner rest gives the density.
constexpr double kMaxReachShare = 0.4;
// derived: sectors are as long as that reach, four to five pixels at 0.8 m.
constexpr double kSectorArc_m = kRimReach_m;
// derived: the least number of edges, twice the unknowns of a circle.
constexpr int kMinEdges = Vector3::RowsAtCompileTime * 2;
// derived: twice as many, since half of the edges may be occluded.
constexpr int kMinRimSectors = kMinEdges * 2;
// chosen: bounds the work; sectors of discs of more than 6 cm are longer.
constexpr int kMaxRimSectors = 48;
// chosen: the least number of points that give a sector's density.
constexpr double kMinInWedge = 5;
// chosen: from 80 degrees of incidence on, a wall returns next to no points.
const double kHidden_cos = std::cos(80 * std::numbers::pi / 180);
// derived: half of the reach. Edges that scatter by more are spread all over it and form no circle.
constexpr double kMaxScatter_m = kRimReach_m / 2;
// chosen: the least scatter of an edge, a third of a pixel at 0.8 m, and the error common to a
// whole edge, a fifth of a pixel.
constexpr double kMinScatter_m = 0.0005, kCommon_m = 0.0003;
// derived: the squared Mahalanobis distance of three values that 0.1 % exceed.
constexpr double kContradiction = 16;

struct Edge {
  double angle_rad = 0;
  double radius_m = 0;
};

struct Circle {
  Vector2 center = Vector2::Zero();  // relative to the centre that edges were measured from
  double radius_m = 0;
  Matrix3 covariance = Matrix3::Zero();
  double scatter_m = 0;
  std::size_t edges = 0;  // the edges that agree with it
};

// Weighted counts of a sector's points: inside the band in which its edge is sought, and in the
// band.
struct Sector {
  double inside = 0, band = 0;
};

int SectorCount(double radius_m) {
  return std::clamp(static_cast<int>(2 * std::numbers::pi * radius_m / kSectorArc_m),
                    kMinRimSectors, kMaxRimSectors);
}

class FaceEdge {
 public:
  FaceEdge(const PlaneModel& face, const ConeModel& wall, const FitContext& c)
      : face_(face), wall_(wall), c_(c), basis_(BasisFromZ(face.normal)) {
    for (std::uint32_t i = 0; i < c.points.size(); ++i) {
      if (std::abs(face.Distance_m(c.points.p[i])) <= c.points.gate_m[i]) on_face_.push_back(i);
    }
  }

  const Matrix3& basis() const { return basis_; }

  // A first guess of the disc from its points alone: at even density, the mean squared distance
  // from the middle is half the squared radius. It is a few millimetres off if part of the disc is
  // occluded.
  Circle Guess() const {
    Vector2 middle = Vector2::Zero();
    double weights = 0, squares = 0;
    for (std::uint32_t i : on_face_) {
      middle += Weight(i) * Local(i);
      weights += Weight(i);
    }
    if (!(weights > 0)) return {};
    middle /= weights;
    for (std::uint32_t i : on_face_) squares += Weight(i) * (Local(i) - middle).squaredNorm();
    return {.center = middle, .radius_m = std::sqrt(2 * squares / weights)};
  }

  // Edges of all sectors that must end in a depth jump, about `center` and near `radius_m`.
  std::vector<Edge> EdgesAround(const Vector3& center, double radius_m) const {
    const double reach_m = std::min(kRimReach_m, kMaxReachShare * radius_m);
    const double inner_m = radius_m - reach_m, outer_m = radius_m + reach_m;
    const int count = SectorCount(radius_m);
    const double width_rad = 2 * std::numbers::pi / count;
    std::vector<Sector> sectors(static_cast<std::size_t>(count));
    for (std::uint32_t i : on_face_) {
      const Vector2 x = (basis_.transpose() * (c_.points.p[i] - center)).head<2>();
      const double rho_m = x.norm();
      if (rho_m > outer_m) continue;
      const double turn = std::atan2(x.y(), x.x()) / width_rad + count;
      Sector& sector = sectors[static_cast<std::size_t>(turn) % sectors.size()];
      (rho_m < inner_m ? sector.inside : sector.band) += Weight(i);
    }
    std::vector<Edge> edges;
    for (int k = 0; k < count; ++k) {
      const Sector& sector = sectors[static_cast<std::size_t>(k)];
      const double angle_rad = (k + 0.5) * width_rad;
      if (sector.inside < kMinInWedge || !EndsInJump(center, radius_m, angle_rad)) continue;
      // A wedge of this density that ends at the edge holds all of the sector's points.
      edges.push_back({angle_rad, inner_m * std::sqrt(1 + sector.band / sector.inside)});
    }
    return edges;
  }

 private:
  // Position on the face, relative to its reference point.
  Vector2 Local(std::uint32_t i) const {
    return (basis_.transpose() * (c_.points.p[i] - face_.point)).head<2>();
  }

  // The weight that makes the density even: the density of pixels on a plane falls with the range
  // cubed.
  double Weight(std::uint32_t i) const {
    const double range_m = (c_.points.p[i] - c_.points.viewpoint).norm();
    const double mean_m = (face_.point - c_.points.viewpoint).norm();
    const double ratio = range_m / mean_m;
    return ratio * ratio * ratio;
  }

  bool EndsInJump(const Vector3& center, double radius_m, double angle_rad) const {
    const Vector3 outward =
        std::cos(angle_rad) * basis_.col(0) + std::sin(angle_rad) * basis_.col(1);
    const Vector3 at = center + radius_m * outward;
    return wall_.Normal(at).dot((c_.points.viewpoint - at).normalized()) < kHidden_cos;
  }

  const PlaneModel& face_;
  const ConeModel& wall_;
  const FitContext& c_;
  Matrix3 basis_;
  std::vector<std::uint32_t> on_face_;
};

// Fits radius(angle) = r + x cos(angle) + y sin(angle), for small x and y. Edges beyond the noise
// of most belong to sectors that are partly occluded, and are dropped.
std::optional<Circle> FitCircle(std::vector<Edge> edges) {
  Circle circle;
  for (int round = 0; round < kFitRounds; ++round) {
    if (edges.size() < kMinEdges) return std::nullopt;
    Matrix3 normal = Matrix3::Zero();
    Vector3 right = Vector3::Zero();
    for (const Edge& e : edges) {
      const Vector3 row(std::cos(e.angle_rad), std::sin(e.angle_rad), 1);
      normal += row * row.transpose();
      right += e.radius_m * row;
    }
    if (std::abs(normal.determinant()) < 1e-3) return std::nullopt;  // too short an arc
    const Vector3 x = SolveSymmetric(normal, right);
    const auto residual_m = [&x](const Edge& e) {
      return e.radius_m - x.x() * std::cos(e.angle_rad) - x.y() * std::sin(e.angle_rad) - x.z();
    };
    std::vector<double> misses;
    for (const Edge& e : edges) misses.push_back(std::abs(residual_m(e)));
    // derived: a Gaussian's standard deviation is 1.48 times its median absolute deviation.
    const double scatter_m = std::max(kMinScatter_m, 1.48 * Quantile(std::move(misses), 0.5));
    if (scatter_m > kMaxScatter_m) return std::nullopt;
    circle = {.center = x.head<2>(),
              .radius_m = x.z(),
              .covariance = scatter_m * scatter_m * normal.inverse() +
                            kCommon_m * kCommon_m * Matrix3::Identity(),
              .scatter_m = scatter_m};
    std::erase_if(edges, [&](const Edge& e) {
      return std::abs(residual_m(e)) > kDistanceGate_sigma * scatter_m;
    });
    circle.edges = edges.size();
  }
  return circle;
}

// The derivatives of a wall's cross section at a height, its centre and radius, by the wall's
// parameters.
Eigen::Matrix<double, 3, CylinderModel::kParameterCount> SectionAt(const CylinderModel&,
                                                                   double height_m) {
  Eigen::Matrix<double, 3, CylinderModel::kParameterCount> rows;
  rows << 1, 0, height_m, 0, 0,  //
      0, 1, 0, height_m, 0,      //
      0, 0, 0, 0, 1;
  return rows;
}
Eigen::Matrix<double, 3, ConeModel::kParameterCount> SectionAt(const ConeModel&, double height_m) {
  Eigen::Matrix<double, 3, ConeModel::kParameterCount> rows;
  rows << 1, 0, height_m, 0, 0, 0,  //
      0, 1, 0, height_m, 0, 0,      //
      0, 0, 0, 0, 1, height_m;
  return rows;
}

}  // namespace

std::optional<Rim> MeasureRim(const PlaneModel& face, const ConeModel& wall, double wall_sigma_m,
                              const FitContext& context) {
  const double along = face.normal.dot(wall.axis);
  if (std::abs(along) < 0.5) return std::nullopt;  // the face is not across this axis
  const double height_m = face.normal.dot(face.point - wall.point) / along;
  const FaceEdge edge(face, wall, context);
  Rim rim{.center = wall.point + height_m * wall.axis,
          .radius_m = wall.RadiusAt_m(height_m),
          .basis = edge.basis()};
  if (kDistanceGate_sigma * wall_sigma_m > kRimReach_m) {
    const Circle disc = edge.Guess();
    rim.center = face.point + rim.basis.leftCols<2>() * disc.center;
    rim.radius_m = disc.radius_m;
  }
  for (int round = 0; round < kFitRounds; ++round) {
    if (!(rim.radius_m > context.options.min_radius_m)) return std::nullopt;
    const auto circle = FitCircle(edge.EdgesAround(rim.center, rim.radius_m));
    if (!circle) return std::nullopt;
    rim.seen = static_cast<double>(circle->edges) / SectorCount(rim.radius_m);
    rim.center += rim.basis.leftCols<2>() * circle->center;
    rim.radius_m = circle->radius_m;
    rim.covariance = circle->covariance;
    rim.scatter_m = circle->scatter_m;
  }
  return rim;
}

std::optional<Rim> MeasureRim(const PlaneModel& face, const FitContext& context) {
  const ConeModel nowhere{.point = face.point, .axis = face.normal};
  const Circle disc = FaceEdge(face, nowhere, context).Guess();
  ConeModel wall = nowhere;
  wall.point += BasisFromZ(face.normal).leftCols<2>() * disc.center;
  wall.radius_m = disc.radius_m;
  return MeasureRim(face, wall, kRimReach_m, context);
}

template <class M>
M FuseRim(const M& wall, const Rim& rim, Eigen::MatrixXd& covariance) {
  const ConeModel& cone = wall.AsCone();
  const double height_m = cone.axis.dot(rim.center - cone.point);
  const Matrix3 across = BasisFromZ(cone.axis);
  const Vector3 off = rim.center - (cone.point + height_m * cone.axis);
  const Vector3 innovation(across.col(0).dot(off), across.col(1).dot(off),
                           rim.radius_m - cone.RadiusAt_m(height_m));
  // The face is nearly normal to the axis, so its centre's covariance is rotated by the change of
  // basis alone.
  Matrix3 turn = Matrix3::Identity();
  turn.topLeftCorner<2, 2>() = across.leftCols<2>().transpose() * rim.basis.leftCols<2>();
  const Matrix3 noise = turn * rim.covariance * turn.transpose();
  const auto rows = SectionAt(wall, height_m);
  const Matrix3 spread = rows * covariance * rows.transpose() + noise;
  const Matrix3 inverse = spread.inverse();
  if (!(innovation.dot(inverse * innovation) < kContradiction)) return wall;
  const Eigen::Matrix<double, M::kParameterCount, 3> gain = covariance * rows.transpose() * inverse;
  const typename M::Parameters step = gain * innovation;
  covariance = (covariance - gain * rows * covariance).eval();
  return wall.Moved(step);
}

template CylinderModel FuseRim(const CylinderModel&, const Rim&, Eigen::MatrixXd&);
template ConeModel FuseRim(const ConeModel&, const Rim&, Eigen::MatrixXd&);

}  // namespace cwm::perception
