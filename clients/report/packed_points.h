// The measured points of a labelled scan, small enough for a page.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "clients/formats/cloud_file.h"

namespace cwm::report {

// What is drawn of a scan at most; more would make a page of over 5 MB. A depth image of 640 x 480
// is drawn whole.
inline constexpr std::int64_t kMostPoints = 600'000;

struct PointRun {
  std::uint32_t label = 0;
  std::int64_t count = 0;  // of the points that are here

  friend bool operator==(const PointRun&, const PointRun&) = default;
};

// In the scan's own frame on a cubic grid, grouped by label: p = origin_m + step_m * (i, j, k).
struct PackedPoints {
  std::array<double, 3> origin_m = {};
  double step_m = 0;           // off by half of it at most
  std::vector<PointRun> runs;  // ascending labels
  std::string grid;            // i j k of each point, run by run, as little-endian uint16
  std::int64_t measured = 0;   // points of the scan with three finite coordinates
  std::int64_t every = 1;      // of each label's points, one of so many is here
};

struct LabelledCloud {
  const formats::CloudFile& cloud;           // has the fields x y z, one number each
  const std::vector<std::uint32_t>& labels;  // one a point
};

// Each label keeps its first point and then every n-th. A cloud without measured points has no runs.
PackedPoints PackPoints(const LabelledCloud& scan, std::int64_t most_points = kMostPoints);

}  // namespace cwm::report
