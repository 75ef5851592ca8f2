// Depth images that are drawn pixel by pixel.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "perception/cloud/measured_points.h"

namespace cwm::perception {

struct DrawnFormat {
  int width, height;
  float focal_px;
};

// The measurement of a Kinect at the origin that looks along z: the depth at (row, column), NaN for
// no return. All normals point against z, like those of a wall that faces the sensor.
inline MeasuredPoints DrawnImage(const DrawnFormat& format,
                                 const std::function<float(int, int)>& depth_m) {
  PointCloud cloud;
  cloud.width = format.width;
  cloud.height = format.height;
  for (int v = 0; v < format.height; ++v) {
    for (int u = 0; u < format.width; ++u) {
      const Eigen::Vector3f ray(static_cast<float>(u - format.width / 2) / format.focal_px,
                                static_cast<float>(v - format.height / 2) / format.focal_px, 1);
      cloud.points.push_back(ray * depth_m(v, u));
    }
  }
  MeasuredPoints measured = *CollectMeasured(cloud, {});
  for (Eigen::Vector3f& normal : measured.oriented.normals) normal = -Eigen::Vector3f::UnitZ();
  return measured;
}

// The row and the column of the pixel of a node.
inline int RowOf(const MeasuredPoints& measured, std::size_t node) {
  return static_cast<int>(measured.oriented.cloud_index[node]) / measured.width;
}
inline int ColumnOf(const MeasuredPoints& measured, std::size_t node) {
  return static_cast<int>(measured.oriented.cloud_index[node]) % measured.width;
}

// The value that all returning pixels of a column share, from values per node.
inline std::int32_t OfColumn(const MeasuredPoints& measured,
                             const std::vector<std::int32_t>& of_node, int column) {
  std::vector<std::int32_t> found;
  for (std::size_t i = 0; i < measured.oriented.size(); ++i) {
    if (ColumnOf(measured, i) == column) found.push_back(of_node[i]);
  }
  EXPECT_EQ(found, std::vector<std::int32_t>(found.size(), found.at(0))) << column;
  return found.at(0);
}

}  // namespace cwm::perception
