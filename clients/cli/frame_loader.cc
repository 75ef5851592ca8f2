#include "clients/cli/frame_loader.h"

#include <google/protobuf/util/message_differencer.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/cli/scan_arguments.h"
#include "clients/cpp/cloud_upload.h"
#include "clients/formats/cloud_reader.h"
#include "clients/formats/file_bytes.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

// "depth image 640 x 480 of 16 bits", "cloud of 640 x 480 points"
std::string FormOf(const pb::SensorCalibration& layout) {
  if (!layout.has_depth()) {
    return absl::StrCat("a cloud of ", layout.width(), " x ", layout.height(), " points of ",
                        layout.layout().point_step(), " bytes");
  }
  const pb::DepthLayout& depth = layout.depth();
  return absl::StrCat("a depth image of ", depth.width(), " x ", depth.height(), " ",
                      depth.type() == pb::DEPTH_TYPE_U16 ? "integers" : "floats");
}

}  // namespace

pb::Pose PoseToProto(const formats::ScenePose& pose) {
  pb::Pose message;
  message.set_tx_m(pose.position_m[0]);
  message.set_ty_m(pose.position_m[1]);
  message.set_tz_m(pose.position_m[2]);
  message.set_qx(pose.orientation_xyzw[0]);
  message.set_qy(pose.orientation_xyzw[1]);
  message.set_qz(pose.orientation_xyzw[2]);
  message.set_qw(pose.orientation_xyzw[3]);
  return message;
}

absl::StatusOr<pb::SensorFrame> FrameLoader::Load(const formats::SequenceFrame& frame) {
  pb::SensorFrame message;
  if (absl::Status status = LoadImage(frame.path, message); !status.ok()) {
    if (frame.source == frame.path) return status;
    absl::Status located(status.code(),
                         absl::StrCat(frame.source, ": ", std::string(status.message())));
    status.ForEachPayload([&](absl::string_view type, const absl::Cord& payload) {
      located.SetPayload(type, payload);
    });
    return located;
  }
  if (options_.use_poses && frame.x_world_sensor) {
    *message.mutable_x_world_sensor() = PoseToProto(*frame.x_world_sensor);
  }
  return message;
}

absl::Status FrameLoader::LoadImage(const std::string& path, pb::SensorFrame& out) {
  const auto bytes = formats::ReadFileBytes(path);
  if (!bytes.ok()) return bytes.status();
  return formats::IsDepthImage(*bytes) ? LoadDepth(*bytes, path, out)
                                       : LoadCloud(*bytes, path, out);
}

absl::Status FrameLoader::LoadDepth(std::string_view bytes, const std::string& path,
                                    pb::SensorFrame& out) {
  if (!camera_) {
    const auto camera = ReadCameraOf(path, options_.intrinsics);
    if (!camera.ok()) return camera.status();
    camera_ = *camera;
  }
  auto image = formats::ReadDepthImage(bytes, path);
  if (!image.ok()) return image.status();
  pb::SensorCalibration layout;
  *layout.mutable_depth() = DepthLayoutOf(*image, *camera_, options_.unit_m);
  layout.set_least_range_m(camera_->min_range_m.value_or(0));
  layout.set_greatest_range_m(camera_->max_range_m.value_or(0));
  if (options_.use_sensor_model && !camera_->sensor_model.empty()) {
    const auto model = ParseSensorModel(camera_->sensor_model);
    if (!model.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat("the camera of ", path, ": sensor_model is \"", camera_->sensor_model,
                       "\", must be one that --sensor-model takes, which also overrides it"));
    }
    *layout.mutable_sensor_model() = *model;
  }
  out.set_depth(std::move(image->bytes));
  return CheckLayout(layout, path);
}

absl::Status FrameLoader::LoadCloud(std::string_view bytes, const std::string& path,
                                    pb::SensorFrame& out) {
  const auto cloud = formats::ParseCloud(bytes, path);
  if (!cloud.ok()) return cloud.status();
  auto geometry = client::SelectGeometry(*cloud);
  if (!geometry.ok()) return geometry.status();
  auto fields = client::LayoutOf(*geometry);
  if (!fields.ok()) return fields.status();
  pb::SensorCalibration layout;
  *layout.mutable_layout() = *std::move(fields);
  layout.set_width(static_cast<int>(geometry->width));
  layout.set_height(static_cast<int>(geometry->height));
  out.set_points(std::move(geometry->bytes));
  return CheckLayout(layout, path);
}

absl::Status FrameLoader::CheckLayout(const pb::SensorCalibration& layout,
                                      const std::string& path) {
  if (first_path_.empty()) {
    layout_ = layout;
    first_path_ = path;
    return absl::OkStatus();
  }
  if (google::protobuf::util::MessageDifferencer::Equals(layout, layout_)) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(path, ": the frame is ", FormOf(layout),
                                                 ", must be ", FormOf(layout_), " like ",
                                                 first_path_));
}

}  // namespace cwm::cli
