// A client that writes HTTP/2 frames itself, for frames that a library would not send.
#pragma once

#include <cstdint>
#include <string>

namespace cwm::benchmarks {

// A connected Unix socket; -1 if the server does not accept it within a second.
int ConnectUnix(const std::string& path);
// The same for a port of loopback.
int ConnectLoopback(int port);

class RawHttp2 {
 public:
  // Connects and sends the preface with empty settings.
  explicit RawHttp2(const std::string& socket_path);
  ~RawHttp2();
  RawHttp2(const RawHttp2&) = delete;
  RawHttp2& operator=(const RawHttp2&) = delete;

  bool open() const { return fd_ >= 0; }
  // Bytes that the kernel accepted.
  std::int64_t sent_bytes() const { return sent_bytes_; }

  // The frames of a call: its headers, one message, the reset by the client.
  static std::string Headers(std::uint32_t stream, const std::string& method);
  static std::string Message(std::uint32_t stream, const std::string& message, bool ends);
  static std::string Reset(std::uint32_t stream);
  static std::string Ping();
  static std::string Settings();
  static std::string Frame(std::uint8_t type, std::uint8_t flags, std::uint32_t stream,
                           const std::string& payload);

  // False if the server accepts nothing for `limit_s` or has closed the connection. Reads and
  // discards the server's frames, unless `reads` is false.
  bool Send(const std::string& frames, double limit_s, bool reads = true);

 private:
  void Drain();

  int fd_ = -1;
  std::int64_t sent_bytes_ = 0;
};

}  // namespace cwm::benchmarks
