// A peer that sends arbitrary bytes over a socket, below gRPC.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

namespace cwm::testing {

// The preface of HTTP/2 and an empty SETTINGS frame, with which a client begins.
std::string Http2ClientPreface();

// One frame of HTTP/2.
std::string Http2Frame(int type, int flags, int stream, std::string_view payload);

class RawPeer {
 public:
  // Connects to "unix:PATH" or "127.0.0.1:PORT".
  explicit RawPeer(const std::string& address);
  ~RawPeer();
  RawPeer(RawPeer&& other) noexcept;
  RawPeer& operator=(RawPeer&&) = delete;

  bool is_connected() const { return is_connected_; }
  bool Send(std::string_view bytes) const;
  // The bytes that come within that time, up to `size`; fewer if the server closes the connection.
  std::string Receive(std::size_t size, std::chrono::milliseconds within) const;
  // Reads until the server closes the connection; false if it does not within that time.
  bool IsClosedWithin(std::chrono::milliseconds time) const;
  int descriptor() const { return fd_; }

 private:
  int fd_ = -1;
  bool is_connected_ = false;
};

}  // namespace cwm::testing
