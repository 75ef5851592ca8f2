// Depth images: PNG of 16 bits or NPY of shape (H, W), with the pinhole of their camera.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "clients/formats/cloud_file.h"

namespace cwm::formats {

// x = (u - cx) z / fx and y = (v - cy) z / fy at column u and row v, both from 0, at depth z along
// the optical axis. Distortion of the lens is not modelled.
struct DepthCamera {
  double fx_px = 0, fy_px = 0;  // positive
  double cx_px = 0, cy_px = 0;
  // Metres per unit of the image's numbers. Empty: 0.001 for integers, 1 for floats.
  std::optional<double> unit_m = {};
  // Facts about the sensor. Empty: the file does not say them.
  std::string sensor_model = {};  // "kinect", or a standard deviation in metres
  std::optional<double> min_range_m = {}, max_range_m = {};
};

// Depths along the optical axis as they are sent: row-major, little-endian.
struct DepthImage {
  std::int64_t width = 0, height = 0;
  Scalar type = Scalar::kU16;  // or kF32
  double unit_m = 0.001;       // metres per unit, unless the camera or the caller says otherwise
  std::string bytes = {};
};

// Reads a camera's file, JSON or YAML: fx, fy, cx and cy (or ppx and ppy), or the nine numbers of
// its matrix, row-major, as K, camera_matrix.data (ROS) or intrinsic_matrix (Open3D, column-major);
// depth_unit_m, depth_scale_m or depth_scale is the unit; sensor_model (with sigma_m, if it is
// "given"), min_range_m and max_range_m are facts. A file of nine numbers alone is the matrix.
absl::StatusOr<DepthCamera> ParseDepthCamera(std::string_view text, const std::string& file);

// True for a PNG, and for an NPY of a plain array (H, W) or (H, W, 1) that is wider than a list of
// points.
bool IsDepthImage(std::string_view bytes);

// The image as it is. Integers of more than 16 bits or with a sign become floats of the same unit.
absl::StatusOr<DepthImage> ReadDepthImage(std::string_view bytes, const std::string& file);

// An organised cloud in the camera's optical frame (z forward, x right, y down), metres. Depths of
// 0, 65535 of 16 bits, and such as are not finite, become points that are not finite. `unit_m`
// overrides the camera's.
absl::StatusOr<CloudFile> ParseDepthImage(std::string_view bytes, const std::string& file,
                                          const DepthCamera& camera,
                                          std::optional<double> unit_m = std::nullopt);

}  // namespace cwm::formats
