#include "server/rpc/end_point.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/un.h>

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace cwm::server {

EndPoint UnixEndPoint(std::string_view path) {
  EndPoint address;
  auto& un = reinterpret_cast<sockaddr_un&>(address.storage);
  un.sun_family = AF_UNIX;
  std::memcpy(un.sun_path, path.data(), std::min(path.size(), sizeof(un.sun_path) - 1));
  address.size = sizeof(un);
  return address;
}

EndPoint TcpEndPoint(int family, const std::string& host, int port) {
  EndPoint address;
  if (family == AF_INET6) {
    auto& in = reinterpret_cast<sockaddr_in6&>(address.storage);
    in.sin6_family = AF_INET6;
    in.sin6_addr = in6addr_loopback;
    in.sin6_port = htons(static_cast<std::uint16_t>(port));
    address.size = sizeof(in);
  } else {
    auto& in = reinterpret_cast<sockaddr_in&>(address.storage);
    in.sin_family = AF_INET;
    inet_pton(AF_INET, host.c_str(), &in.sin_addr);
    in.sin_port = htons(static_cast<std::uint16_t>(port));
    address.size = sizeof(in);
  }
  return address;
}

}  // namespace cwm::server
