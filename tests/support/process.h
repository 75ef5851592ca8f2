// Runs the real binaries as a user's shell would.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace cwm::testing {

struct ProcessResult {
  int exit_code = -1;  // -1: killed by a signal
  std::string out;
  std::string err;
};

// Runs a program to its end with `input` on its stdin.
ProcessResult RunProgram(const std::vector<std::string>& arguments, const std::string& input = "");

// A temporary directory, removed with its owner.
class ScratchDirectory {
 public:
  ScratchDirectory();
  ~ScratchDirectory();
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

// A program running in the background; the destructor sends SIGTERM and waits.
class BackgroundProcess {
 public:
  BackgroundProcess(const std::vector<std::string>& arguments, const std::string& log_path);
  ~BackgroundProcess();
  BackgroundProcess(const BackgroundProcess&) = delete;
  BackgroundProcess& operator=(const BackgroundProcess&) = delete;

  bool Running() const;
  // The exit code after SIGTERM; -1 if it had to be killed.
  int Stop(int seconds = 15);
  void Signal(int signal) const;
  double ResidentMebibytes() const;
  pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = -1;
};

}  // namespace cwm::testing
