// Options of scans: the frame and unit of their points, the sensor's pose and noise.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "clients/cli/session.h"
#include "clients/formats/cloud_file.h"
#include "clients/formats/depth_image.h"
#include "cwm/v1/perception.pb.h"

namespace cwm::cli {

struct ScanArguments {
  std::string x_world_sensor;  // empty: estimated
  std::string up = "auto";
  std::string sensor_model;  // empty: kinect
  std::string sensor;
  std::string clusters;  // empty: objects
  std::string frame = "sensor";
  std::string viewpoint;   // empty: the frame's origin, unknown in the world's frame
  double scale = 0;        // metres per unit; 0: 1, or that of a depth image
  std::string intrinsics;  // of a depth image; empty: in the camera's file beside it
};

void AddScanOptions(CLI::App& command, ScanArguments& scan);
void AddIntrinsicsOption(CLI::App& command, std::string& intrinsics);
// `cwm import` has an option of this name for all of its files.
void AddScaleOption(CLI::App& command, ScanArguments& scan);

// "kinect", a standard deviation, or A,B for A + B z^2. A usage error for anything else.
absl::StatusOr<cwm::v1::SensorModel> ParseSensorModel(const std::string& text);

// The camera of a depth image: numbers, a file, or, if empty, the file beside the image. A usage
// error if there is none.
absl::StatusOr<formats::DepthCamera> ReadCameraOf(const std::string& image,
                                                  const std::string& intrinsics);

// The layout of the image, whose depths are in the caller's unit, the camera's or its own.
cwm::v1::DepthLayout DepthLayoutOf(const formats::DepthImage& image,
                                   const formats::DepthCamera& camera,
                                   std::optional<double> unit_m);

// World, frame, scale, sensor pose, up direction and noise. A usage error if they cannot be parsed.
absl::StatusOr<cwm::v1::IngestCloudHeader> ParseScanHeader(const ScanArguments& scan,
                                                           const Session& session);

// The cloud of a scan's file. A depth image becomes a cloud in metres, so that the header's scale
// is cleared. A cloud in the world's frame whose file tells its viewpoint gets it in the header.
absl::StatusOr<formats::CloudFile> ParseScan(std::string_view bytes, const std::string& path,
                                             const ScanArguments& scan,
                                             cwm::v1::IngestCloudHeader& header);

// Sends a cloud with the file's geometry to the server, with progress on a terminal.
absl::StatusOr<cwm::v1::IngestCloudResponse> SendScan(Session& session,
                                                      const cwm::v1::IngestCloudHeader& header,
                                                      const formats::CloudFile& cloud,
                                                      const std::string& file);

// The same for a depth image as it is, without points.
absl::StatusOr<cwm::v1::IngestCloudResponse> SendDepth(Session& session,
                                                       cwm::v1::IngestCloudHeader header,
                                                       std::string_view bytes,
                                                       const std::string& path,
                                                       const ScanArguments& scan);

// A usage error unless the file name ends in .pcd or has no extension.
absl::Status CheckLabelledName(const std::string& argument, const std::string& path);

// Writes the cloud with the labels of the response as a compressed PCD.
absl::Status WriteLabelled(Session& session, const cwm::v1::IngestCloudResponse& response,
                           const formats::CloudFile& cloud, const std::string& path);

}  // namespace cwm::cli
