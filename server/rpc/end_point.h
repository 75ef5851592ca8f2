// Socket addresses at which the server may listen.
#pragma once

#include <sys/socket.h>

#include <string>
#include <string_view>

namespace cwm::server {

struct EndPoint {
  sockaddr_storage storage{};
  socklen_t size = 0;
  sockaddr* get() { return reinterpret_cast<sockaddr*>(&storage); }
  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
  sa_family_t family() const { return storage.ss_family; }
};

// A path that is too long for a socket is cut.
EndPoint UnixEndPoint(std::string_view path);
// `family` is AF_INET6 for ::1, else AF_INET, and `host` four numbers.
EndPoint TcpEndPoint(int family, const std::string& host, int port);

}  // namespace cwm::server
