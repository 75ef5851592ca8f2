// Reads the files of a sensor's frames and makes the messages of them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "clients/formats/depth_image.h"
#include "clients/formats/frame_sequence.h"
#include "cwm/v1/perception.pb.h"

namespace cwm::cli {

cwm::v1::Pose PoseToProto(const formats::ScenePose& pose);

class FrameLoader {
 public:
  struct Options {
    std::string intrinsics = {};        // as --intrinsics; empty: the camera's file beside
    std::optional<double> unit_m = {};  // of depth images
    bool use_poses = true;              // of the frames
    bool use_sensor_model = true;       // of the camera's file
  };
  explicit FrameLoader(Options options) : options_(std::move(options)) {}

  // The image and the pose of the frame, without a stamp. All frames must be like the first one:
  // depth images of one size and type, or clouds of one layout. Errors name the frame's source and
  // file.
  absl::StatusOr<cwm::v1::SensorFrame> Load(const formats::SequenceFrame& frame);

  // Describes the loaded frames: depth, or layout, width and height; and the sensor as far as the
  // camera's file does.
  const cwm::v1::SensorCalibration& layout() const { return layout_; }

 private:
  absl::Status LoadImage(const std::string& path, cwm::v1::SensorFrame& out);
  absl::Status LoadDepth(std::string_view bytes, const std::string& path,
                         cwm::v1::SensorFrame& out);
  absl::Status LoadCloud(std::string_view bytes, const std::string& path,
                         cwm::v1::SensorFrame& out);
  absl::Status CheckLayout(const cwm::v1::SensorCalibration& layout, const std::string& path);

  const Options options_;
  std::optional<formats::DepthCamera> camera_;
  cwm::v1::SensorCalibration layout_;
  std::string first_path_;  // empty: none was loaded
};

}  // namespace cwm::cli
