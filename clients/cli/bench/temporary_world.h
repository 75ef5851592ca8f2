// A world that a benchmark creates, so that no other world is read or changed.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cpp/connection.h"

namespace cwm::cli {

// "cwm-bench-", the process id and a random number.
std::string TemporaryWorldName();

// Thirty boxes, cylinders, balls and capsules of 4 to 20 cm on and above a table of 1 m, the same
// on every machine.
std::vector<cwm::v1::Change> BenchScene();

// Removes the world in the end, but never another one that somebody created in its place.
class TemporaryWorld {
 public:
  // Creates the world by putting the objects of the changes into it. The connection must outlive
  // it.
  static absl::StatusOr<std::unique_ptr<TemporaryWorld>> Make(
      const client::Connection& connection, const std::string& name,
      const std::vector<cwm::v1::Change>& changes);
  ~TemporaryWorld();
  TemporaryWorld(const TemporaryWorld&) = delete;
  TemporaryWorld& operator=(const TemporaryWorld&) = delete;

  const std::string& name() const { return name_; }
  // Removes the world once; later calls and the destructor do nothing. OK also if somebody else
  // removed it.
  absl::Status Remove();

 private:
  TemporaryWorld(const client::Connection& connection, const std::string& name,
                 const std::string& uid)
      : connection_(connection), name_(name), uid_(uid) {}

  const client::Connection& connection_;
  std::string name_, uid_;
};

}  // namespace cwm::cli
