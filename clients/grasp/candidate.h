// A way to take something, before anybody has asked whether there is room.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace cwm::grasp {

struct Candidate {
  Eigen::Isometry3d X_FG = Eigen::Isometry3d::Identity();  // of the grasp in the sampler's frame
  double width_m = 0;       // between the surfaces that the pads are to touch
  double tilt_rad = 0;      // of the surfaces against the closing direction
  double sigma_m = 0;       // one standard deviation of the width; 0: unknown
  double drawn_back_m = 0;  // of the pads, from the line that they close on, against the approach
  std::string way = {};     // "box faces", "cylinder wall", "rim", "handle" ...
};

// What a sampler found. Widths that do not fit between the pads make no candidates, but are told.
struct Candidates {
  std::vector<Candidate> list = {};
  double narrowest_m = -1;     // width of all that was tried; < 0: nothing was
  double least_tilt_rad = -1;  // of the walls that slip; < 0: none did

  void Append(const Candidates& other);
  void NoteWidth(double width_m);
  void NoteSlip(double tilt_rad);
};

}  // namespace cwm::grasp
