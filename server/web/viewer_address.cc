#include "server/web/viewer_address.h"

#include <algorithm>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"

namespace cwm::server {
namespace {

constexpr int kMaxPort = 65'535;
constexpr std::size_t kMaxHostBytes = 253;  // of a DNS name

bool IsHost(const std::string& host) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '-' || c == '_';
  };
  return !host.empty() && host.size() <= kMaxHostBytes &&
         std::all_of(host.begin(), host.end(), allowed);
}

bool IsBracketed(const std::string& host) {
  return host.size() > 2 && host.front() == '[' && host.back() == ']' &&
         host.find_first_not_of("0123456789abcdefABCDEF:.", 1) == host.size() - 1;
}

}  // namespace

std::string ViewerAddress::Text() const {
  const bool is_ipv6 = host.find(':') != std::string::npos;
  return is_ipv6 ? absl::StrCat("[", host, "]:", port) : absl::StrCat(host, ":", port);
}

absl::StatusOr<ViewerAddress> ParseViewerAddress(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  const std::string host = text.substr(0, colon == std::string::npos ? 0 : colon);
  const std::string digits = colon == std::string::npos ? "" : text.substr(colon + 1);
  const bool all_digits =
      !digits.empty() && digits.find_first_not_of("0123456789") == std::string::npos;
  int port = 0;
  if ((!IsHost(host) && !IsBracketed(host)) || !all_digits || !absl::SimpleAtoi(digits, &port) ||
      port > kMaxPort) {
    return absl::InvalidArgumentError(
        absl::StrCat("--viewer: is \"", text,
                     "\", must be off, HOST:PORT or [IPV6]:PORT with a port of 0 to ", kMaxPort));
  }
  return ViewerAddress{.host = IsBracketed(host) ? host.substr(1, host.size() - 2) : host,
                       .port = static_cast<std::uint16_t>(port)};
}

}  // namespace cwm::server
