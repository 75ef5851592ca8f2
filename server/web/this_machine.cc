#include "server/web/this_machine.h"

#include <ifaddrs.h>
#include <net/if.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/asio/ip/address.hpp>
#include <cstring>
#include <memory>

#include "absl/strings/ascii.h"

namespace cwm::server {
namespace {

constexpr std::size_t kMaxNameBytes = 253;  // the limit of DNS

using boost::asio::ip::address;

bool IsName(const std::string& text) {
  const auto allowed = [](unsigned char c) {
    return absl::ascii_isalnum(c) || c == '.' || c == '-' || c == '_';
  };
  return !text.empty() && text.size() <= kMaxNameBytes &&
         absl::ascii_isalpha(static_cast<unsigned char>(text.front())) &&
         std::all_of(text.begin(), text.end(), allowed);
}

// The interface's address if other machines can reach it; otherwise unspecified.
address ReachableAddress(const ifaddrs& of) {
  if (of.ifa_addr == nullptr || (of.ifa_flags & IFF_UP) == 0) return {};
  address found;
  if (of.ifa_addr->sa_family == AF_INET) {
    sockaddr_in place = {};
    std::memcpy(&place, of.ifa_addr, sizeof(place));
    found = boost::asio::ip::address_v4(ntohl(place.sin_addr.s_addr));
  } else if (of.ifa_addr->sa_family == AF_INET6) {
    sockaddr_in6 place = {};
    std::memcpy(&place, of.ifa_addr, sizeof(place));
    boost::asio::ip::address_v6::bytes_type bytes;
    std::memcpy(bytes.data(), &place.sin6_addr, bytes.size());
    const boost::asio::ip::address_v6 v6(bytes);
    if (v6.is_link_local()) return {};
    found = v6;
  }
  return found.is_loopback() ? address() : found;
}

}  // namespace

std::vector<std::string> NamesOf(const std::string& hostname) {
  const std::string name = absl::AsciiStrToLower(hostname);
  if (!IsName(name) || name == "localhost" || name.rfind("localhost.", 0) == 0) return {};
  const std::string label = name.substr(0, name.find('.'));
  std::vector<std::string> names = {name};
  for (const std::string& other : {label, label + ".local"}) {
    if (std::find(names.begin(), names.end(), other) == names.end()) names.push_back(other);
  }
  return names;
}

ThisMachine LookUpThisMachine() {
  ThisMachine machine;
  std::array<char, kMaxNameBytes + 2> name = {};
  if (gethostname(name.data(), name.size() - 1) == 0) machine.names = NamesOf(name.data());
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) return machine;
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> all(first, freeifaddrs);
  for (const bool is_v4 : {true, false}) {
    for (const ifaddrs* of = first; of != nullptr; of = of->ifa_next) {
      const address found = ReachableAddress(*of);
      if (found.is_unspecified() || found.is_v4() != is_v4) continue;
      machine.addresses.push_back(found.to_string());
    }
  }
  return machine;
}

}  // namespace cwm::server
