// The programs of this build as other users of the machine run them.
#pragma once

#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/e2e/server_fixture.h"
#include "tests/support/other_user.h"

namespace cwm::testing {

// Copies of cwm and cwm-server that everybody can run, and two user ids that nobody else has.
class UserPrograms : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!CanBecomeOtherUser()) GTEST_SKIP() << "only root can become another user";
    ASSERT_EQ(chmod(scratch_.path().c_str(), 0755), 0);
    for (const char* name : {"cwm", "cwm-server"}) {
      std::filesystem::copy_file(Program(name), scratch_ / name);
      ASSERT_EQ(chmod((scratch_ / name).c_str(), 0755), 0);
    }
  }

  // `command` begins with the name of one of the two programs.
  std::vector<std::string> As(uid_t uid, std::vector<std::string> command) const {
    command.front() = scratch_ / command.front();
    return AsUser(uid, command);
  }
  ProcessResult Run(uid_t uid, const std::vector<std::string>& command) const {
    return RunProgram(As(uid, command));
  }

  const ScratchDirectory scratch_;
  const uid_t user_ = 1'000'000'000 + 2 * static_cast<uid_t>(getpid());
  const uid_t stranger_ = user_ + 1;
};

}  // namespace cwm::testing
