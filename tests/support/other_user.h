// Another user of this machine, for tests of permissions. Only root can become another user.
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>
#include <vector>

namespace cwm::testing {

constexpr uid_t kNobody = 65534;

bool CanBecomeOtherUser();

// A child process with the user and group `uid`, which calls `work` and ends. The child is a fork:
// `work` may use sockets and files, but none of the test's own threads.
class OtherUser {
 public:
  OtherUser(uid_t uid, std::function<std::string()> work);
  ~OtherUser();  // kills the child if it has not ended
  OtherUser(const OtherUser&) = delete;
  OtherUser& operator=(const OtherUser&) = delete;

  // The result of `work`; empty if it threw, or did not return within 30 s.
  std::string Result();

 private:
  pid_t pid_ = -1;
  int output_ = -1;
};

// The command that runs a program as that user, without the environment variables that give the
// server's address.
std::vector<std::string> AsUser(uid_t uid, const std::vector<std::string>& command);

}  // namespace cwm::testing
