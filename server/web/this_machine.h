// The names and addresses that other machines use for this one.
#pragma once

#include <string>
#include <vector>

namespace cwm::server {

struct ThisMachine {
  // In lower case, without names that every machine has: "robot", and "robot.local" as in multicast
  // DNS. None that a stranger could register.
  std::vector<std::string> names = {};
  // Addresses of interfaces that are up, IPv4 first; without loopback and without addresses that
  // need the interface's name (link-local).
  std::vector<std::string> addresses = {};
};

// The system's present values; never queries the network.
ThisMachine LookUpThisMachine();

// The names of a machine with this hostname.
std::vector<std::string> NamesOf(const std::string& hostname);

}  // namespace cwm::server
