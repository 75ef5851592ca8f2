// What others call the machine that serves.
#pragma once

#include <string>
#include <vector>

namespace cwm::server {

struct ThisMachine {
  // Lower case, without those that every machine has: "robot", and "robot.local" as multicast DNS
  // tells it. No name that a stranger could register.
  std::vector<std::string> names = {};
  // Of its interfaces that are up, of IPv4 first; without loopback and without what needs the name
  // of an interface.
  std::vector<std::string> addresses = {};
};

// As the system says now; never asks the network.
ThisMachine LookUpThisMachine();

// The names of a machine that calls itself so.
std::vector<std::string> NamesOf(const std::string& hostname);

}  // namespace cwm::server
