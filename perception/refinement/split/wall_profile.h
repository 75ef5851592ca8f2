// The offset of a wall along a line, in straight pieces, such as the radius of a round object along
// its axis.
#pragma once

#include <map>
#include <span>
#include <vector>

namespace cwm::perception {

// chosen: a kink counts only between walls at least this long, since shorter ones do not show their
// slope well. Jumps do not ask for it. Parts of a row are at least as long.
inline constexpr double kMinKinked_m = 0.015;

// The wall at one place of the line: its offset, with one standard deviation.
struct ProfilePoint {
  double along_m = 0, offset_m = 0, sigma_m = 0;
};

// The profile of a wall's points: medians in steps of the accuracy of heights (kGroundNoise_m).
// Steps with few points are left out.
class ProfileBuilder {
 public:
  explicit ProfileBuilder(double points_per_sample) : points_per_sample_(points_per_sample) {}

  void Add(double along_m, double offset_m, double sigma_m);
  // Ascending.
  std::vector<ProfilePoint> Profile() const;

 private:
  struct Step {
    std::vector<double> offsets_m;
    double along_m = 0, sigma_m = 0;  // sums
  };

  double points_per_sample_;
  std::map<long, Step> steps_;
};

// The part of a profile that one straight line describes, from its first point to its last.
struct ProfilePiece {
  double begin_m = 0, end_m = 0;                // along the line
  double begin_offset_m = 0, end_offset_m = 0;  // of the fitted line there
  double sigma_m = 0;                           // of these offsets
  double slope = 0, slope_sigma = 0;            // of the offset

  double length_m() const { return end_m - begin_m; }
};

// The pieces that describe the profile best: least squares with a price per piece (Schwarz 1978),
// by dynamic programming (Bellman 1961). Points are ascending.
std::vector<ProfilePiece> StraightPieces(std::span<const ProfilePoint> profile);

// Places at which one object may end and the next begin, by the minima rule of Hoffman and Richards
// (1984) that parts meet in concave creases: neighbouring pieces with a significant jump between
// them, or a concave kink if both are at least kMinKinked_m long. Ascending.
std::vector<double> SeamsOf(std::span<const ProfilePoint> profile);

}  // namespace cwm::perception
