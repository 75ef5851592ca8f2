// Depth images in messages: their layout, which is checked before any data, and their bytes.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include "absl/status/statusor.h"
#include "cwm/v1/perception.pb.h"
#include "perception/cloud/point_cloud.h"
#include "perception/live/depth_image.h"
#include "server/wire/field_path.h"

namespace cwm::server {

// chosen: the largest edge of an image; what is larger is no depth camera.
inline constexpr std::int64_t kMaxImageEdge_px = 16'384;

// A checked layout.
struct DepthPlan {
  bool is_float = false;  // F32, otherwise U16
  double unit_m = 0.001;
  perception::DepthCamera camera = {};  // the sender sets its ranges

  std::int64_t byte_count() const {
    return static_cast<std::int64_t>(camera.pixel_count()) * (is_float ? 4 : 2);
  }
};

// Every depth is within range: the caller restricts it. A focal length is from 0.04 to 30 edges of
// the image (170 to 2 degrees), or to 10,000 pixels for a part of an image; the centre is at most
// one edge off the image.
absl::StatusOr<DepthPlan> DepthPlanFromProto(const v1::DepthLayout& layout, const FieldPath& path);

// The same rules for a pinhole camera and the size of its image.
absl::StatusOr<perception::Pinhole> PinholeFromProto(const v1::Pinhole& pinhole, int width_px,
                                                     int height_px, const FieldPath& path);

// Depths outside the camera's range are no return. Refuses another number of bytes.
absl::StatusOr<std::shared_ptr<const perception::DepthImage>> DecodeDepth(const DepthPlan& plan,
                                                                          std::string_view bytes,
                                                                          const FieldPath& path);

// The points of an image in the optical frame, as an organised cloud; NaN: no return.
perception::PointCloud OrganisedCloud(const perception::DepthImage& image,
                                      const perception::Pinhole& pinhole);

}  // namespace cwm::server
