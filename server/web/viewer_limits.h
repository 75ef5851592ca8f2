// What those who look may cost. Tests set smaller ones.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace cwm::server {

struct ViewerLimits {
  // A page takes one socket; more people than that do not look at one robot.
  std::size_t sockets = 64;
  // A browser opens at most six connections to a server beside its pages' sockets, and closes them
  // when they are idle. Each holds one of the process's file descriptors, of which there are 1 024
  // by default.
  std::size_t connections = 256;
  // One user of this machine has half of them at most: who opens many pushes out none of another's.
  std::size_t connections_of_user = 128;
  // Two watches, and what a page asks at a time. Its meshes it reads by HTTP.
  std::size_t calls_of_socket = 16;
  // The one of the world that is shown, and that of another while it is chosen. All sockets
  // together have half of what the services keep for them (Limits::max_viewer_watchers): those that
  // are about to end count there still.
  std::size_t watches_of_socket = 2;
  // A request of the page: a question with 18 000 poses of F64. What is asked in bulk is asked by
  // gRPC.
  std::size_t message_bytes = 1 << 20;
  std::uint32_t header_bytes = 16 << 10;  // as gRPC's metadata
  // Answers that wait for one socket beside those of its calls: beyond, nothing more is read of it.
  std::size_t waiting_messages = 64;
  // What the calls of one socket may have waiting to be written for longer than `catch_up`: one
  // message of the largest. Answers that come at once may be more, and a page that reads has them
  // in a moment; even of 4 MB/s it is below in time after two of the largest.
  std::size_t waiting_bytes = 16 << 20;
  std::chrono::milliseconds catch_up = std::chrono::seconds(5);
  // And at any time: four of the largest, of sixteen that the calls could be.
  std::size_t burst_bytes = 64 << 20;

  std::chrono::milliseconds idle_http = std::chrono::seconds(15);  // between and within requests
  std::chrono::milliseconds no_byte_taken = std::chrono::seconds(30);
  std::chrono::milliseconds ping_period = std::chrono::seconds(20);
  // Of a call that is no stream: whoever asks more than this asks by gRPC.
  std::chrono::milliseconds call_time = std::chrono::seconds(30);
  std::chrono::milliseconds goodbye = std::chrono::seconds(1);  // for the answer to a close
};

}  // namespace cwm::server
