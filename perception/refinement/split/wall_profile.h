// How far a wall stands out along a line, in pieces that are straight: the radius of a round object
// along its axis.
#pragma once

#include <span>
#include <vector>

namespace cwm::perception {

// The wall at one place of the line: how far out it is, and one standard deviation of that.
struct ProfilePoint {
  double along_m = 0, offset_m = 0, sigma_m = 0;
};

// Part of a profile that one straight line describes, from its first point to its last.
struct ProfilePiece {
  double begin_m = 0, end_m = 0;                // along the line
  double begin_offset_m = 0, end_offset_m = 0;  // of the fitted line there
  double sigma_m = 0;                           // of these offsets
  double slope = 0, slope_sigma = 0;            // of the offset

  double length_m() const { return end_m - begin_m; }
};

// The pieces that describe the profile best: least squares, with a price for each piece after Schwarz
// (1978), by dynamic programming (Bellman 1961). Points ascend.
std::vector<ProfilePiece> StraightPieces(std::span<const ProfilePoint> profile);

// Places at which one object may end and the next begin, after the minima rule of Hoffman and Richards
// (1984), that parts meet in concave creases: where neighbouring pieces meet with a jump or a concave
// kink that is certain. Ascending.
std::vector<double> SeamsOf(std::span<const ProfilePoint> profile);

}  // namespace cwm::perception
