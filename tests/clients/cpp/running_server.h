// A real server on a real socket for the tests of the C++ client.
#pragma once

#include <gtest/gtest.h>

#include <csignal>
#include <memory>
#include <string>

#include "cwm/client.h"
#include "tests/support/process.h"

namespace cwm::testing {

// A restart loses its memory, as a server without a store does.
class RunningServer {
 public:
  RunningServer() { Start(); }
  ~RunningServer() { Stop(); }

  std::string address() const { return "unix:" + scratch_ / "cwm.sock"; }
  const ScratchDirectory& scratch() const { return scratch_; }
  void Start();
  void Stop();
  // It answers nothing while it is paused. Returns when all of its threads have stopped.
  void Pause();
  void Resume() { process_->Signal(SIGCONT); }

 private:
  ScratchDirectory scratch_;
  std::unique_ptr<BackgroundProcess> process_;
};

// One server for all tests of a suite, and a world of its own for each.
class ClientTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { server_ = std::make_unique<RunningServer>(); }
  static void TearDownTestSuite() { server_.reset(); }

  static RunningServer& server() { return *server_; }
  World Connect() const {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    return cwm::Connect({.address = server_->address(), .world = info->name()});
  }

 private:
  static inline std::unique_ptr<RunningServer> server_;
};

Eigen::Isometry3d At(double x, double y, double z);

// The error that `call` throws; fails the test if it throws none.
template <class Call>
Error ErrorOf(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "nothing was thrown";
  return Error(ErrorCode::kUnknown, "");
}

}  // namespace cwm::testing
