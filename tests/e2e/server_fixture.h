// A real server on a real socket, driven by the real command line.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/process.h"

namespace cwm::testing {

// The path of a program of this build, from the environment that ctest sets.
std::string Program(const std::string& name);

class ServerTest : public ::testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;

  // Runs `cwm --addr SOCKET ARGUMENTS...`.
  ProcessResult Cwm(std::vector<std::string> arguments, const std::string& input = "") const;
  // The same with `-o json`; fails the test if the exit code is not 0.
  nlohmann::json CwmJson(std::vector<std::string> arguments, const std::string& input = "") const;

  // Writes a virtual scan into the scratch directory and returns its path. Its ground truth is
  // beside it as NAME.json.
  std::string Simulate(const std::string& name, const std::vector<std::string>& arguments) const;
  nlohmann::json Truth(const std::string& name) const;

  // The revision of a world; -1 if it does not exist.
  std::int64_t RevisionOf(const std::string& world) const;

  // The uid of an existing world.
  std::string UidOf(const std::string& world) const;

  // A command that runs the program given to it; empty: none.
  virtual std::vector<std::string> Launcher() const { return {}; }

  // The value of --viewer.
  virtual std::string viewer() const { return "off"; }
  // The port of the viewer's address in the server's output.
  int ViewerPort() const;

  std::string address() const { return "unix:" + scratch_ / "cwm.sock"; }
  const ScratchDirectory& scratch() const { return scratch_; }
  BackgroundProcess& server() { return *server_; }
  std::string ServerLog() const;

 private:
  ScratchDirectory scratch_;
  std::unique_ptr<BackgroundProcess> server_;
};

// x, y, z, qx, qy, qz, qw in the form of the command line.
std::string PoseArgument(const nlohmann::json& pose);

}  // namespace cwm::testing
