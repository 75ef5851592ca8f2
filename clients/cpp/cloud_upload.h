// Uploads clouds to the server.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cpp/connection.h"
#include "clients/cpp/progress.h"
#include "clients/formats/cloud_file.h"

namespace cwm::client {

// Only the fields that the server uses: x y z, and the normals if all three are present.
// INVALID_ARGUMENT if a coordinate is missing, has more than one number, or is a 64-bit integer.
absl::StatusOr<formats::CloudFile> SelectGeometry(const formats::CloudFile& cloud);

// The layout of the cloud's points. INVALID_ARGUMENT for a field type that the API does not support
// (see SelectGeometry).
absl::StatusOr<cwm::v1::CloudLayout> LayoutOf(const formats::CloudFile& cloud);

// Sends the cloud with the header, whose layout, counts and extent are set from the cloud, and
// waits for the server's reply. INVALID_ARGUMENT also as LayoutOf. Ends early if the server refuses
// the header.
absl::StatusOr<cwm::v1::IngestCloudResponse> IngestCloud(const Connection& connection,
                                                         cwm::v1::IngestCloudHeader header,
                                                         const formats::CloudFile& cloud,
                                                         const Progress& progress = {});

// The same for a depth image, whose layout the header has (`depth`) and whose bytes are as
// formats::DepthImage has them.
absl::StatusOr<cwm::v1::IngestCloudResponse> IngestDepth(const Connection& connection,
                                                         cwm::v1::IngestCloudHeader header,
                                                         const std::string& bytes,
                                                         const Progress& progress = {});

// One label per point, from the reply or fetched by its hash.
absl::StatusOr<std::vector<std::uint32_t>> ReadLabels(const Connection& connection,
                                                      const cwm::v1::IngestCloudResponse& response,
                                                      std::int64_t point_count);

}  // namespace cwm::client
