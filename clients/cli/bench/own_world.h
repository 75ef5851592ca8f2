// A world that a benchmark makes for itself, so that nobody's is read or changed.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cpp/connection.h"

namespace cwm::cli {

// "cwm-bench-", this process and a number that nobody else has.
std::string OwnWorldName();

// Thirty boxes, cylinders, balls and capsules of 4 to 20 cm on and above a table of 1 m, the same on
// every machine.
std::vector<cwm::v1::Change> BenchScene();

// Removes the world again: the one that it made, never one that somebody made in its place.
class OwnWorld {
 public:
  // Puts the objects of the changes into the world, which makes it. The connection must outlive it.
  static absl::StatusOr<std::unique_ptr<OwnWorld>> Make(
      const client::Connection& connection, const std::string& name,
      const std::vector<cwm::v1::Change>& changes);
  ~OwnWorld();
  OwnWorld(const OwnWorld&) = delete;
  OwnWorld& operator=(const OwnWorld&) = delete;

  const std::string& name() const { return name_; }
  // Once; later calls and the destructor do nothing. OK also when somebody else has removed it.
  absl::Status Remove();

 private:
  OwnWorld(const client::Connection& connection, const std::string& name, const std::string& uid)
      : connection_(connection), name_(name), uid_(uid) {}

  const client::Connection& connection_;
  std::string name_, uid_;
};

}  // namespace cwm::cli
