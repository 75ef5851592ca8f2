// A real server on a real socket, driven by the real command line.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/process.h"

namespace cwm::testing {

// The programs of this build, from the environment that ctest sets.
std::string Program(const std::string& name);

class ServerTest : public ::testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;

  // Runs `cwm --addr SOCKET ARGUMENTS...`.
  Finished Cwm(std::vector<std::string> arguments, const std::string& input = "") const;
  // The same with `-o json`; fails the test when the exit code is not 0.
  nlohmann::json CwmJson(std::vector<std::string> arguments, const std::string& input = "") const;

  // Writes a virtual scan into the scratch directory; returns its path. The truth lies beside it as
  // NAME.json.
  std::string Simulate(const std::string& name, const std::vector<std::string>& arguments) const;
  nlohmann::json Truth(const std::string& name) const;

  // The revision of a world, -1 where it is unknown.
  std::int64_t RevisionOf(const std::string& world) const;

  // Of a world that is there.
  std::string UidOf(const std::string& world) const;

  // A command that runs the program that is given to it; empty: none.
  virtual std::vector<std::string> Launcher() const { return {}; }

  // Where the viewer listens, as --viewer has it.
  virtual std::string viewer() const { return "off"; }
  // The port that the server says it shows the world at.
  int ViewerPort() const;

  std::string address() const { return "unix:" + scratch_ / "cwm.sock"; }
  const ScratchDirectory& scratch() const { return scratch_; }
  Background& server() { return *server_; }
  std::string ServerLog() const;

 private:
  ScratchDirectory scratch_;
  std::unique_ptr<Background> server_;
};

// x, y, z, qx, qy, qz, qw as the command line takes it.
std::string PoseArgument(const nlohmann::json& pose);

}  // namespace cwm::testing
