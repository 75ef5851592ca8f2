#include "tests/benchmarks/server/raw_http2.h"

#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

namespace cwm::benchmarks {
namespace {

constexpr char kPreface[] = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
constexpr std::uint8_t kData = 0, kHeaders = 1, kResetStream = 3, kSettings = 4, kPing = 6;
constexpr std::uint8_t kEndStream = 1, kEndHeaders = 4;

// A literal header field that enters no table; lengths are below 127.
std::string Literal(const std::string& name, const std::string& value) {
  return std::string(1, '\0') + static_cast<char>(name.size()) + name +
         static_cast<char>(value.size()) + value;
}

int Connect(int family, const sockaddr* address, socklen_t size) {
  const int fd = socket(family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return -1;
  // A Unix socket whose backlog is full refuses at once; TCP keeps trying by itself.
  for (int i = 0; i < 100; ++i) {
    if (connect(fd, address, size) == 0 || errno == EINPROGRESS || errno == EISCONN) return fd;
    if (errno != EAGAIN && errno != EALREADY) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  close(fd);
  return -1;
}

}  // namespace

int ConnectUnix(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof(address.sun_path)) return -1;
  std::memcpy(address.sun_path, path.data(), path.size());
  return Connect(AF_UNIX, reinterpret_cast<const sockaddr*>(&address), sizeof(address));
}

int ConnectLoopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  return Connect(AF_INET, reinterpret_cast<const sockaddr*>(&address), sizeof(address));
}

RawHttp2::RawHttp2(const std::string& socket_path) : fd_(ConnectUnix(socket_path)) {
  if (open()) Send(kPreface + Settings(), 1.0);
}

RawHttp2::~RawHttp2() {
  if (open()) close(fd_);
}

std::string RawHttp2::Frame(std::uint8_t type, std::uint8_t flags, std::uint32_t stream,
                            const std::string& payload) {
  std::string frame;
  const std::size_t size = payload.size();
  for (const int shift : {16, 8, 0}) frame += static_cast<char>(size >> shift & 0xFF);
  frame += static_cast<char>(type);
  frame += static_cast<char>(flags);
  for (const int shift : {24, 16, 8, 0}) frame += static_cast<char>(stream >> shift & 0xFF);
  return frame + payload;
}

std::string RawHttp2::Headers(std::uint32_t stream, const std::string& method) {
  // Indices of the static table: :method POST is 3, :scheme http is 6.
  const std::string block = "\x83\x86" + Literal(":path", "/" + method) +
                            Literal(":authority", "cwm") + Literal("te", "trailers") +
                            Literal("content-type", "application/grpc");
  return Frame(kHeaders, kEndHeaders, stream, block);
}

std::string RawHttp2::Message(std::uint32_t stream, const std::string& message, bool ends) {
  std::string prefixed(1, '\0');
  for (const int shift : {24, 16, 8, 0}) {
    prefixed += static_cast<char>(message.size() >> shift & 0xFF);
  }
  return Frame(kData, ends ? kEndStream : 0, stream, prefixed + message);
}

std::string RawHttp2::Reset(std::uint32_t stream) {
  return Frame(kResetStream, 0, stream, std::string("\0\0\0\x08", 4));  // CANCEL
}

std::string RawHttp2::Ping() { return Frame(kPing, 0, 0, std::string(8, 'p')); }

std::string RawHttp2::Settings() { return Frame(kSettings, 0, 0, ""); }

void RawHttp2::Drain() {
  char bytes[1 << 16];
  while (recv(fd_, bytes, sizeof(bytes), MSG_DONTWAIT) > 0) {
  }
}

bool RawHttp2::Send(const std::string& frames, double limit_s, bool reads) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(limit_s);
  std::size_t done = 0;
  while (done < frames.size()) {
    if (!open() || std::chrono::steady_clock::now() > end) return false;
    if (reads) Drain();
    const ssize_t count =
        send(fd_, frames.data() + done, frames.size() - done, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (count > 0) {
      done += static_cast<std::size_t>(count);
      sent_bytes_ += count;
      continue;
    }
    if (errno != EAGAIN) return false;
    pollfd waiting{.fd = fd_, .events = POLLOUT, .revents = 0};
    poll(&waiting, 1, 20);
  }
  return true;
}

}  // namespace cwm::benchmarks
