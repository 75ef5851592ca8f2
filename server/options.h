// What the server is told on its command line.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "server/core/memory_limit.h"
#include "server/rpc/listen_options.h"
#include "server/web/viewer_address.h"

namespace cwm::server {

struct Options {
  ListenOptions listen;  // without addresses: DefaultAddress()
  struct Viewer {
    ViewerAddress address;
    bool is_default = true;  // another server may have it already
    std::string token;       // of CWM_VIEWER_TOKEN; empty: none was given
  };
  std::optional<Viewer> viewer;  // absent: off
  std::string log_level = "info";
  std::int64_t memory_limit_bytes = DefaultMemoryLimit();
};

// The exit code instead, when there is nothing to run: help, version, or a mistake (said on
// stderr).
struct ParsedOptions {
  std::optional<Options> options;
  int exit_code = 0;
};
ParsedOptions ParseOptions(int argc, const char* const* argv);

}  // namespace cwm::server
