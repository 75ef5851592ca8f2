// Where the server listens, and who may connect there.
#pragma once

#include <string>
#include <vector>

namespace cwm::server {

struct ListenOptions {
  // "unix:PATH" or "HOST:PORT" of loopback, see listen_address.h; port 0 picks one.
  std::vector<std::string> addresses;
  // At HOST:PORT, every user of the machine instead of this process's user and root. On Unix
  // sockets the mode of the file decides.
  bool allow_any_local_user = false;
};

}  // namespace cwm::server
