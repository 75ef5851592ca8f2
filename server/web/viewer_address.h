// Where the viewer listens.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"

namespace cwm::server {

struct ViewerAddress {
  std::string host;  // a name or an address; one of IPv6 without brackets
  std::uint16_t port = 0;

  // "host:port", "[host]:port" of IPv6: as a browser names it.
  std::string Text() const;
};

inline constexpr char kDefaultViewer[] = "127.0.0.1:8640";

// Of "HOST:PORT" or "[IPV6]:PORT"; port 0 picks one. InvalidArgument names the value and the rule.
absl::StatusOr<ViewerAddress> ParseViewerAddress(const std::string& text);

}  // namespace cwm::server
