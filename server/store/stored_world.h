// Parses what an engine holds of a world.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "cwm/store/v1/record.pb.h"
#include "server/core/limits.h"
#include "server/store/encode_shapes.h"
#include "server/store/store.h"
#include "server/store/world_fold.h"

namespace cwm::server {

// "record 17 of world UID", for errors.
std::string PlaceOf(const StoredRecord& record);

// DataLoss STORE_DAMAGED if the payload is no record, or another one than its engine says.
absl::StatusOr<store::v1::Record> ParseRecord(const StoredRecord& stored);
// Likewise for a snapshot.
absl::StatusOr<WorldFold> FoldOf(const StoredSnapshot& stored, const Retention& retention);

// Adds all blobs that the snapshot needs. The errors of Store::GetBlob for the files of robots.
absl::Status AddBlobs(const store::v1::WorldSnapshot& snapshot, const Store& store,
                      BlobHashes& blobs);

}  // namespace cwm::server
