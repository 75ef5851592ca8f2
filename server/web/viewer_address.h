// The address that the viewer listens on.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"

namespace cwm::server {

struct ViewerAddress {
  std::string host;  // a name or an address; IPv6 without brackets
  std::uint16_t port = 0;

  // "host:port", or "[host]:port" for IPv6, as in a browser's address.
  std::string Text() const;
};

inline constexpr char kDefaultViewer[] = "127.0.0.1:8640";

// Parses "HOST:PORT" or "[IPV6]:PORT"; port 0 picks a free one. InvalidArgument with the value and
// the rule.
absl::StatusOr<ViewerAddress> ParseViewerAddress(const std::string& text);

}  // namespace cwm::server
