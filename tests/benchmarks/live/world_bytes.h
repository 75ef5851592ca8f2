// The published world and its history to the bit, for comparing runs.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "clients/cpp/connection.h"

namespace cwm::benchmarks {

// Without the identifiers that are drawn anew in each world.
struct WorldBytes {
  std::string revision;
  std::vector<std::string> objects;  // v1::Object, with surfaces and facts, by name
  std::vector<std::string> events;   // v1::ObjectEvent of each revision, from the first on

  bool operator==(const WorldBytes&) const = default;
};

// Empty if the world has no objects, or its history is not complete.
std::optional<WorldBytes> BytesOf(const client::Connection& connection, const std::string& world);

// The first difference in words.
std::string FirstDifference(const WorldBytes& a, const WorldBytes& b);

}  // namespace cwm::benchmarks
