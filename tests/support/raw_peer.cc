#include "tests/support/raw_peer.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

namespace cwm::testing {
namespace {

using Clock = std::chrono::steady_clock;

bool ConnectTo(int fd, const std::string& address) {
  constexpr std::string_view kUnix = "unix:";
  if (address.starts_with(kUnix)) {
    const std::string path = address.substr(kUnix.size());
    sockaddr_un un{};
    un.sun_family = AF_UNIX;
    std::memcpy(un.sun_path, path.data(), std::min(path.size(), sizeof(un.sun_path) - 1));
    return connect(fd, reinterpret_cast<const sockaddr*>(&un), sizeof(un)) == 0;
  }
  const std::size_t colon = address.rfind(':');
  sockaddr_in in{};
  in.sin_family = AF_INET;
  in.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address.substr(colon + 1))));
  inet_pton(AF_INET, address.substr(0, colon).c_str(), &in.sin_addr);
  return connect(fd, reinterpret_cast<const sockaddr*>(&in), sizeof(in)) == 0;
}

// The next bytes; empty at the end of the connection, or if none came in time.
std::string Next(int fd, std::size_t at_most, Clock::time_point until, bool* closed) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
  pollfd waiting{.fd = fd, .events = POLLIN, .revents = 0};
  const int wait_ms = static_cast<int>(std::max<std::int64_t>(left.count(), 0));
  if (poll(&waiting, 1, wait_ms) != 1) return {};
  std::array<char, 4096> buffer;
  const ssize_t size = recv(fd, buffer.data(), std::min(at_most, buffer.size()), 0);
  *closed = size <= 0;
  return size > 0 ? std::string(buffer.data(), static_cast<std::size_t>(size)) : std::string();
}

}  // namespace

std::string Http2Frame(int type, int flags, int stream, std::string_view payload) {
  std::string frame;
  for (const int shift : {16, 8, 0}) frame.push_back(static_cast<char>(payload.size() >> shift));
  frame.push_back(static_cast<char>(type));
  frame.push_back(static_cast<char>(flags));
  for (const int shift : {24, 16, 8, 0}) frame.push_back(static_cast<char>(stream >> shift));
  frame += payload;
  return frame;
}

std::string Http2ClientPreface() {
  constexpr int kSettings = 4;
  return "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + Http2Frame(kSettings, 0, 0, "");
}

RawPeer::RawPeer(const std::string& address)
    : fd_(socket(address.starts_with("unix:") ? AF_UNIX : AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)),
      is_connected_(ConnectTo(fd_, address)) {}

RawPeer::~RawPeer() {
  if (fd_ >= 0) close(fd_);
}

RawPeer::RawPeer(RawPeer&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), is_connected_(other.is_connected_) {}

bool RawPeer::Send(std::string_view bytes) const {
  return send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
}

std::string RawPeer::Receive(std::size_t size, std::chrono::milliseconds within) const {
  const auto until = Clock::now() + within;
  std::string received;
  bool closed = false;
  while (received.size() < size && !closed) {
    const std::string more = Next(fd_, size - received.size(), until, &closed);
    if (more.empty()) break;
    received += more;
  }
  return received;
}

bool RawPeer::IsClosedWithin(std::chrono::milliseconds time) const {
  const auto until = Clock::now() + time;
  bool closed = !is_connected_;
  while (!closed && Clock::now() < until) Next(fd_, 4096, until, &closed);
  return closed;
}

}  // namespace cwm::testing
