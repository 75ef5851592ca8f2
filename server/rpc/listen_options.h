// The addresses that the server listens at, and who may connect there.
#pragma once

#include <string>
#include <vector>

namespace cwm::server {

struct ListenOptions {
  // "unix:PATH" or "HOST:PORT" of loopback, see listen_address.h; port 0 picks a free port.
  std::vector<std::string> addresses;
  // If true, every user of the machine may connect to HOST:PORT, instead of only this process's
  // user and root. Access to Unix sockets depends on the mode of the file.
  bool allow_any_local_user = false;
};

}  // namespace cwm::server
