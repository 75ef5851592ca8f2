// What one request may cost, and how long things are kept: published by GetServerInfo.
#pragma once

#include <chrono>
#include <cstdint>

namespace cwm::server {

struct Limits {
  std::int64_t max_message_bytes = 16 << 20;
  std::int64_t max_chunk_bytes = 1 << 20;
  std::int64_t max_cloud_points = 20'000'000;
  std::int64_t max_mesh_triangles = 5'000'000;
  std::int64_t max_batch_rows = 65'536;
  std::int64_t max_rows_as_messages = 1'024;
  std::int64_t max_watchers = 256;
  std::int64_t max_metadata_bytes = 16 << 10;
  std::int64_t max_streams = 1'000;
  std::int64_t max_inline_bytes = 1 << 20;  // labels above it travel by hash
  std::int64_t max_changes = 65'536;        // in one ApplyChanges
  std::int64_t max_worlds = 1'024;
  std::int64_t max_geometry_bytes = std::int64_t{2}
                                    << 30;  // blobs that clients wrote and no object holds yet
};

struct Retention {
  std::int64_t exact_snapshots = 256;
  std::int64_t watch_events = 65'536;
  std::chrono::seconds watch_time = std::chrono::minutes(5);
  std::chrono::seconds request_id_time = std::chrono::minutes(10);
};

}  // namespace cwm::server
