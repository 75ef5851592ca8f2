// Options of scans: the sensor's pose and noise.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "absl/status/statusor.h"
#include "clients/cli/session.h"
#include "clients/formats/cloud_file.h"
#include "cwm/v1/perception.pb.h"

namespace cwm::cli {

struct ScanArguments {
  std::string x_world_sensor;  // empty: estimated
  std::string up = "auto";
  std::string sensor_model;  // empty: kinect
  std::string sensor;
  std::string clusters;  // empty: objects
};

void AddScanOptions(CLI::App& command, ScanArguments& scan);

// World, sensor pose, up direction and noise. A usage error if they cannot be parsed.
absl::StatusOr<cwm::v1::IngestCloudHeader> ParseScanHeader(const ScanArguments& scan,
                                                           const Session& session);

// Sends a cloud with the file's geometry to the server, with progress on a terminal.
absl::StatusOr<cwm::v1::IngestCloudResponse> SendScan(Session& session,
                                                      const cwm::v1::IngestCloudHeader& header,
                                                      const formats::CloudFile& cloud,
                                                      const std::string& file);

// A usage error unless the file name ends in .pcd or has no extension.
absl::Status CheckLabelledName(const std::string& argument, const std::string& path);

// Writes the cloud with the labels of the response as a compressed PCD.
absl::Status WriteLabelled(Session& session, const cwm::v1::IngestCloudResponse& response,
                           const formats::CloudFile& cloud, const std::string& path);

}  // namespace cwm::cli
