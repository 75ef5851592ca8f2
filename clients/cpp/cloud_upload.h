// Clouds to the server.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cpp/connection.h"
#include "clients/cpp/progress.h"
#include "clients/formats/cloud_file.h"

namespace cwm::client {

// Only what the server uses of a cloud: x y z, and the normals when all three are there.
// INVALID_ARGUMENT when a coordinate is missing, has more than one number, or is a 64-bit integer.
absl::StatusOr<formats::CloudFile> GeometryOf(const formats::CloudFile& cloud);

// Sends the cloud under the header, whose layout, counts and extent are filled in from it, and
// waits until the server has replied. INVALID_ARGUMENT also when the cloud has a field type that
// the surface does not know (see GeometryOf). Ends early when the server refuses the header.
absl::StatusOr<cwm::v1::IngestCloudResponse> IngestCloud(const Connection& connection,
                                                         cwm::v1::IngestCloudHeader header,
                                                         const formats::CloudFile& cloud,
                                                         const Progress& progress = {});

// One label per point: inline, or fetched by its hash.
absl::StatusOr<std::vector<std::uint32_t>> LabelsOf(const Connection& connection,
                                                    const cwm::v1::IngestCloudResponse& response,
                                                    std::int64_t point_count);

}  // namespace cwm::client
