// Writes what a journal is told as records of a store, bit by bit.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "cwm/store/v1/record.pb.h"
#include "server/core/journal.h"
#include "server/store/encode_shapes.h"
#include "server/store/store.h"

namespace cwm::server {

std::int64_t NanosecondsOf(collision::WallTime time);  // since the Unix epoch

store::v1::PairRule EncodeRule(const collision::PairRule& rule);
store::v1::SensorPose EncodeSensorPose(const std::string& sensor, const SensorPose& pose);

// Adds the robot's files, which their hash names, to `blobs`. The errors of GetBlob.
absl::Status AddRobotBlobs(const std::string& files_hash, const Store& store, BlobHashes& blobs);

struct EncodedEntry {
  std::string payload;             // a store.v1.Record
  std::vector<std::string> blobs;  // those that it needs
};
// An object or robot that keeps its geometry is written without it. Large geometry and the files of
// robots are in `store` already (keep_blobs.h). Internal for a robot whose files were never kept;
// the errors of GetBlob for those of another robot.
absl::StatusOr<EncodedEntry> EncodeEntry(const JournalEntry& entry, const Store& store);

}  // namespace cwm::server
