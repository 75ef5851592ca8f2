// Limits of the viewer's connections and calls. Tests set smaller ones.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace cwm::server {

struct ViewerLimits {
  // chosen: each page takes one socket; one robot does not have more viewers than that.
  std::size_t sockets = 64;
  // chosen: a browser opens at most six connections to a server besides its pages' sockets, and
  // closes them when idle. Each takes one of the process's file descriptors, of which there are 1
  // 024 by default.
  std::size_t connections = 256;
  // One user of this machine may have at most half of them, so that nobody excludes other users.
  std::size_t connections_of_user = 128;
  // Two watches and the page's simultaneous queries. A page reads meshes by HTTP.
  std::size_t calls_of_socket = 16;
  // The watch of the displayed world, and of another one during a switch. All sockets together may
  // use half of the services' quota (Limits::max_viewer_watchers), since watches that are about to
  // end still count there.
  std::size_t watches_of_socket = 2;
  // The largest request of a page: a query with 18 000 poses of F64. Larger ones must use gRPC.
  std::size_t message_bytes = 1 << 20;
  std::uint32_t header_bytes = 16 << 10;  // the same as gRPC's metadata limit
  // If more messages wait to be written to one socket, nothing more is read from it.
  std::size_t waiting_messages = 64;
  // The bytes that may wait to be written to one socket for longer than `max_lag`: one message of
  // the largest size. Short bursts may be larger, since a page that reads them catches up quickly:
  // even at 4 MB/s it gets below the limit in time after two of the largest messages.
  std::size_t waiting_bytes = 16 << 20;
  std::chrono::milliseconds max_lag = std::chrono::seconds(5);
  // The bytes that may wait at any time: four of the largest messages, of the sixteen that its
  // calls could have.
  std::size_t burst_bytes = 64 << 20;

  std::chrono::milliseconds http_idle_timeout =
      std::chrono::seconds(15);  // between and within requests
  std::chrono::milliseconds write_timeout = std::chrono::seconds(30);
  std::chrono::milliseconds ping_period = std::chrono::seconds(20);
  // The time limit of a call that is not a stream; longer ones must use gRPC.
  std::chrono::milliseconds call_timeout = std::chrono::seconds(30);
  std::chrono::milliseconds close_timeout =
      std::chrono::seconds(1);  // for the answer to a close frame
};

}  // namespace cwm::server
