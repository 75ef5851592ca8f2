#include "perception/solids/box_solid.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

// derived: the sine of the largest angle between a face and the normal of one that is orthogonal to
// it.
const double kOrthogonal_sin = std::sin(kSameDirection_rad);
// chosen: points of each face for measuring gaps; far denser than kEdgeLoss_m.
constexpr std::size_t kGapPoints = 150;

const PlaneModel& PlaneOf(const ShapeFit& fit) { return std::get<PlaneModel>(fit.model); }

double Gap_m(const ShapeFit& a, const ShapeFit& b, const ModelPoints& points) {
  double min_squared_m2 = std::numeric_limits<double>::infinity();
  const std::vector<std::uint32_t> of_b = Subsampled(b.inliers, kGapPoints);
  for (std::uint32_t i : Subsampled(a.inliers, kGapPoints)) {
    for (std::uint32_t j : of_b) {
      min_squared_m2 = std::min(min_squared_m2, (points.p[i] - points.p[j]).squaredNorm());
    }
  }
  return std::sqrt(min_squared_m2);
}

bool LiesBehind(const ShapeFit& face, const PlaneModel& plane, const ModelPoints& points) {
  std::size_t behind = 0;
  for (std::uint32_t i : face.inliers) {
    behind += plane.Distance_m(points.p[i]) <= points.gate_m[i] ? 1 : 0;
  }
  return static_cast<double>(behind) >= kNearlyAll * static_cast<double>(face.inliers.size());
}

bool FormEdge(const ShapeFit& a, const ShapeFit& b, const FitContext& c) {
  c.work.Poll();
  const double spread = std::sqrt(static_cast<double>(
      std::max<std::size_t>(1, std::max(a.inliers.size(), b.inliers.size()) / kGapPoints)));
  return std::abs(PlaneOf(a).normal.dot(PlaneOf(b).normal)) < kOrthogonal_sin &&
         LiesBehind(a, PlaneOf(b), c.points) && LiesBehind(b, PlaneOf(a), c.points) &&
         Gap_m(a, b, c.points) < kEdgeLoss_m + spread * c.points.spacing_m;
}

// The rotation nearest to the faces' normals, each weighted by its number of points. An axis that
// is upright within the noise becomes exactly upright.
Matrix3 AxesOf(const BoxFaces& faces, const std::vector<ShapeFit>& fits, const Vector3& up) {
  Matrix3 columns = Matrix3::Zero();
  double total = 0;
  for (std::size_t k = 0; k < faces.size(); ++k) {
    const auto weight = static_cast<double>(fits[faces[k]].inliers.size());
    columns.col(static_cast<Eigen::Index>(k)) = weight * PlaneOf(fits[faces[k]]).normal;
    total += weight;
  }
  if (faces.size() == 2) {
    columns.col(2) = total * columns.col(0).normalized().cross(columns.col(1).normalized());
  }
  const Eigen::JacobiSVD<Matrix3> svd(columns, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3 R = svd.matrixU() * svd.matrixV().transpose();
  if (R.determinant() < 0) R.col(2) = -R.col(2);  // a left-handed corner; the signs are arbitrary
  R = CanonicalBoxAxes(R);
  if (R.col(2).dot(up) > std::cos(kUprightWithin_rad)) {
    R.col(2) = up;
    R.col(0) = (R.col(0) - R.col(0).dot(up) * up).normalized();
    R.col(1) = R.col(2).cross(R.col(0));
  }
  return R;
}

// The points of all faces; a point on several faces is listed several times.
std::vector<std::uint32_t> AllCovered(const BoxFaces& faces, const std::vector<ShapeFit>& fits) {
  std::vector<std::uint32_t> all;
  for (std::size_t k : faces) {
    all.insert(all.end(), fits[k].covered.begin(), fits[k].covered.end());
  }
  return all;
}

// The weighted mean position of the face's points along `axis`.
double FaceOffset_m(const ShapeFit& face, const Vector3& axis, const ModelPoints& points) {
  double sum = 0, weights = 0;
  for (std::uint32_t i : face.inliers) {
    const double weight = 1 / (points.sigma_m[i] * points.sigma_m[i]);
    sum += weight * axis.dot(points.p[i]);
    weights += weight;
  }
  return sum / weights;
}

// Moves the bottom to the ground if it ends just above it unseen, or below it.
void StandOnGround(const Matrix3& R, const Ground& ground, bool bottom_seen, Vector3& low,
                   const Vector3& high) {
  if (!ground.known || R.col(2).dot(ground.up) < std::cos(kSameDirection_rad)) return;
  // Heights of the four corners of the bottom face; z of the box is nearly up.
  double lowest_m = std::numeric_limits<double>::infinity();
  for (int corner = 0; corner < 4; ++corner) {
    const Vector3 p((corner & 1) ? low.x() : high.x(), (corner & 2) ? low.y() : high.y(), low.z());
    lowest_m = std::min(lowest_m, ground.Height_m(R * p));
  }
  if (lowest_m < 0 || (!bottom_seen && lowest_m < kStandingGap_m)) {
    low.z() -= lowest_m / R.col(2).dot(ground.up);
  }
}

}  // namespace

Matrix3 CanonicalBoxAxes(const Matrix3& R) {
  Eigen::Index z = 0, x = 0;
  R.row(2).cwiseAbs().maxCoeff(&z);
  Eigen::RowVector3d along_x = R.row(0).cwiseAbs();
  along_x(z) = -1;
  along_x.maxCoeff(&x);
  Matrix3 out;
  out.col(2) = R(2, z) < 0 ? Vector3(-R.col(z)) : Vector3(R.col(z));
  out.col(0) = R(0, x) < 0 ? Vector3(-R.col(x)) : Vector3(R.col(x));
  out.col(1) = out.col(2).cross(out.col(0));
  return out;
}

std::optional<BoxFaces> FindBoxFaces(const std::vector<ShapeFit>& fits,
                                     const std::vector<char>& used, const FitContext& context) {
  std::vector<std::size_t> planes;
  for (std::size_t k = 0; k < fits.size(); ++k) {
    if (!used[k] && IsPlane(fits[k].model)) planes.push_back(k);
  }
  std::stable_sort(planes.begin(), planes.end(), [&](std::size_t a, std::size_t b) {
    return fits[a].inliers.size() > fits[b].inliers.size();
  });
  for (std::size_t seed : planes) {
    BoxFaces faces{seed};
    for (std::size_t other : planes) {
      if (faces.size() == 3) break;
      if (other == seed) continue;
      const bool fits_all = std::all_of(faces.begin(), faces.end(), [&](std::size_t face) {
        return FormEdge(fits[face], fits[other], context);
      });
      if (fits_all) faces.push_back(other);
    }
    if (faces.size() >= 2) return faces;
  }
  return std::nullopt;
}

Solid MakeBox(const BoxFaces& faces, const std::vector<ShapeFit>& fits, const FitContext& context,
              const Ground& ground) {
  const Matrix3 R = AxesOf(faces, fits, ground.up);
  Solid solid;
  std::vector<std::uint32_t> covered = AllCovered(faces, fits);
  Vector3 low, high;
  bool bottom_seen = false;
  for (int k = 0; k < 3; ++k) {
    const Interval extent = ExtentAlong(R.col(k), context.points, covered, Density::kFading);
    low(k) = extent.low_m, high(k) = extent.high_m;
    for (std::size_t face : faces) {
      const double along = PlaneOf(fits[face]).normal.dot(R.col(k));
      if (std::abs(along) < std::sqrt(0.5)) continue;  // its normal is another axis
      (along > 0 ? high : low)(k) = FaceOffset_m(fits[face], R.col(k), context.points);
      if (k == 2 && along < 0) bottom_seen = true;
    }
  }
  StandOnGround(R, ground, bottom_seen, low, high);
  std::ranges::sort(covered);
  covered.erase(std::unique(covered.begin(), covered.end()), covered.end());
  solid.inliers = std::move(covered);
  high = high.cwiseMax(low + Vector3::Constant(kMinThickness_m));
  solid.shape = Box{.size_m = high - low};
  solid.X_MS.linear() = R;
  solid.X_MS.translation() = R * (0.5 * (low + high));
  return solid;
}

}  // namespace cwm::perception
