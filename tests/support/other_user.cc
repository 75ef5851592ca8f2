#include "tests/support/other_user.h"

#include <grp.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <exception>
#include <stdexcept>

namespace cwm::testing {
namespace {

constexpr auto kPatience = std::chrono::seconds(30);

bool Become(uid_t uid) {
  return setgroups(0, nullptr) == 0 && setresgid(uid, uid, uid) == 0 &&
         setresuid(uid, uid, uid) == 0;
}

}  // namespace

bool CanBecomeOtherUser() { return geteuid() == 0; }

OtherUser::OtherUser(uid_t uid, std::function<std::string()> work) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) throw std::runtime_error("no pipe");
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("no child");
  if (pid_ == 0) {
    std::string text;
    try {
      if (Become(uid)) text = work();
    } catch (const std::exception&) {
      text.clear();
    }
    const ssize_t written = write(ends[1], text.data(), text.size());
    _exit(written == static_cast<ssize_t>(text.size()) ? 0 : 1);
  }
  close(ends[1]);
  output_ = ends[0];
}

OtherUser::~OtherUser() {
  close(output_);
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
}

std::string OtherUser::Result() {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  std::string text;
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        end - std::chrono::steady_clock::now());
    pollfd ready{.fd = output_, .events = POLLIN, .revents = 0};
    if (left.count() <= 0 || poll(&ready, 1, static_cast<int>(left.count())) != 1) return "";
    std::array<char, 4096> bytes{};
    const ssize_t size = read(output_, bytes.data(), bytes.size());
    if (size <= 0) return text;
    text.append(bytes.data(), static_cast<std::size_t>(size));
  }
}

std::vector<std::string> AsUser(uid_t uid, const std::vector<std::string>& command) {
  const std::string id = std::to_string(uid);
  std::vector<std::string> all = {"env",           "-u",      "XDG_RUNTIME_DIR", "-u",
                                  "CWM_ADDR",      "setpriv", "--reuid=" + id,   "--regid=" + id,
                                  "--clear-groups"};
  all.insert(all.end(), command.begin(), command.end());
  return all;
}

}  // namespace cwm::testing
