// The server's command-line options.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "server/core/memory_limit.h"
#include "server/rpc/listen_options.h"
#include "server/web/viewer_address.h"

namespace cwm::server {

struct Options {
  ListenOptions listen;  // if there are no addresses: DefaultAddress()
  struct Viewer {
    ViewerAddress address;
    bool is_default = true;  // then a taken address is not fatal: another server may use it
    std::string token;       // from CWM_VIEWER_TOKEN; empty if not given
  };
  std::optional<Viewer> viewer;  // absent: off
  struct Store {
    std::string directory;  // of SQLite's files; empty: worlds are kept in memory
    bool accept_loss = false;
    bool allow_network_mount = false;
  };
  Store store;
  std::string log_level = "info";
  std::int64_t memory_limit_bytes = DefaultMemoryLimit();
};

// The options, or only the exit code if there is nothing to run: after --help, --version or a usage
// error, which has been reported on stderr.
struct ParsedOptions {
  std::optional<Options> options;
  int exit_code = 0;
};
ParsedOptions ParseOptions(int argc, const char* const* argv);

}  // namespace cwm::server
