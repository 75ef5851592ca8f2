// A proposed grasp, not checked for collisions yet.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace cwm::grasp {

struct Candidate {
  Eigen::Isometry3d X_FG = Eigen::Isometry3d::Identity();  // the grasp in the sampler's frame
  double width_m = 0;         // between the surfaces that the pads would touch
  double tilt_rad = 0;        // between the surfaces and the closing direction
  double sigma_m = 0;         // standard deviation of the width; 0: unknown
  double retraction_m = 0;    // distance of the pads from the closing line, against the approach
  std::string strategy = {};  // "box faces", "cylinder wall", "rim", "handle" ...
};

// The result of a sampler. Widths that do not fit between the pads give no candidates, but are
// recorded.
struct Candidates {
  std::vector<Candidate> list = {};
  double min_width_m = -1;   // smallest width tried; < 0: none
  double min_tilt_rad = -1;  // of walls that slip; < 0: none

  void Append(const Candidates& other);
  void RecordWidth(double width_m);
  void RecordSlip(double tilt_rad);
};

}  // namespace cwm::grasp
