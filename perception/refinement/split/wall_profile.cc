#include "perception/refinement/split/wall_profile.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include "perception/cloud/quantile.h"
#include "perception/cloud/tolerances.h"
#include "perception/vessels/revolved_wall.h"

namespace cwm::perception {
namespace {

// derived: a line has two parameters and a border; each costs ln(n) for n points.
constexpr double kParametersOfPiece = 3;
constexpr std::size_t kMinPointsOfPiece = 2;  // derived: the points of a line
// chosen: the least change of slope, 6 degrees; many cups open by more.
constexpr double kMinKink = 0.1;
// chosen: the error of the median of one step by quantisation.
constexpr double kStepTolerance_m = 0.0003;

// Weighted sums over the first points; differences give the line through any consecutive points.
struct Sums {
  double w = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;

  void Add(const ProfilePoint& p) {
    const double weight = 1 / (p.sigma_m * p.sigma_m);
    w += weight, x += weight * p.along_m, y += weight * p.offset_m;
    xx += weight * p.along_m * p.along_m, xy += weight * p.along_m * p.offset_m;
    yy += weight * p.offset_m * p.offset_m;
  }
  Sums Minus(const Sums& o) const {
    return {w - o.w, x - o.x, y - o.y, xx - o.xx, xy - o.xy, yy - o.yy};
  }
};

struct Line {
  double at_zero_m = 0, slope = 0;
  double slope_sigma = std::numeric_limits<double>::infinity();
  double squares = 0;  // of the residuals in standard deviations

  double At(double along_m) const { return at_zero_m + slope * along_m; }
};

Line LineThrough(const Sums& s) {
  Line line;
  const double determinant = s.w * s.xx - s.x * s.x;
  if (determinant > 1e-12 * s.w * s.xx) {
    line.slope = (s.w * s.xy - s.x * s.y) / determinant;
    line.slope_sigma = std::sqrt(s.w / determinant);
  }
  line.at_zero_m = (s.y - line.slope * s.x) / s.w;
  line.squares = std::max(0.0, s.yy - line.at_zero_m * s.y - line.slope * s.xy);
  return line;
}

ProfilePiece PieceOf(std::span<const ProfilePoint> points) {
  Sums sums;
  for (const ProfilePoint& p : points) sums.Add(p);
  const Line line = LineThrough(sums);
  const double begin_m = points.front().along_m, end_m = points.back().along_m;
  return {.begin_m = begin_m,
          .end_m = end_m,
          .begin_offset_m = line.At(begin_m),
          .end_offset_m = line.At(end_m),
          .sigma_m = 2 / std::sqrt(sums.w),  // at the end of a line twice that in its middle
          .slope = line.slope,
          .slope_sigma = line.slope_sigma};
}

// True if the offset jumps by more than noise. Warp is smooth and does not jump.
bool Jumps(const ProfilePiece& piece, const ProfilePiece& next) {
  const double jump_m = std::abs(next.begin_offset_m - piece.end_offset_m);
  return jump_m > kGroundNoise_m &&
         jump_m > kNoiseReach_sigma * std::hypot(piece.sigma_m, next.sigma_m);
}

// True if the wall turns outward: a concave crease.
bool TurnsOutward(const ProfilePiece& piece, const ProfilePiece& next) {
  if (std::min(piece.length_m(), next.length_m()) < kMinKinked_m) return false;
  const double turn = next.slope - piece.slope;
  return turn > kMinKink &&
         turn > kNoiseReach_sigma * std::hypot(piece.slope_sigma, next.slope_sigma);
}

}  // namespace

void ProfileBuilder::Add(double along_m, double offset_m, double sigma_m) {
  Step& step = steps_[std::lround(std::floor(along_m / kGroundNoise_m))];
  step.offsets_m.push_back(offset_m);
  step.along_m += along_m;
  step.sigma_m += sigma_m;
}

std::vector<ProfilePoint> ProfileBuilder::Profile() const {
  // The ratio of the sigma of a median to that of a mean, for normal noise.
  const double of_median = std::sqrt(std::numbers::pi / 2);
  std::vector<ProfilePoint> profile;
  for (const auto& [at, step] : steps_) {
    if (step.offsets_m.size() < kMinInRing) continue;
    const auto count = static_cast<double>(step.offsets_m.size());
    const double samples = std::max(1.0, count / points_per_sample_);
    const double sigma_m = of_median * step.sigma_m / count / std::sqrt(samples);
    profile.push_back({.along_m = step.along_m / count,
                       .offset_m = Quantile(step.offsets_m, 0.5),
                       .sigma_m = std::hypot(sigma_m, kStepTolerance_m)});
  }
  return profile;
}

std::vector<ProfilePiece> StraightPieces(std::span<const ProfilePoint> profile) {
  const std::size_t count = profile.size();
  if (count < kMinPointsOfPiece) return {};
  std::vector<Sums> before(count + 1);
  for (std::size_t i = 0; i < count; ++i) {
    before[i + 1] = before[i];
    before[i + 1].Add(profile[i]);
  }
  const double price = kParametersOfPiece * std::log(static_cast<double>(count));
  // The least cost of the first `end` points, and the beginning of their last piece.
  std::vector<double> cost(count + 1, std::numeric_limits<double>::infinity());
  std::vector<std::size_t> begin_of(count + 1, 0);
  cost[0] = 0;
  for (std::size_t end = kMinPointsOfPiece; end <= count; ++end) {
    for (std::size_t begin = 0; begin + kMinPointsOfPiece <= end; ++begin) {
      const Line line = LineThrough(before[end].Minus(before[begin]));
      const double total = cost[begin] + price + line.squares;
      if (total < cost[end]) cost[end] = total, begin_of[end] = begin;
    }
  }
  std::vector<ProfilePiece> pieces;
  for (std::size_t end = count; end > 0; end = begin_of[end]) {
    pieces.push_back(PieceOf(profile.subspan(begin_of[end], end - begin_of[end])));
  }
  std::ranges::reverse(pieces);
  return pieces;
}

std::vector<double> SeamsOf(std::span<const ProfilePoint> profile) {
  const std::vector<ProfilePiece> pieces = StraightPieces(profile);
  std::vector<double> seams;
  for (std::size_t k = 0; k + 1 < pieces.size(); ++k) {
    const ProfilePiece &piece = pieces[k], &next = pieces[k + 1];
    if (Jumps(piece, next) || TurnsOutward(piece, next)) {
      seams.push_back(0.5 * (piece.end_m + next.begin_m));
    }
  }
  return seams;
}

}  // namespace cwm::perception
