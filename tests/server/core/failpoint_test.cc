#include "server/core/failpoint.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

namespace cwm::server {
namespace {

// The signal that ended a child which passes the place three times; 0 if it ended by itself.
int SignalOfChild(const char* set, const char* place) {
  const pid_t child = fork();
  if (child == 0) {
    if (!SetFailPoint(set)) _exit(1);
    for (int i = 0; i < 3; ++i) FailPoint(place);
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

TEST(FailPoint, KillsAtThePassThatIsSet) {
  EXPECT_EQ(SignalOfChild("after-commit:3", "after-commit"), SIGKILL);
  EXPECT_EQ(SignalOfChild("after-commit:4", "after-commit"), 0);
  EXPECT_EQ(SignalOfChild("after-commit:1", "before-record"), 0);
}

TEST(FailPoint, RefusesWhatNamesNoPass) {
  for (const char* text : {"", "backup", ":1", "backup:", "backup:0", "backup:-1", "backup:1x"}) {
    EXPECT_FALSE(SetFailPoint(text)) << text;
  }
}

}  // namespace
}  // namespace cwm::server
