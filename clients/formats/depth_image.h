// Depth images: PNG of 16 bits or NPY of shape (H, W), with the pinhole of their camera.
#pragma once

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
};

// Reads a camera's file, JSON or YAML: fx, fy, cx and cy (or ppx and ppy), or the nine numbers of
// its matrix, row-major, as K, camera_matrix.data (ROS) or intrinsic_matrix (Open3D, column-major);
// depth_scale_m (or depth_scale) is the unit.
absl::StatusOr<DepthCamera> ParseDepthCamera(std::string_view text, const std::string& file);

// True for a PNG, and for an NPY of a plain array (H, W) or (H, W, 1) that is wider than a list of
// points.
bool IsDepthImage(std::string_view bytes);

// An organised cloud in the camera's optical frame (z forward, x right, y down), metres. Depths of
// 0, and such as are not finite, become points that are not finite. `unit_m` overrides the
// camera's.
absl::StatusOr<CloudFile> ParseDepthImage(std::string_view bytes, const std::string& file,
                                          const DepthCamera& camera,
                                          std::optional<double> unit_m = std::nullopt);

}  // namespace cwm::formats
