// Limits of a single request's cost, and how long things are kept. GetServerInfo publishes the
// limits that clients need to know.
#pragma once

#include <chrono>
#include <cstdint>

#include "collision/robot/robot_limits.h"
#include "proto/transfer/chunks.h"
#include "server/core/memory_limit.h"

namespace cwm::server {

using Clock = std::chrono::steady_clock;  // for deadlines and ages

struct Limits {
  std::int64_t max_message_bytes = kMaxMessageBytes;
  std::int64_t max_chunk_bytes = kMaxChunkBytes;
  std::int64_t max_cloud_points = 20'000'000;
  std::int64_t max_cloud_bytes = std::int64_t{2} << 30;  // three clouds of 20 M points at 32 bytes
  std::int64_t max_mesh_triangles = 5'000'000;
  std::int64_t max_batch_rows = 65'536;
  std::int64_t max_rows_as_messages = 1'024;
  // In total and per connection; shared as in fair_quota.h.
  std::int64_t max_watchers = 1'024;
  std::int64_t max_client_watchers = 256;
  // Watches of the viewer's pages, of which each may have two. They count apart, so that a browser
  // never takes the place of a robot's watch.
  std::int64_t max_viewer_watchers = 256;
  std::int64_t max_metadata_bytes = 16 << 10;
  std::int64_t max_streams = 4'000;
  std::int64_t max_client_streams = 1'000;
  std::int64_t max_uploads = 256;  // uploads in progress of clouds, robots and meshes
  std::int64_t max_client_uploads = 64;
  std::int64_t max_waits = 1'024;  // calls that wait for a revision
  std::int64_t max_client_waits = 256;
  // A client that sends nothing of an upload, or reads nothing of an answer, for so long is
  // dropped.
  std::chrono::milliseconds max_stall = std::chrono::seconds(30);
  // Work that would wait longer for its turn in a queue is refused. Scans and robots may wait
  // longer.
  std::chrono::milliseconds max_queue_wait = std::chrono::seconds(5);
  // The server's account of memory (memory_budget.h).
  std::int64_t max_memory_bytes = DefaultMemoryLimit();
  // A stream keeps its overlay for its lifetime: enough for a thousand typical changes with meshes
  // by hash.
  std::int64_t max_stream_overlay_bytes = 1 << 20;
  std::int64_t max_inline_bytes = 1 << 20;  // larger label images are sent by hash
  std::int64_t max_changes = 65'536;        // in one ApplyChanges
  // Estimated time on one core (wire/request_cost.h): several times the time of the largest
  // batches, since the estimate may be too high by a factor of three.
  double max_request_cost_s = 300;
  std::int64_t max_worlds = 1'024;
  std::int64_t max_objects = 262'144;  // of one world
  // Writes of one world that wait for the disk. They hold two snapshots' difference each.
  std::int64_t max_pending_writes = 4'096;
  std::int64_t max_parts = 4'096;  // per object, since every query visits each part
  // Answers of one batch, of about 100 bytes each: every row of the largest batch may have the 16
  // contacts of the default. As messages an answer takes three times as much, and few clients read
  // so many.
  std::int64_t max_answers = 1'048'576;
  std::int64_t max_answers_as_messages = 65'536;
  // An object is sent whole: together with a page or a part of a watch's event it stays below the 4
  // MiB that gRPC clients receive by default.
  std::int64_t max_object_bytes = 1 << 20;
  std::int64_t max_geometry_bytes = std::int64_t{2}
                                    << 30;  // blobs that clients wrote and no object holds yet
  // Encodings kept for clients that read in ranges or again: the residual meshes of about four
  // scans of 640 x 480 (14 MB each), or one larger mesh.
  std::int64_t encoded_mesh_bytes = std::int64_t{64} << 20;
  // Points kept of a scan for display: more than a screen has pixels, 16 MB with labels.
  std::int64_t max_kept_scan_points = 1'000'000;
  std::int64_t max_kept_scans = 64;  // per world, one per sensor
  // All files of one robot together: ten times the meshes of a PR2, the finest included.
  std::int64_t max_robot_bytes = std::int64_t{512} << 20;
  std::int64_t max_robot_files = 4'096;  // a mesh for each of robot.max_links
  std::int64_t max_robots = 64;          // per world, since every watch reports all of them
  collision::RobotLimits robot = {};
};

// Retention of one world. The limit that is reached first applies; the newest snapshot and the
// newest revision's events are always kept.
struct Retention {
  // Exact snapshots, thinned by age in a world that makes more than ten revisions a second
  // (kept_snapshots.h): at 30 a second these reach back more than two minutes.
  std::int64_t exact_snapshots = 256;
  // Snapshots share what they have in common: 256 snapshots of 10 000 objects with one move between
  // each two take about 3 MB. Geometry that every scan replaces is what fills this limit.
  std::int64_t snapshot_bytes = std::int64_t{512} << 20;
  // Whoever was told of the newest revision has so long to ask for it: these snapshots are kept
  // beyond exact_snapshots. chosen: more than the 1,747 durable writes a second that were measured.
  std::chrono::milliseconds recent_time = std::chrono::seconds(1);
  std::int64_t recent_snapshots = 4'096;
  // A snapshot that was asked for by its revision is kept for so long, beyond all others; the least
  // recently used fall first. chosen: a planner pins one for each problem, and some problems take
  // half a minute.
  std::chrono::seconds lease_time = std::chrono::seconds(60);
  std::int64_t leased_snapshots = 256;
  std::int64_t leased_bytes = std::int64_t{256} << 20;
  std::int64_t watch_events = 65'536;  // changed objects, summed over revisions
  std::int64_t watch_bytes = std::int64_t{256} << 20;
  std::chrono::seconds watch_time = std::chrono::minutes(5);
  std::chrono::seconds request_id_time = std::chrono::minutes(10);
  // derived: 1,747 writes per second for ten minutes; at 220 bytes each (kRecordBytes), 230 MB.
  std::int64_t request_ids = 1'048'576;
  // Whole ingest replies for retries: about 50 of a 640 x 480 cloud (1.2 MB of labels each).
  std::int64_t reply_bytes = std::int64_t{64} << 20;
};

}  // namespace cwm::server
