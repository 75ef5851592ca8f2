// Another user of this machine, for tests of who may do what. Only root can become one.
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>
#include <vector>

namespace cwm::testing {

constexpr uid_t kNobody = 65534;

bool MayBecomeOtherUser();

// A child of this process with the user and group `uid`, which calls `work` and ends. The child is
// a fork: `work` talks to sockets and files, and to nothing of the test's own threads.
class OtherUser {
 public:
  OtherUser(uid_t uid, std::function<std::string()> work);
  ~OtherUser();  // kills it when it has not ended
  OtherUser(const OtherUser&) = delete;
  OtherUser& operator=(const OtherUser&) = delete;

  // What `work` returned; empty when it threw, or did not return within 30 s.
  std::string Result();

 private:
  pid_t pid_ = -1;
  int output_ = -1;
};

// The command that runs a program as that user, without the variables that say where a server is.
std::vector<std::string> AsUser(uid_t uid, const std::vector<std::string>& command);

}  // namespace cwm::testing
