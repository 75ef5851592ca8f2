// The measured points of a labelled scan, compressed for a page.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "clients/formats/cloud_file.h"

namespace cwm::report {

// chosen: the most points drawn of a scan; more would give a page of over 5 MB. A depth image of
// 640 x 480 is drawn completely.
inline constexpr std::int64_t kMaxPoints = 600'000;

struct PointRun {
  std::uint32_t label = 0;
  std::int64_t count = 0;  // of the points kept

  friend bool operator==(const PointRun&, const PointRun&) = default;
};

// Points in the scan's own frame on a cubic grid, grouped by label: p = origin_m + step_m * (i, j,
// k).
struct PackedPoints {
  std::array<double, 3> origin_m = {};
  double step_m = 0;           // the error is at most half of it
  std::vector<PointRun> runs;  // ascending labels
  std::string grid;            // i j k of each point, run by run, as little-endian uint16
  std::int64_t measured = 0;   // points of the scan with three finite coordinates
  std::int64_t every = 1;      // one of so many points of each label is kept
};

struct LabelledCloud {
  const formats::CloudFile& cloud;           // must have the fields x y z, one number each
  const std::vector<std::uint32_t>& labels;  // one per point
  double scale = 1;                          // metres per unit of the coordinates
};

// Each label keeps its first point and every n-th after it. A cloud without measured points has no
// runs.
PackedPoints PackPoints(const LabelledCloud& scan, std::int64_t max_points = kMaxPoints);

}  // namespace cwm::report
