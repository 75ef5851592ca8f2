// The costs that one request may have, and how long things are kept. GetServerInfo publishes the
// limits that a client plans by.
#pragma once

#include <chrono>
#include <cstdint>

#include "collision/robot/robot_limits.h"
#include "proto/transfer/chunks.h"
#include "server/core/memory_limit.h"

namespace cwm::server {

using Clock = std::chrono::steady_clock;  // of deadlines and ages

struct Limits {
  std::int64_t max_message_bytes = kMaxMessageBytes;
  std::int64_t max_chunk_bytes = kMaxChunkBytes;
  std::int64_t max_cloud_points = 20'000'000;
  std::int64_t max_cloud_bytes = std::int64_t{2} << 30;  // three clouds of 20 M points at 32 bytes
  std::int64_t max_mesh_triangles = 5'000'000;
  std::int64_t max_batch_rows = 65'536;
  std::int64_t max_rows_as_messages = 1'024;
  // Of all clients, and of one connection; what is scarce is shared (fair_quota.h).
  std::int64_t max_watchers = 1'024;
  std::int64_t max_client_watchers = 256;
  // Of pages of the viewer, of which each may have two: a browser never refuses a robot's watch.
  std::int64_t max_viewer_watchers = 256;
  std::int64_t max_metadata_bytes = 16 << 10;
  std::int64_t max_streams = 4'000;
  std::int64_t max_client_streams = 1'000;
  std::int64_t max_uploads = 256;  // clouds, robots and meshes that are being sent
  std::int64_t max_client_uploads = 64;
  std::int64_t max_waits = 1'024;  // calls that wait for a revision
  std::int64_t max_client_waits = 256;
  // A client that sends nothing of an upload, or reads nothing of an answer, for so long is let go.
  std::chrono::milliseconds max_stall = std::chrono::seconds(30);
  // Work that would wait longer for its turn in a queue is refused; scans and robots may wait
  // longer.
  std::chrono::milliseconds max_queue_wait = std::chrono::seconds(5);
  // The server's account of memory (memory_budget.h).
  std::int64_t max_memory_bytes = DefaultMemoryLimit();
  // A stream keeps its overlay while it lives: a thousand such changes, meshes by hash.
  std::int64_t max_stream_overlay_bytes = 1 << 20;
  std::int64_t max_inline_bytes = 1 << 20;  // labels above it travel by hash
  std::int64_t max_changes = 65'536;        // in one ApplyChanges
  // Estimated, of one core (wire/request_cost.h): several times what the largest batches take,
  // since the estimate may be too high by a factor of three.
  double max_request_cost_s = 300;
  std::int64_t max_worlds = 1'024;
  std::int64_t max_objects = 262'144;  // of one world
  std::int64_t max_parts = 4'096;      // of one object: every question visits each of them
  // Answers of one batch, of some 100 bytes each: every row of the largest batch may have the 16
  // contacts of the default. As messages an answer takes three times that, and few read so many.
  std::int64_t max_answers = 1'048'576;
  std::int64_t max_answers_as_messages = 65'536;
  // An object travels whole: with a page or a watch's piece of others it stays below the 4 MiB that
  // clients of gRPC receive by default.
  std::int64_t max_object_bytes = 1 << 20;
  std::int64_t max_geometry_bytes = std::int64_t{2}
                                    << 30;  // blobs that clients wrote and no object holds yet
  // Encodings kept for who reads in ranges or again: the residual meshes of some four scans of
  // 640 x 480 (14 MB each), or one larger mesh.
  std::int64_t encoded_mesh_bytes = std::int64_t{64} << 20;
  // Of a scan as it is kept to be looked at: more than a screen has pixels for, 16 MB with labels.
  std::int64_t max_kept_scan_points = 1'000'000;
  std::int64_t max_kept_scans = 64;  // of one world, each of another sensor
  // All files of one robot together: ten times what the meshes of a PR2 take, finest included.
  std::int64_t max_robot_bytes = std::int64_t{512} << 20;
  std::int64_t max_robot_files = 4'096;  // a mesh for each of robot.max_links
  std::int64_t max_robots = 64;          // of one world: every watch tells all of them
  collision::RobotLimits robot = {};
};

// Per world. Whatever is reached first ends the keeping; the newest snapshot and the newest
// revision's events are always kept.
struct Retention {
  std::int64_t exact_snapshots = 256;
  // Snapshots share what does not differ: 256 of 10 000 objects with one move between each two are
  // some 3 MB. Geometry that every scan replaces is what fills this.
  std::int64_t snapshot_bytes = std::int64_t{512} << 20;
  std::int64_t watch_events = 65'536;  // changed objects, summed over revisions
  std::int64_t watch_bytes = std::int64_t{256} << 20;
  std::chrono::seconds watch_time = std::chrono::minutes(5);
  std::chrono::seconds request_id_time = std::chrono::minutes(10);
  // 437 writes a second for ten minutes; at 400 bytes each (kRecordBytes), 105 MB.
  std::int64_t request_ids = 262'144;
  // Whole ingest replies for retries: some 50 of a 640 x 480 cloud (1.2 MB of labels).
  std::int64_t reply_bytes = std::int64_t{64} << 20;
};

}  // namespace cwm::server
